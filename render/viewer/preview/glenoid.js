// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What the surface of the bone says about a glenoid frame.
import { add, dot, length, minus, scaled, unit } from "./vector.js";

// The mean outward normal of the surface within `radius` mm of a point, without the far side of a thin bone. Null where
// there is no surface.
export function faceNormal(surface, point, radius = 10) {
  const { positions, normals } = surface;
  let guess = null;
  for (let round = 0; round < 3; ++round) {
    let sum = [0, 0, 0], count = 0;
    for (let i = 0; i < positions.length; i += 3) {
      const p = [positions[i] - point[0], positions[i + 1] - point[1], positions[i + 2] - point[2]];
      const away = length(p);
      if (away > radius) continue;
      const n = [normals[i], normals[i + 1], normals[i + 2]];
      if (guess !== null && dot(n, guess) < 0.5) continue;
      // At first the nearest surface alone decides which side is meant.
      sum = add(sum, n, guess === null ? Math.exp(-((away / 3) ** 2)) : 1);
      ++count;
    }
    if (count === 0 || length(sum) < 1e-9) return guess;
    guess = unit(sum);
  }
  return guess;
}

export function nearestSurface(surface, point) {
  let least = Infinity;
  const { positions } = surface;
  for (let i = 0; i < positions.length; i += 3) {
    least = Math.min(least, (positions[i] - point[0]) ** 2 + (positions[i + 1] - point[1]) ** 2 + (positions[i + 2] - point[2]) ** 2);
  }
  return Math.sqrt(least);
}

// Bone in a sphere round a point, on both sides of the plane through it, mm³; as sim/anatomy/frame_check.cpp has it.
export function nearbyBone(field, point, normal, radius) {
  const step = Math.max(Math.min(...field.lattice.spacing), radius / 15), reach = Math.floor(radius / step);
  let ahead = 0, behind = 0, sum = [0, 0, 0];
  for (let k = -reach; k <= reach; ++k) {
    for (let j = -reach; j <= reach; ++j) {
      for (let i = -reach; i <= reach; ++i) {
        const p = scaled([i, j, k], step);
        if (length(p) > radius || field.at(add(point, p)) < 127.5) continue;
        if (dot(p, normal) > 0) ++ahead;
        else ++behind;
        sum = add(sum, p);
      }
    }
  }
  return { ahead: ahead * step ** 3, behind: behind * step ** 3, outward: length(sum) > 1e-9 ? unit(scaled(sum, -1)) : null };
}

// Points in order round their middle, seen along `normal`.
export function inOrder(points, normal) {
  if (points.length < 3 || normal === null) return points;
  const middle = scaled(points.reduce((a, b) => add(a, b), [0, 0, 0]), 1 / points.length);
  const across = unit(Math.abs(normal[0]) < 0.8 ? [0, normal[2], -normal[1]] : [-normal[2], 0, normal[0]]);
  const other = [normal[1] * across[2] - normal[2] * across[1], normal[2] * across[0] - normal[0] * across[2], normal[0] * across[1] - normal[1] * across[0]];
  const angle = (p) => Math.atan2(dot(minus(p, middle), other), dot(minus(p, middle), across));
  return [...points].sort((a, b) => angle(a) - angle(b));
}
