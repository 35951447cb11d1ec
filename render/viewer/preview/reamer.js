// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The reamer's envelope of revolution, its poses, and its distance from bone.
import { Quaternion, vector } from "../shared/scene.js";
import { add, cross, dot, length, minus, scaled, unit } from "./volume.js";

const kCell_mm = 0.25;

function segmentDistance(r, z, [ar, az], [br, bz]) {
  const dr = br - ar, dz = bz - az;
  const t = Math.min(1, Math.max(0, ((r - ar) * dr + (z - az) * dz) / (dr * dr + dz * dz || 1)));
  return Math.hypot(r - ar - t * dr, z - az - t * dz);
}

// Signed distance of (r, z) to a closed polygon, negative inside. Edges on the axis are no surface.
function profileDistance(points, r, z) {
  let least = Infinity, inside = false;
  points.forEach((a, i) => {
    const b = points[(i + 1) % points.length];
    if (a[0] > 1e-6 || b[0] > 1e-6) least = Math.min(least, segmentDistance(r, z, a, b));
    if (a[1] > z !== b[1] > z && r < a[0] + ((z - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) inside = !inside;
  });
  return inside ? -least : least;
}

// Lowest z of a closed polygon at radius r, the polygon included; Infinity where it has none.
function lowestZ(points, r) {
  let lowest = Infinity;
  points.forEach(([ar, az], i) => {
    const [br, bz] = points[(i + 1) % points.length];
    if (r < Math.min(ar, br) || r > Math.max(ar, br)) return;
    lowest = Math.min(lowest, ar === br ? Math.min(az, bz) : az + ((bz - az) * (r - ar)) / (br - ar));
  });
  return lowest;
}

export class Reamer {
  constructor(tool, motion) {
    this.points = tool.profile;
    this.radius = Math.max(...this.points.map(([r]) => r));
    this.low = Math.min(...this.points.map(([, z]) => z));
    this.high = Math.max(...this.points.map(([, z]) => z));
    this.reach = Math.max(...this.points.map(([r, z]) => Math.hypot(r, z)));
    this.motion = motion;
    this.travel = 0;  // by which a plunge that counts from its first contact moves along its axis; null: no contact
    this.lowest = Array.from({ length: 257 }, (_, i) => lowestZ(tool.profile, (this.radius * i) / 256));
    this.columns = Math.ceil((this.radius + 2) / kCell_mm) + 2;
    this.rows = Math.ceil((this.high - this.low + 4) / kCell_mm) + 2;
    this.table = new Float32Array(this.columns * this.rows);
    for (let row = 0, at = 0; row < this.rows; ++row) {
      for (let column = 0; column < this.columns; ++column, ++at) {
        this.table[at] = profileDistance(this.points, column * kCell_mm, this.low - 2 + row * kCell_mm);
      }
    }
  }

  // Signed distance of a point in the tool frame; beyond the table, that of its edge and the way to it.
  distance(x, y, z) {
    const r = Math.sqrt(x * x + y * y) / kCell_mm, h = (z - this.low + 2) / kCell_mm;
    const rc = Math.min(r, this.columns - 1.001), hc = Math.max(0, Math.min(h, this.rows - 1.001));
    const i = Math.floor(rc), j = Math.floor(hc), u = rc - i, v = hc - j, at = i + j * this.columns;
    const near = (1 - v) * ((1 - u) * this.table[at] + u * this.table[at + 1]) +
      v * ((1 - u) * this.table[at + this.columns] + u * this.table[at + this.columns + 1]);
    return near + kCell_mm * Math.hypot(r - rc, h - hc);
  }

  // The pose in the bone frame: origin and the tool's axes. Null where the motion needs a glenoid frame that is missing.
  pose(k, glenoid) {
    const [px, py, pz, qw, qx, qy, qz] = this.motion.poses[k];
    const [x, y, z] = this.travel ? add([px, py, pz], this.motion.contact.along, this.travel) : [px, py, pz];
    const turn = new Quaternion(qx, qy, qz, qw);
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => vector(axis).applyQuaternion(turn).toArray());
    if (this.motion.frame !== "glenoid") return { origin: [x, y, z], axes };
    if (glenoid === null) return null;
    const out = (v) => add(add(scaled(glenoid.axes[0], v[0]), glenoid.axes[1], v[1]), glenoid.axes[2], v[2]);
    return { origin: add(glenoid.center, out([x, y, z])), axes: axes.map(out) };
  }

  // Moves a plunge whose depth counts from the first contact with these points of the bone (x, y, z after one another):
  // a point meets the reamer after its way along the axis and the height of the reamer at its radius.
  startAtContact(glenoid, positions) {
    this.travel = 0;
    if (this.motion.contact === null) return;
    const pose = this.pose(0, glenoid);
    if (pose === null) return;
    const [ox, oy, oz] = pose.origin, [ax, ay, az] = pose.axes[2], most = this.radius * this.radius;
    let least = Infinity;
    for (let i = 0; i < positions.length; i += 3) {
      const x = positions[i] - ox, y = positions[i + 1] - oy, z = positions[i + 2] - oz;
      const along = -(x * ax + y * ay + z * az), across = x * x + y * y + z * z - along * along;
      if (across > most) continue;
      least = Math.min(least, along + this.lowest[Math.round((256 * Math.sqrt(Math.max(0, across))) / this.radius)]);
    }
    this.travel = least < Infinity ? least - this.motion.contact.approach_mm : null;
  }

  // Signed distance of a point in the bone frame.
  distanceAt(pose, point) {
    const p = minus(point, pose.origin);
    return this.distance(dot(p, pose.axes[0]), dot(p, pose.axes[1]), dot(p, pose.axes[2]));
  }

  // The least distance at a pose to points (x, y, z after one another) within `within` mm of the tool, else Infinity.
  leastDistance(pose, positions, within) {
    const [ox, oy, oz] = pose.origin, [a, b, c] = pose.axes;
    const far = (this.reach + within) ** 2;
    let least = Infinity;
    for (let i = 0; i < positions.length; i += 3) {
      const x = positions[i] - ox, y = positions[i + 1] - oy, z = positions[i + 2] - oz;
      if (x * x + y * y + z * z > far) continue;
      const u = a[0] * x + a[1] * y + a[2] * z, v = b[0] * x + b[1] * y + b[2] * z, w = c[0] * x + c[1] * y + c[2] * z;
      let near = this.distance(u, v, w);
      // The table is coarse at edges and at the bore, where the reamer touches first.
      if (Math.abs(near) < 2 * kCell_mm && near < least + kCell_mm) near = profileDistance(this.points, Math.hypot(u, v), w);
      if (near < least) least = near;
    }
    return least;
  }
}

// The glenoid frame from centre, normal and superior: axes as columns, superior made perpendicular to the normal. Null
// where something is missing or the directions are parallel.
export function frameOf(center, normal, superior) {
  if (center === null || normal === null || superior === null) return null;
  const z = unit(normal), across = minus(superior, scaled(z, dot(superior, z)));
  if (length(across) < 1e-3 || length(normal) < 1e-6) return null;
  const y = unit(across);
  return { center, axes: [cross(y, z), y, z] };
}

// The frame from landmarks: the normal is the Friedman axis, superior lies in the scapular plane away from the inferior
// angle, as sim/bone/glenoid_frame.cpp has it.
export function frameOfLandmarks({ center, trigonum, inferior }) {
  if (center === null || trigonum === null || inferior === null) return null;
  return frameOf(center, minus(center, trigonum), minus(center, inferior));
}
