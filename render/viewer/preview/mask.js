// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What threshold, cuts and seed would segment, on a coarse copy of the scan. As sim/scan/segment.cpp: threshold, cuts,
// the piece with the seed, closing, holes filled.

function isCutAway(ct, p) {
  for (const { center_mm: c, radius_mm } of ct.cut_spheres) {
    if ((p[0] - c[0]) ** 2 + (p[1] - c[1]) ** 2 + (p[2] - c[2]) ** 2 < radius_mm ** 2) return true;
  }
  return ct.cut_planes.some(({ point_mm: q, normal: n }) => (p[0] - q[0]) * n[0] + (p[1] - q[1]) * n[1] + (p[2] - q[2]) * n[2] > 0);
}

function forEachVoxel({ dims }, visit) {
  for (let k = 0, at = 0; k < dims[2]; ++k) {
    for (let j = 0; j < dims[1]; ++j) {
      for (let i = 0; i < dims[0]; ++i, ++at) visit(at, i, j, k);
    }
  }
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

function piecesOf(lattice, mask, stack) {
  const label = new Uint16Array(lattice.size), sizes = [0];
  for (let at = 0; at < lattice.size; ++at) {
    if (mask[at] === 0 || label[at] !== 0 || sizes.length > 65535) continue;
    const own = sizes.length;
    label[at] = own;
    sizes.push(flood(lattice, at, stack, (next) => {
      if (mask[next] === 0 || label[next] !== 0) return false;
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
  const outside = new Uint8Array(lattice.size), { dims } = lattice;
  const open = (next) => {
    if (mask[next] !== 0 || outside[next] !== 0) return false;
    outside[next] = 1;
    return true;
  };
  forEachVoxel(lattice, (at, i, j, k) => {
    const border = i === 0 || j === 0 || k === 0 || i + 1 === dims[0] || j + 1 === dims[1] || k + 1 === dims[2];
    if (border && open(at)) flood(lattice, at, stack, open);
  });
  for (let at = 0; at < mask.length; ++at) mask[at] = outside[at] === 0 ? 1 : 0;
}

// The bone as a field: 128 at its surface, more inside. `ct` has threshold_hu, cut_spheres, cut_planes, seed_mm,
// closing_mm and fill_holes; `scale` turns bytes into HU. Null where nothing remains; `seedMissed` where the seed is
// in no bone.
export function liveMask({ lattice, bytes }, ct, scale) {
  const level = (ct.threshold_hu - scale.low) / scale.step;
  let mask = new Uint8Array(lattice.size);
  const stack = new Uint32Array(lattice.size);
  const cuts = ct.cut_spheres.length + ct.cut_planes.length > 0;
  const cut = (i, j, k) => cuts && isCutAway(ct, [lattice.mm(i, 0), lattice.mm(j, 1), lattice.mm(k, 2)]);
  forEachVoxel(lattice, (at, i, j, k) => { mask[at] = bytes[at] >= level && !cut(i, j, k) ? 1 : 0; });
  const { label, sizes } = piecesOf(lattice, mask, stack);
  if (sizes.length === 1) return { field: null, seedMissed: false };
  let kept = sizes.indexOf(Math.max(...sizes));
  let seedMissed = false;
  if (ct.seed_mm !== null) {
    const found = lattice.contains(ct.seed_mm) ? pieceAround(lattice, label, ct.seed_mm) : 0;
    seedMissed = found === 0;
    if (!seedMissed) kept = found;
  }
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
