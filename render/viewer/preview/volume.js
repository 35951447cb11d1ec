// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Points, voxels on a lattice along the axes of the bone frame, the surface of a field, and live segmentation.
import { BufferAttribute, BufferGeometry, unpacked } from "../shared/scene.js";

// Points and directions as [x, y, z].
export const add = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
export const minus = (a, b) => add(a, b, -1);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a) => Math.sqrt(dot(a, a));
export const scaled = (a, factor) => [factor * a[0], factor * a[1], factor * a[2]];
export const unit = (a) => scaled(a, 1 / (length(a) || 1));
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const same = (a, b) => a === b || JSON.stringify(a) === JSON.stringify(b);
export const rounded = (a, digits) => a.map((v) => Number(v.toFixed(digits)) + 0);

// Undoes the differences of render/viewer/preview.cpp.
function summed(base64) {
  const bytes = unpacked(base64);
  for (let i = 1; i < bytes.length; ++i) bytes[i] += bytes[i - 1];  // modulo 256
  return bytes;
}

// `origin` is the centre of the first voxel; x varies fastest.
class Lattice {
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

function forEachVoxel({ dims }, visit) {
  for (let k = 0, at = 0; k < dims[2]; ++k) {
    for (let j = 0; j < dims[1]; ++j) {
      for (let i = 0; i < dims[0]; ++i, ++at) visit(at, i, j, k);
    }
  }
}

// A byte field on a lattice, 0 beyond it, interpolated linearly.
export class Field {
  constructor(lattice, bytes) { Object.assign(this, { lattice, bytes }); }

  at(point) {
    const { dims, steps } = this.lattice;
    const base = [0, 0, 0], part = [0, 0, 0];
    for (let axis = 0; axis < 3; ++axis) {
      const place = this.lattice.index(point, axis);
      if (!(place > -1 && place < dims[axis])) return 0;
      base[axis] = Math.floor(place);
      part[axis] = place - base[axis];
    }
    let sum = 0;
    for (let corner = 0; corner < 8; ++corner) {
      let weight = 1, index = 0;
      for (let axis = 0; axis < 3; ++axis) {
        const up = (corner >> axis) & 1, place = base[axis] + up;
        weight *= up ? part[axis] : 1 - part[axis];
        if (place < 0 || place >= dims[axis]) weight = 0;
        index += place * steps[axis];
      }
      if (weight > 0) sum += weight * this.bytes[index];
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
  forEachVoxel(lattice, (at, i, j, k) => {
    const box = coarse.at(Math.floor(i / by[0]), Math.floor(j / by[1]), Math.floor(k / by[2]));
    sums[box] += bytes[at];
    ++counts[box];
  });
  return { lattice: coarse, bytes: Uint8Array.from(sums, (sum, i) => Math.round(sum / counts[i])) };
}

// The isosurface of a byte field at 128, by surface nets (Gibson 1998, doi:10.1007/BFb0056277): one vertex per cell that
// the surface crosses, at the mean of the crossings of its edges.
const kLevel = 127.5;
const kEdges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

// With a layer of air on every side, which closes the surface where the lattice ends.
function padded({ lattice, bytes }) {
  const dims = lattice.dims.map((n) => n + 2), [nx, ny] = dims;
  const out = new Uint8Array(dims[0] * dims[1] * dims[2]);
  forEachVoxel(lattice, (at, i, j, k) => { out[i + 1 + nx * (j + 1 + ny * (k + 1))] = bytes[at]; });
  return { dims, out };
}

// The surface as a geometry of three: positions in mm, outward normals, triangles counter-clockwise seen from outside.
export function surfaceOf(field) {
  const { lattice } = field;
  const { dims: [nx, ny, nz], out: f } = padded(field);
  const layer = nx * ny;
  const corner = [0, 1, nx, nx + 1, layer, layer + 1, layer + nx, layer + nx + 1];
  const positions = [], indices = [];
  const vertex = [new Int32Array(layer), new Int32Array(layer)];  // of the cells of this layer and of the one below
  const value = new Uint8Array(8);
  let count = 0;
  for (let k = 0; k + 1 < nz; ++k) {
    const now = vertex[k & 1], below = vertex[(k + 1) & 1];
    for (let j = 0; j + 1 < ny; ++j) {
      for (let i = 0; i + 1 < nx; ++i) {
        const at = i + nx * j + layer * k;
        let mask = 0;
        for (let c = 0; c < 8; ++c) {
          value[c] = f[at + corner[c]];
          if (value[c] > kLevel) mask |= 1 << c;
        }
        if (mask === 0 || mask === 255) continue;
        let x = 0, y = 0, z = 0, crossings = 0;
        for (const [a, b] of kEdges) {
          if (((mask >> a) & 1) === ((mask >> b) & 1)) continue;
          const t = (kLevel - value[a]) / (value[b] - value[a]);
          x += (a & 1) + t * ((b & 1) - (a & 1));
          y += ((a >> 1) & 1) + t * (((b >> 1) & 1) - ((a >> 1) & 1));
          z += (a >> 2) + t * ((b >> 2) - (a >> 2));
          ++crossings;
        }
        positions.push(lattice.mm(i - 1 + x / crossings, 0), lattice.mm(j - 1 + y / crossings, 1), lattice.mm(k - 1 + z / crossings, 2));
        const cell = i + nx * j;
        now[cell] = count++;
        // A face round each of the three edges at the cell's first corner that the surface crosses.
        const inside = mask & 1;
        const face = (a, b, c, d) => {
          if (inside) { indices.push(a, b, c); indices.push(a, c, d); } else { indices.push(a, c, b); indices.push(a, d, c); }
        };
        if (j > 0 && k > 0 && ((mask >> 1) & 1) !== inside) face(now[cell], now[cell - nx], below[cell - nx], below[cell]);
        if (i > 0 && k > 0 && ((mask >> 2) & 1) !== inside) face(now[cell], below[cell], below[cell - 1], now[cell - 1]);
        if (i > 0 && j > 0 && ((mask >> 4) & 1) !== inside) face(now[cell], now[cell - 1], now[cell - 1 - nx], now[cell - nx]);
      }
    }
  }
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  geometry.setIndex(new BufferAttribute(new Uint32Array(indices), 1)).computeVertexNormals();
  geometry.computeBoundingBox();
  return geometry;
}

export const positionsOf = (surface) => surface?.getAttribute("position").array ?? [];

// --- what threshold, cuts and seed would segment, on a coarse copy of the scan. As sim/scan/segment.cpp: threshold, cuts, the
// piece with the seed, closing, holes filled

function isCutAway(ct, p) {
  for (const { center_mm: c, radius_mm } of ct.cut_spheres) {
    if ((p[0] - c[0]) ** 2 + (p[1] - c[1]) ** 2 + (p[2] - c[2]) ** 2 < radius_mm ** 2) return true;
  }
  return ct.cut_planes.some(({ point_mm: q, normal: n }) => (p[0] - q[0]) * n[0] + (p[1] - q[1]) * n[1] + (p[2] - q[2]) * n[2] > 0);
}

// Fills `label` from `start` over face neighbours where `open(at)`; calls it once per voxel, which must then be closed.
function flood(lattice, start, stack, open) {
  const [nx, ny, nz] = lattice.dims, layer = nx * ny;
  let top = 0, count = 0;
  stack[top++] = start;
  while (top > 0) {
    const at = stack[--top];
    ++count;
    const i = at % nx, j = Math.floor(at / nx) % ny, k = Math.floor(at / layer);
    if (i > 0 && open(at - 1)) stack[top++] = at - 1;
    if (i + 1 < nx && open(at + 1)) stack[top++] = at + 1;
    if (j > 0 && open(at - nx)) stack[top++] = at - nx;
    if (j + 1 < ny && open(at + nx)) stack[top++] = at + nx;
    if (k > 0 && open(at - layer)) stack[top++] = at - layer;
    if (k + 1 < nz && open(at + layer)) stack[top++] = at + layer;
  }
  return count;
}

// The pieces of the voxels where the mask is `value`, numbered from 1.
function piecesOf(lattice, mask, value, stack) {
  const label = new Uint16Array(lattice.size), sizes = [0];
  for (let at = 0; at < lattice.size; ++at) {
    if (mask[at] !== value || label[at] !== 0 || sizes.length > 65535) continue;
    const own = sizes.length;
    label[at] = own;
    sizes.push(flood(lattice, at, stack, (next) => {
      if (mask[next] !== value || label[next] !== 0) return false;
      label[next] = own;
      return true;
    }));
  }
  return { label, sizes };
}

// The piece at the voxel, else the one that most of the six rays from it meet first.
function pieceAround(lattice, label, seed) {
  const start = seed.map((s, axis) => lattice.nearest([s, s, s], axis));
  const own = label[lattice.at(...start)];
  if (own !== 0) return own;
  const hits = new Map();
  for (let axis = 0; axis < 3; ++axis) {
    for (const step of [-1, 1]) {
      const place = [...start];
      for (place[axis] += step; place[axis] >= 0 && place[axis] < lattice.dims[axis]; place[axis] += step) {
        const met = label[lattice.at(...place)];
        if (met === 0) continue;
        hits.set(met, (hits.get(met) ?? 0) + 1);
        break;
      }
    }
  }
  const [piece, count] = [...hits].sort((a, b) => b[1] - a[1])[0] ?? [0, 0];
  return count >= 5 ? piece : 0;
}

// The voxels with a neighbour in the mask, or, inverted, without one outside it.
function spread(lattice, mask, value) {
  const out = mask.slice(), { dims, steps } = lattice;
  forEachVoxel(lattice, (at, i, j, k) => {
    if (mask[at] === value) return;
    const place = [i, j, k];
    for (let axis = 0; axis < 3; ++axis) {
      if ((place[axis] > 0 && mask[at - steps[axis]] === value) || (place[axis] + 1 < dims[axis] && mask[at + steps[axis]] === value)) {
        out[at] = value;
        return;
      }
    }
  });
  return out;
}

function fillHoles(lattice, mask, stack) {
  const { label } = piecesOf(lattice, mask, 0, stack), outside = new Set(), { dims } = lattice;
  forEachVoxel(lattice, (at, i, j, k) => {
    const border = i === 0 || j === 0 || k === 0 || i + 1 === dims[0] || j + 1 === dims[1] || k + 1 === dims[2];
    if (border) outside.add(label[at]);
  });
  for (let at = 0; at < mask.length; ++at) if (!outside.has(label[at])) mask[at] = 1;
}

// The bone as a field: 128 at its surface, more inside; null where nothing remains. `ct` has the keys of the scenario;
// `scale` turns bytes into HU. `seedMissed`: the seed is in no bone.
export function liveMask({ lattice, bytes }, ct, scale) {
  const level = (ct.threshold_hu - scale.low) / scale.step;
  let mask = new Uint8Array(lattice.size);
  const stack = new Uint32Array(lattice.size);
  const cuts = ct.cut_spheres.length + ct.cut_planes.length > 0;
  const cut = (i, j, k) => cuts && isCutAway(ct, [lattice.mm(i, 0), lattice.mm(j, 1), lattice.mm(k, 2)]);
  forEachVoxel(lattice, (at, i, j, k) => { mask[at] = bytes[at] >= level && !cut(i, j, k) ? 1 : 0; });
  const { label, sizes } = piecesOf(lattice, mask, 1, stack);
  if (sizes.length === 1) return { field: null, seedMissed: false };
  const found = ct.seed_mm !== null && lattice.contains(ct.seed_mm) ? pieceAround(lattice, label, ct.seed_mm) : 0;
  const kept = found || sizes.indexOf(Math.max(...sizes)), seedMissed = ct.seed_mm !== null && found === 0;
  for (let at = 0; at < mask.length; ++at) mask[at] = label[at] === kept ? 1 : 0;
  if (ct.closing_mm >= 0.5 * Math.min(...lattice.spacing)) {
    mask = spread(lattice, spread(lattice, mask, 1), 0);
    if (cuts) forEachVoxel(lattice, (at, i, j, k) => { if (mask[at] !== 0 && cut(i, j, k)) mask[at] = 0; });
  }
  if (ct.fill_holes) fillHoles(lattice, mask, stack);
  // The isosurface of the threshold, where it bounds the mask.
  const field = new Uint8Array(lattice.size);
  const gain = (127 * scale.step) / 200;
  for (let at = 0; at < field.length; ++at) {
    const size = Math.min(127, Math.max(8, gain * Math.abs(bytes[at] - level)));
    field[at] = mask[at] !== 0 ? 128 + size : 127 - size;
  }
  return { field, seedMissed };
}
