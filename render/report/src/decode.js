// Undoes what render/report/mesh_data.cpp and markup.cpp do.
import { unzlibSync } from "fflate";

export function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

export function unpacked(base64) {
  return unzlibSync(bytesOf(base64));
}

function positions(bytes, count, [low, high]) {
  const out = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; ++axis) {
    const size = high[axis] - low[axis];
    let place = 0;
    for (let i = 0; i < count; ++i) {
      const code = bytes[2 * axis * count + i] | (bytes[(2 * axis + 1) * count + i] << 8);
      place = (place + ((code >> 1) ^ -(code & 1))) & 0xffff;
      out[3 * i + axis] = low[axis] + (size * place) / 65535;
    }
  }
  return out;
}

// `parts` planes of 8-bit differences, as the values themselves, interleaved.
function interleaved(bytes, from, count, parts, Type) {
  const out = new Type(parts * count);
  for (let part = 0; part < parts; ++part) {
    let value = 0;
    for (let i = 0; i < count; ++i) {
      value = (value + bytes[from + part * count + i]) & 255;
      out[parts * i + part] = value;
    }
  }
  return out;
}

function corners(bytes, from, count) {
  const out = new Uint32Array(count);
  let at = from;
  let next = 0;
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

// A mesh: places in mm, normals, what vertices are dressed in (depth, reamed, density, openness), corners.
export function meshOf(packed, box) {
  const bytes = unpacked(packed.bytes);
  const count = packed.vertices;
  return {
    positions: positions(bytes, count, box),
    normals: interleaved(bytes, 6 * count, count, 3, Int8Array),
    dress: interleaved(bytes, 9 * count, count, 4, Uint8Array),
    indices: corners(bytes, 13 * count, 3 * packed.triangles),
  };
}
