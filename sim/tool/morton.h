// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#include "sim/base/geometry.h"

namespace reamsim {

// Morton codes of shell points on the host: 21 bits per axis interleaved into 63, x in bit 0, y in bit 1, z in bit 2.
// Up to kNarrowResolution they are the paper's codes (§3.3) of 10 bits per axis and fit into 32 bits.

/// Most cells per axis whose codes fit into 32 bits; the device then stores 4 bytes per point, else 8.
inline constexpr int kNarrowResolution = 1024;

/// Most cells per axis of a shell: the error of fixed-point positions is then below 2⁻¹¹ voxel (kernels/shared.h), and
/// a tool's shell has some 10⁸ points. Codes have room for 2²¹.
inline constexpr int kMaxShellResolution = 4096;

/// Spreads the low 21 bits of `value` so that two zero bits follow each.
constexpr std::uint64_t spread_bits(std::uint64_t value) {
  value &= 0x1fffffu;
  value = (value ^ (value << 32)) & 0x001f00000000ffffu;
  value = (value ^ (value << 16)) & 0x001f0000ff0000ffu;
  value = (value ^ (value << 8)) & 0x100f00f00f00f00fu;
  value = (value ^ (value << 4)) & 0x10c30c30c30c30c3u;
  value = (value ^ (value << 2)) & 0x1249249249249249u;
  return value;
}

/// The inverse of spread_bits: gathers bits 0, 3, 6 … 60.
constexpr std::uint32_t compact_bits(std::uint64_t code) {
  code &= 0x1249249249249249u;
  code = (code ^ (code >> 2)) & 0x10c30c30c30c30c3u;
  code = (code ^ (code >> 4)) & 0x100f00f00f00f00fu;
  code = (code ^ (code >> 8)) & 0x001f0000ff0000ffu;
  code = (code ^ (code >> 16)) & 0x001f00000000ffffu;
  code = (code ^ (code >> 32)) & 0x00000000001fffffu;
  return static_cast<std::uint32_t>(code);
}

/// Code of cell (x, y, z); each coordinate in 0…2²¹ − 1.
constexpr std::uint64_t morton_encode(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread_bits(x) | (spread_bits(y) << 1) | (spread_bits(z) << 2);
}

/// Cell (x, y, z) of a code.
inline Vec3i morton_decode(std::uint64_t code) {
  return {static_cast<int>(compact_bits(code)), static_cast<int>(compact_bits(code >> 1)),
          static_cast<int>(compact_bits(code >> 2))};
}

}  // namespace reamsim
