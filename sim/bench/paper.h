// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace reamsim::bench {

// Figures of the paper (Faieghi, Tutunea-Fatan and Eagleson 2020), measured on a GTX 970. Times in ms unless named
// otherwise, sizes in MB = 10⁶ bytes.

inline constexpr std::array<int, 5> kShells{64, 128, 256, 512, 1024};
inline constexpr std::array<int, 4> kVoxmaps{128, 256, 512, 1024};

/// Table 1, the proposed method: rows as kVoxmaps, columns as kShells.
inline constexpr double kPaperDirect[4][5] = {{0.19, 0.20, 0.23, 0.34, 0.76},
                                              {0.19, 0.21, 0.24, 0.34, 0.79},
                                              {0.20, 0.21, 0.24, 0.34, 0.79},
                                              {0.20, 0.21, 0.27, 0.36, 0.81}};
/// Table 3, Zheng et al.; 1024³ did not fit the card.
inline constexpr double kPaperOctree[3][5] = {
    {0.33, 0.34, 0.40, 0.68, 1.70}, {0.86, 0.89, 1.03, 1.22, 1.86}, {5.20, 5.14, 5.29, 5.52, 6.70}};
/// Table 5, Yau et al., by voxmap.
inline constexpr std::array<double, 4> kPaperImplicit{0.23, 0.5, 2.19, 13.67};

/// Table 4: rows as kShells.
inline constexpr double kPaperShellMb[5][2] = {{0.02, 0.05}, {0.07, 0.22}, {0.30, 0.89}, {1.19, 3.56}, {4.75, 14.26}};
/// Table 4: voxmaps 64³ … 1024³; the last does not exist for Zheng et al.
inline constexpr double kPaperVoxmapMb[5][2] = {
    {0.26, 1.31}, {2.10, 10.49}, {16.78, 83.89}, {134.22, 671.09}, {1073.74, -1}};

/// Points of the paper's shells (Zheng's MB of Table 4 over 12 bytes), and contacts of its severe case.
inline constexpr std::array<double, 5> kPaperPoints{4.2e3, 18e3, 74e3, 297e3, 1.19e6};
inline constexpr double kSeverePoints = 103'000;
inline constexpr double kLightPoints = 11'900;

/// Position in the axis of a table; nullopt where the paper has no such size.
template <std::size_t N>
constexpr std::optional<std::size_t> place(const std::array<int, N>& axis, int value) {
  for (std::size_t i = 0; i < N; ++i) {
    if (axis[i] == value) return i;
  }
  return std::nullopt;
}

/// The paper's time for the severe case of an engine; nullopt where it has none. `direct`, `octree` and `implicit` are
/// its three methods; `bricked` is compared with `direct`.
inline std::optional<double> paper_ms(std::string_view engine, int voxmap, int shell) {
  const auto row = place(kVoxmaps, voxmap);
  const auto column = place(kShells, shell);
  if (!row) return std::nullopt;
  if (engine == "implicit") return kPaperImplicit[*row];
  if (!column) return std::nullopt;
  if (engine == "octree")
    return *row < std::size(kPaperOctree) ? std::optional(kPaperOctree[*row][*column]) : std::nullopt;
  return kPaperDirect[*row][*column];
}

}  // namespace reamsim::bench
