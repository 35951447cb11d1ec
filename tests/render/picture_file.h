// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace reamsim::test {

/// A PNG as it was written.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint32_t> pixels;  ///< 0x00RRGGBB, top row first

  /// Red, green, blue, 0…255.
  [[nodiscard]] Eigen::Vector3i at(int x, int y) const;
};

/// Reads a PNG with Cairo; width 0 when there is none.
Picture read_picture(const std::string& path);

/// The largest difference of a channel between two pictures of one size.
int largest_difference(const Picture& a, const Picture& b);

/// How different two pictures of one size look where they differ most: the mean difference (CIE 1976, ΔE) of the worst
/// hundredth of all squares of 8 pixels, each taken as its mean light. Text and edges that fall otherwise by a part of
/// a pixel count for little; 2.3 is what an eye just notices between large patches side by side.
double perceived_difference(const Picture& a, const Picture& b);

/// Warm and light, as bone is drawn; neither background nor colour map.
bool looks_like_bone(const Eigen::Vector3i& rgb);

}  // namespace reamsim::test
