// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What the surface of the bone says about a glenoid frame, and what would go wrong in a run.
import { add, cross, dot, length, minus, positionsOf, scaled, unit } from "./volume.js";

// The mean outward normal of the surface within `radius` mm of a point, without the far side of a thin bone; or null.
export function faceNormal(surface, point, radius = 10) {
  const positions = positionsOf(surface), normals = surface.getAttribute("normal").array;
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

function nearestSurface(surface, point) {
  let least = Infinity;
  const positions = positionsOf(surface);
  for (let i = 0; i < positions.length; i += 3) {
    least = Math.min(least, (positions[i] - point[0]) ** 2 + (positions[i + 1] - point[1]) ** 2 + (positions[i + 2] - point[2]) ** 2);
  }
  return Math.sqrt(least);
}

// Bone in a sphere round a point, on both sides of the plane through it, mm³; as sim/anatomy/frame_check.cpp has it.
function nearbyBone(field, point, normal, radius) {
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
  const other = cross(normal, across);
  const angle = (p) => Math.atan2(dot(minus(p, middle), other), dot(minus(p, middle), across));
  return [...points].sort((a, b) => angle(a) - angle(b));
}

// Each message has a `level`: problem or note.

const mm = (value) => `${value.toFixed(1)} mm`;

function frameWarnings({ bone, surface, glenoid, data, values: { side } }, say) {
  const away = nearestSurface(surface, glenoid.center);
  if (away > 10) say("problem", `The glenoid centre is ${mm(away)} from the surface of the bone; at most 10 mm are accepted.`);
  const round = nearbyBone(bone, glenoid.center, glenoid.axes[2], away + 8);
  if (round.ahead > 1.5 * round.behind) {
    say("problem", `The normal points into the bone: ${round.ahead.toFixed(0)} mm³ lie ahead of it, ${round.behind.toFixed(0)} mm³ behind it. Flip it.`);
  } else if (round.outward !== null && dot(round.outward, glenoid.axes[2]) < Math.cos((50 * Math.PI) / 180)) {
    say("note", "The normal is more than 50° away from the direction out of the bone.");
  }
  if (!data.anatomical) return;
  const left = glenoid.axes[2][0];
  if ((side === "left" && left < -0.1) || (side === "right" && left > 0.1)) {
    say("note", `The side is ${side}, but the normal points to the patient's ${left > 0 ? "left" : "right"}.`);
  }
  if (glenoid.axes[1][2] < -0.1) say("note", "The superior direction points down.");
}

// Where the reamer first meets the bone: the index of the pose or −1; and until then how near it comes.
export function contactOf({ reamer, glenoid, surface, bone }) {
  const spacing = Math.min(...bone.lattice.spacing);
  let first = -1, nearest = Infinity, startsInside = false;
  for (let k = 0; k < reamer.motion.poses.length && first < 0; ++k) {
    const pose = reamer.pose(k, glenoid);
    const away = reamer.leastDistance(pose, positionsOf(surface), 30);
    nearest = Math.min(nearest, away);
    // Half a voxel is what the coarse surface may be wrong by.
    if (k === 0) startsInside = away < -0.5 * spacing || bone.at(pose.origin) > 160;
    if (away <= 0) first = k;
  }
  return { first, nearest, startsInside };
}

function contactWarnings(contact, reamer, say) {
  if (contact.startsInside) {
    say("problem", "The reamer starts in bone: it would remove bone at once, without force. Move its start out of the bone.");
  } else if (contact.first < 0) {
    say("problem", `The reamer never meets the bone${contact.nearest < Infinity ? `; it comes as near as ${mm(contact.nearest)}` : ": it stays more than 30 mm away"}.`);
  } else {
    const { travel } = reamer;
    if (reamer.motion.contact !== null) say("fine", `The depth counts from the first contact, about ${mm(Math.abs(travel))} ${travel < 0 ? "before" : "beyond"} entry_mm.`);
    say("fine", `The reamer meets the bone at about ${reamer.motion.time_s[contact.first].toFixed(2)} s.`);
  }
}

export function warningsOf(model) {
  const out = [], { surface, glenoid, contact, values: { from, side, rim } } = model;
  const say = (level, text) => out.push({ level, text });
  if (model.seedMissed) say("problem", "The seed is in no bone: the largest piece is shown.");
  if (surface === null) {
    say("problem", "No bone is above the threshold.");
    return out;
  }
  if (glenoid === null) {
    const missing = from === "landmarks" ? "the glenoid centre, the trigonum spinae and the inferior angle" : "the glenoid centre, then the superior point";
    say("problem", `There is no glenoid frame yet: place ${missing}.`);
  } else frameWarnings(model, say);
  if (model.needsSide && side === null) say("problem", "The side is missing: choose left or right.");
  rim.forEach((point, i) => {
    const away = nearestSurface(surface, point);
    if (away > 5) say("problem", `Rim point ${i + 1} is ${mm(away)} from the surface of the bone; at most 5 mm are accepted.`);
  });
  if (rim.length > 0 && rim.length < 6) say("problem", `A rim needs at least 6 points; ${rim.length} are placed.`);
  if (contact !== null) contactWarnings(contact, model.reamer, say);
  return out;
}
