// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The isosurface of a byte field at 128, by surface nets (Gibson 1998, doi:10.1007/BFb0056277): one vertex per cell that
// the surface crosses, at the mean of the crossings of its edges.
const kLevel = 127.5;
const kEdges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

// Grows to hold any number of values.
class Values {
  constructor(Type) { this.Type = Type; this.data = new Type(1 << 16); this.count = 0; }
  push(a, b, c) {
    if (this.count + 3 > this.data.length) {
      const larger = new this.Type(2 * this.data.length);
      larger.set(this.data);
      this.data = larger;
    }
    this.data[this.count++] = a;
    this.data[this.count++] = b;
    this.data[this.count++] = c;
  }
  all() { return this.data.slice(0, this.count); }
}

// With a layer of air on every side, which closes the surface where the lattice ends.
function padded({ lattice, bytes }) {
  const [nx, ny, nz] = lattice.dims;
  const dims = [nx + 2, ny + 2, nz + 2];
  const out = new Uint8Array(dims[0] * dims[1] * dims[2]);
  for (let k = 0; k < nz; ++k) {
    for (let j = 0; j < ny; ++j) {
      const from = lattice.at(0, j, k);
      out.set(bytes.subarray(from, from + nx), 1 + dims[0] * (j + 1 + dims[1] * (k + 1)));
    }
  }
  return { dims, out };
}

// Adds the normals of the triangles, by their area.
function normalsOf(positions, indices) {
  const normals = new Float32Array(positions.length);
  for (let t = 0; t < indices.length; t += 3) {
    const [a, b, c] = [3 * indices[t], 3 * indices[t + 1], 3 * indices[t + 2]];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const v of [a, b, c]) {
      normals[v] += nx;
      normals[v + 1] += ny;
      normals[v + 2] += nz;
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const size = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
    normals[v] /= size;
    normals[v + 1] /= size;
    normals[v + 2] /= size;
  }
  return normals;
}

// Positions in mm, outward normals, and triangles that are counter-clockwise seen from outside.
export function surfaceOf(field) {
  const { lattice } = field;
  const { dims: [nx, ny, nz], out: f } = padded(field);
  const layer = nx * ny;
  const corner = [0, 1, nx, nx + 1, layer, layer + 1, layer + nx, layer + nx + 1];
  const positions = new Values(Float32Array), indices = new Values(Uint32Array);
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
  const triangles = indices.all(), points = positions.all();
  return { positions: points, normals: normalsOf(points, triangles), indices: triangles };
}
