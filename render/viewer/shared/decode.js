// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Decodes what render/viewer/page.cpp encodes.
import { unzlibSync } from "fflate";

export function unpacked(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return unzlibSync(bytes);
}

// The `plane`th plane of 16-bit numbers, delta and zigzag encoded.
function numbers16(bytes, plane, count) {
  const out = new Uint16Array(count);
  let value = 0;
  for (let i = 0; i < count; ++i) {
    const code = bytes[2 * plane * count + i] | (bytes[(2 * plane + 1) * count + i] << 8);
    value += (code >> 1) ^ -(code & 1);
    out[i] = value;
  }
  return out;
}

// Poses of the tool: position in mm, quaternion and spin angle in radians, one each for every row of the curves.
export function posesOf(packed) {
  const bytes = unpacked(packed.bytes);
  const [low, high] = packed.box_mm;
  const column = (plane, from, size) => Float64Array.from(numbers16(bytes, plane, packed.count), (n) => from + (size * n) / 65535);
  const places = [0, 1, 2].map((axis) => column(axis, low[axis], high[axis] - low[axis]));
  const turns = [3, 4, 5, 6].map((plane) => column(plane, -1, 2));
  const spins = column(7, 0, 2 * Math.PI);
  return Array.from(spins, (spin, row) => ({ position: places.map((c) => c[row]), quaternion: turns.map((c) => c[row]), spin }));
}

// The bone over each reamed vertex in mm, one list for each time.
export function liftsOf(reaming) {
  const bytes = unpacked(reaming.bytes);
  const step = reaming.most_mm / 65535;
  return reaming.time_s.map((_, state) => Float32Array.from(numbers16(bytes, state, reaming.vertices), (n) => step * n));
}

// Three planes of numbers from the `first` on, interleaved.
function interleaved(bytes, first, count, Type, valueOf) {
  const out = new Type(3 * count);
  for (let part = 0; part < 3; ++part) {
    numbers16(bytes, first + part, count).forEach((n, i) => { out[3 * i + part] = valueOf(n, part); });
  }
  return out;
}

function corners(bytes, from, count) {
  const out = new Uint32Array(count);
  let at = from, next = 0;
  for (let i = 0; i < count; ++i) {
    let below = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = bytes[at++];
      below |= (byte & 127) << shift;
      if (byte < 128) break;
    }
    out[i] = next - below;
    if (below === 0) ++next;
  }
  return out;
}

// A mesh: positions in mm, depths, normals, attributes (reamed, density, ambient accessibility), triangle indices.
export function meshOf(packed, [low, high]) {
  const bytes = unpacked(packed.bytes);
  const count = packed.vertices;
  return {
    positions: interleaved(bytes, 0, count, Float32Array, (n, axis) => low[axis] + ((high[axis] - low[axis]) / 65535) * n),
    depths: numbers16(bytes, 3, count),
    normals: interleaved(bytes, 4, count, Int8Array, (n) => n - 127),
    attributes: interleaved(bytes, 7, count, Uint8Array, (n) => n),
    indices: corners(bytes, 20 * count, 3 * packed.triangles),
  };
}
