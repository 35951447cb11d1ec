#pragma once

#include <cstdint>

#include "sim/base/geometry.h"

namespace reamsim {

// Morton codes of shell points on the host: 10 bits per axis interleaved into 30 bits, x in bit 0, y in bit 1, z in
// bit 2 (paper §3.3). The device decodes them with rs_compact_bits of kernels/shared.h.

/// Most cells per axis that a code can tell apart.
inline constexpr int kMortonResolution = 1024;

/// Spreads the low 10 bits of `value` so that two zero bits follow each.
constexpr std::uint32_t spread_bits(std::uint32_t value) {
  value &= 0x3ffu;
  value = (value ^ (value << 16)) & 0xff0000ffu;
  value = (value ^ (value << 8)) & 0x0300f00fu;
  value = (value ^ (value << 4)) & 0x030c30c3u;
  value = (value ^ (value << 2)) & 0x09249249u;
  return value;
}

/// The inverse of spread_bits: gathers bits 0, 3, 6 … 27.
constexpr std::uint32_t compact_bits(std::uint32_t code) {
  code &= 0x09249249u;
  code = (code ^ (code >> 2)) & 0x030c30c3u;
  code = (code ^ (code >> 4)) & 0x0300f00fu;
  code = (code ^ (code >> 8)) & 0xff0000ffu;
  code = (code ^ (code >> 16)) & 0x000003ffu;
  return code;
}

/// Code of cell (x, y, z); each coordinate in 0…1023.
constexpr std::uint32_t morton_encode(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread_bits(x) | (spread_bits(y) << 1) | (spread_bits(z) << 2);
}

/// Cell (x, y, z) of a code.
inline Vec3i morton_decode(std::uint32_t code) {
  return {static_cast<int>(compact_bits(code)), static_cast<int>(compact_bits(code >> 1)),
          static_cast<int>(compact_bits(code >> 2))};
}

}  // namespace reamsim
