// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Voxels on a lattice along the axes of the bone frame. Points are [x, y, z] in mm.
import { unpacked } from "../shared/scene.js";

// Undoes the differences of render/viewer/preview_volume.cpp.
function summed(base64) {
  const bytes = unpacked(base64);
  let value = 0;
  for (let i = 0; i < bytes.length; ++i) {
    value = (value + bytes[i]) & 255;
    bytes[i] = value;
  }
  return bytes;
}

// `origin` is the centre of the first voxel; x varies fastest.
export class Lattice {
  constructor(dims, origin, spacing) {
    Object.assign(this, { dims, origin, spacing });
    this.steps = [1, dims[0], dims[0] * dims[1]];
    this.size = dims[0] * dims[1] * dims[2];
  }

  index(point, axis) { return (point[axis] - this.origin[axis]) / this.spacing[axis]; }
  nearest(point, axis) { return Math.min(this.dims[axis] - 1, Math.max(0, Math.round(this.index(point, axis)))); }
  mm(index, axis) { return this.origin[axis] + index * this.spacing[axis]; }
  low(axis) { return this.mm(-0.5, axis); }
  high(axis) { return this.mm(this.dims[axis] - 0.5, axis); }
  center() { return [0, 1, 2].map((axis) => 0.5 * (this.low(axis) + this.high(axis))); }
  clamped(point) { return point.map((p, axis) => Math.min(this.high(axis), Math.max(this.low(axis), p))); }
  contains(point) { return point.every((p, axis) => p >= this.low(axis) && p <= this.high(axis)); }
  at(i, j, k) { return i + this.steps[1] * j + this.steps[2] * k; }
}

// A byte field on a lattice, `outside` beyond it, interpolated linearly.
export class Field {
  constructor(lattice, bytes, outside = 0) { Object.assign(this, { lattice, bytes, outside }); }

  at(point) {
    const { dims, steps } = this.lattice;
    const base = [0, 0, 0], part = [0, 0, 0];
    for (let axis = 0; axis < 3; ++axis) {
      const place = this.lattice.index(point, axis);
      if (!(place > -1 && place < dims[axis])) return this.outside;
      base[axis] = Math.floor(place);
      part[axis] = place - base[axis];
    }
    let sum = 0;
    for (let corner = 0; corner < 8; ++corner) {
      let weight = 1, index = 0, inside = true;
      for (let axis = 0; axis < 3; ++axis) {
        const up = (corner >> axis) & 1, place = base[axis] + up;
        weight *= up ? part[axis] : 1 - part[axis];
        inside &&= place >= 0 && place < dims[axis];
        index += place * steps[axis];
      }
      if (weight > 0) sum += weight * (inside ? this.bytes[index] : this.outside);
    }
    return sum;
  }
}

// The volume of the page: `values` as bytes, and `bone` (128 at the surface, more inside) or null.
export function volumeOf(data) {
  const lattice = new Lattice(data.dims, data.origin_mm, data.spacing_mm);
  return { lattice, values: summed(data.values), bone: data.bone === null ? null : summed(data.bone), low: data.low, step: data.step, unit: data.unit };
}

// Means over boxes, so that at most `most` voxels remain; the axis with the finest spacing goes first.
export function reduced(lattice, bytes, most) {
  const by = [1, 1, 1];
  const dims = () => lattice.dims.map((n, axis) => Math.ceil(n / by[axis]));
  while (dims().reduce((a, b) => a * b) > most) {
    const spacing = lattice.spacing.map((mm, axis) => mm * by[axis]);
    ++by[spacing.indexOf(Math.min(...spacing))];
  }
  if (by.every((n) => n === 1)) return { lattice, bytes };
  const spacing = lattice.spacing.map((mm, axis) => mm * by[axis]);
  const origin = lattice.origin.map((mm, axis) => mm + 0.5 * (spacing[axis] - lattice.spacing[axis]));
  const coarse = new Lattice(dims(), origin, spacing);
  const sums = new Uint32Array(coarse.size), counts = new Uint16Array(coarse.size);
  for (let k = 0, at = 0; k < lattice.dims[2]; ++k) {
    for (let j = 0; j < lattice.dims[1]; ++j) {
      const row = coarse.at(0, Math.floor(j / by[1]), Math.floor(k / by[2]));
      for (let i = 0; i < lattice.dims[0]; ++i, ++at) {
        const box = row + Math.floor(i / by[0]);
        sums[box] += bytes[at];
        ++counts[box];
      }
    }
  }
  return { lattice: coarse, bytes: Uint8Array.from(sums, (sum, i) => Math.round(sum / counts[i])) };
}
