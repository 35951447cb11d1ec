// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cmath>

#include "render/pictures/contour_lines.h"
#include "render/pictures/overlay.h"

namespace reamsim {
namespace {

constexpr double kSpacing_mm = 0.25;
constexpr double kRim_mm = 12;

/// A dome, 1.6 mm deep in the middle, that is reamed up to a circle of kRim_mm, with the steps of voxels in its depth
/// and a core of 1 mm radius.
struct Dome {
  RasterField depth_mm;
  std::vector<std::uint8_t> reamed;
};

double depth_at(double radius_mm) {
  return radius_mm < kRim_mm - 1 ? 1.6 - 0.06 * radius_mm : (1.6 - 0.06 * (kRim_mm - 1)) * (kRim_mm - radius_mm);
}

double radius_of(double depth_mm) {
  const double level = 1.6 - 0.06 * (kRim_mm - 1);
  return depth_mm > level ? (1.6 - depth_mm) / 0.06 : kRim_mm - depth_mm / level;
}

Dome make_dome() {
  Dome out{{{121, 121}, Vec2::Constant(-15.07), kSpacing_mm, {}}, {}};
  for (int j = 0; j < 121; ++j) {
    for (int i = 0; i < 121; ++i) {
      const double radius = out.depth_mm.place_mm(i, j).norm();
      const double steps_mm = 0.01 * ((i * 7 + j * 3) % 5 - 2);
      const bool reamed = radius < kRim_mm && radius > 1;
      out.reamed.push_back(reamed ? 1 : 0);
      out.depth_mm.values.push_back(reamed ? std::max(0.01, depth_at(radius) + steps_mm) : 0);
    }
  }
  return out;
}

// Each tick has one closed line: no gaps at the steep rim, no rings around the core.
TEST(DepthContours, OneClosedRoundLinePerTick) {
  const Dome dome = make_dome();
  const Scale scale = scale_up_to(1.5);
  const std::vector<ContourLine> lines = depth_contours(signed_depth(dome.depth_mm, dome.reamed), scale);
  ASSERT_EQ(lines.size(), static_cast<std::size_t>(std::lround(1.4 / scale.step)));
  for (const ContourLine& line : lines) {
    const double radius = radius_of(line.value);
    EXPECT_NEAR(line.length_mm(), 2 * M_PI * radius, 0.03 * 2 * M_PI * radius) << line.value;
    double widest_gap_mm = (line.points_mm.front() - line.points_mm.back()).norm();
    double squares = 0;
    for (std::size_t n = 0; n < line.points_mm.size(); ++n) {
      if (n > 0) widest_gap_mm = std::max(widest_gap_mm, (line.points_mm[n] - line.points_mm[n - 1]).norm());
      squares += std::pow(line.points_mm[n].norm() - radius, 2) / static_cast<double>(line.points_mm.size());
    }
    std::cout << line.value << " mm: off by " << std::sqrt(squares) << " mm RMS\n";
    EXPECT_LT(widest_gap_mm, kSpacing_mm) << line.value;
    EXPECT_LT(std::sqrt(squares), 0.25) << line.value;
  }
}

TEST(DepthContours, TheRimIsRoundDespiteItsColumns) {
  const Dome dome = make_dome();
  double rim_length_mm = 0;
  for (const ContourLine& line : contour_lines(signed_depth(dome.depth_mm, dome.reamed), 0)) {
    rim_length_mm = std::max(rim_length_mm, line.length_mm());
    if (line.length_mm() < 20) continue;  // the core
    for (const Vec2& p : line.points_mm) EXPECT_NEAR(p.norm(), kRim_mm, 0.15);
  }
  EXPECT_NEAR(rim_length_mm, 2 * M_PI * kRim_mm, 0.5);
}

TEST(DepthContours, NothingReamedHasNoLine) {
  Dome dome = make_dome();
  dome.reamed.assign(dome.reamed.size(), 0);
  EXPECT_TRUE(depth_contours(signed_depth(dome.depth_mm, dome.reamed), scale_up_to(1.5)).empty());
}

TEST(ContourNumbers, StandOnVisiblePartsAndApart) {
  Camera camera;
  camera.width_px = 1920;
  camera.height_px = 1080;
  std::vector<SeenContour> contours;
  for (const double radius : {200.0, 300.0, 305.0, 400.0}) {
    SeenContour& ring = contours.emplace_back();
    ring.text = "1.0";
    for (int n = 0; n < 360; ++n) {
      const double angle = n * M_PI / 180;
      ring.points_px.emplace_back(960 + radius * std::cos(angle), 540 + radius * std::sin(angle));
      ring.visible.push_back(n < 180);  // the lower half
    }
  }
  const auto numbers = place_contour_numbers(contours, camera, 1);
  ASSERT_EQ(numbers.size(), 2U) << "no room on the two lines that nearly touch";
  for (const ContourNumber& number : numbers) {
    EXPECT_GT(number.box_px.max().y(), 540);
  }
  EXPECT_EQ(numbers[0].contour, 0U);
  EXPECT_EQ(numbers[1].contour, 3U);
}

}  // namespace
}  // namespace reamsim
