// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/data_files.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>

namespace reamsim::test {

namespace {

constexpr int kSide = 20;

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::string block_voxels() {
  std::string bytes(std::size_t{2} * kSide * kSide * kSide, '\0');
  const auto in_block = [](int i) { return i >= 5 && i < 15; };
  std::size_t at = 0;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x, at += 2) {
        put<std::int16_t>(bytes, at, in_block(x) && in_block(y) && in_block(z) ? 1000 : -1000);
      }
    }
  }
  return bytes;
}

}  // namespace

std::string cube_stl(double side, int missing) {
  static constexpr std::array<std::array<int, 3>, 12> kTriangles{{{0, 2, 1},
                                                                  {1, 2, 3},
                                                                  {4, 5, 6},
                                                                  {5, 7, 6},
                                                                  {0, 1, 4},
                                                                  {1, 5, 4},
                                                                  {2, 6, 3},
                                                                  {3, 6, 7},
                                                                  {0, 4, 2},
                                                                  {2, 4, 6},
                                                                  {1, 3, 5},
                                                                  {3, 7, 5}}};
  std::ostringstream out;
  out << "solid cube\n";
  for (std::size_t i = 0; i + static_cast<std::size_t>(missing) < kTriangles.size(); ++i) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const int corner : kTriangles[i]) {
      out << "vertex " << side * (corner & 1) << " " << side * (corner >> 1 & 1) << " " << side * (corner >> 2) << "\n";
    }
    out << "endloop\nendfacet\n";
  }
  out << "endsolid cube\n";
  return out.str();
}

std::string binary_stl(unsigned facets, unsigned claimed) {
  constexpr std::size_t kHeader = 84, kFacet = 50;
  std::string bytes(kHeader + kFacet * facets, '\0');
  put<std::uint32_t>(bytes, 80, claimed);
  for (unsigned i = 0; i < facets; ++i) {
    const std::size_t at = kHeader + kFacet * i;
    put<float>(bytes, at + 12, static_cast<float>(i));
    put<float>(bytes, at + 24, static_cast<float>(i) + 1);
    put<float>(bytes, at + 40, 1.0F);
  }
  return bytes;
}

std::string nrrd_header(long side) {
  const std::string n = std::to_string(side);
  return "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: " + n + " " + n + " " + n +
         "\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\nendian: little\nencoding: raw\n"
         "space origin: (0,0,0)\n\n";
}

std::string block_nrrd() {
  return nrrd_header(kSide) + block_voxels();
}

std::string nifti_header(short side) {
  constexpr std::size_t kHeader = 352;
  std::string bytes(kHeader, '\0');
  put<std::int32_t>(bytes, 0, 348);
  put<std::int16_t>(bytes, 40, 3);
  for (std::size_t i = 0; i < 7; ++i) put<std::int16_t>(bytes, 42 + 2 * i, i < 3 ? side : std::int16_t{1});
  put<std::int16_t>(bytes, 70, 4);   // int16
  put<std::int16_t>(bytes, 72, 16);  // bits per voxel
  for (std::size_t i = 0; i < 4; ++i) put<float>(bytes, 76 + 4 * i, 1.0F);
  put<float>(bytes, 108, static_cast<float>(kHeader));
  put<float>(bytes, 112, 1.0F);
  bytes[123] = 2;                    // millimetres
  put<std::int16_t>(bytes, 254, 1);  // the affine below holds
  for (std::size_t i = 0; i < 3; ++i) put<float>(bytes, 280 + 20 * i, 1.0F);
  bytes.replace(344, 4, std::string("n+1\0", 4));
  return bytes;
}

std::string block_nifti() {
  return nifti_header(kSide) + block_voxels();
}

}  // namespace reamsim::test
