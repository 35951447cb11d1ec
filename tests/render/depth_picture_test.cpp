// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <set>

#include "render/pictures/contour_lines.h"
#include "render/pictures/figures.h"
#include "render/pictures/overlay.h"
#include "render/render.h"
#include "render/surface/bone_surface.h"
#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using test::Picture;
namespace fs = std::filesystem;

constexpr const char* kHeader = "x_mm,y_mm,before_z_mm,after_z_mm,depth_mm\n";

/// A round bone of 9 mm radius; inside 6 mm it is reamed by 1 mm on the left and 2 mm on the right, and through on a
/// square of 2 mm round (0, 3).
std::string map_text() {
  std::string text = kHeader;
  for (double y = -9.75; y < 10; y += 0.5) {
    for (double x = -9.75; x < 10; x += 0.5) {
      const double r = std::hypot(x, y);
      if (r > 9) continue;
      const double depth = r > 6 ? 0 : x < 0 ? 1 : 2;
      const bool through = std::abs(x) < 1 && std::abs(y - 3) < 1;
      const std::string after = through ? "" : std::to_string(0.1 * x - depth);
      text += std::to_string(x) + ',' + std::to_string(y) + ',' + std::to_string(0.1 * x) + ',' + after + ',' +
              std::to_string(depth) + '\n';
    }
  }
  return text;
}

DepthField::Sample sample(const DepthField& field, const Vec2& place_mm) {
  return field.at(field.along(0, place_mm.x()), field.along(1, place_mm.y()));
}

class DepthPicture : public ::testing::Test {
 protected:
  std::string file() const { return dir_.path() + "/depth_map.csv"; }
  void write(const std::string& text) const { std::ofstream(file(), std::ios::binary) << text; }
  void expect_complaint(const std::string& text, const std::string& about) const {
    write(text);
    try {
      const DepthField field(file());
      ADD_FAILURE() << "no complaint about " << about;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(about));
    }
  }

  test::TempDir dir_;
};

TEST_F(DepthPicture, ReadsItsRaster) {
  write(map_text());
  const DepthField field(file());
  EXPECT_NEAR(field.spacing_mm(), 0.5, 1e-6);
  EXPECT_DOUBLE_EQ(field.deepest_mm(), 2);
  EXPECT_NEAR(field.mean_mm(), 1.5, 1e-9);
  EXPECT_NEAR(field.area_mm2(), 36 * M_PI, 3);
  EXPECT_DOUBLE_EQ(sample(field, {-3, 0}).depth_mm, 1);
  EXPECT_DOUBLE_EQ(sample(field, {3, 0}).depth_mm, 2);
  EXPECT_NEAR(sample(field, {0, 0}).depth_mm, 1.5, 1e-6);
  EXPECT_NEAR(sample(field, {3, 0}).reamed, 1, 1e-3);
  EXPECT_DOUBLE_EQ(sample(field, {0, 3}).perforated, 1);
  EXPECT_DOUBLE_EQ(field.perforated_mm2(), 4);
  EXPECT_NEAR(sample(field, {7.5, 0}).reamed, 0, 0.05);
  EXPECT_NEAR(sample(field, {7.5, 0}).bone, 1, 0.05);
  EXPECT_DOUBLE_EQ(sample(field, {9.9, 9.9}).bone, 0);
  EXPECT_NEAR(field.normal_before(field.along(0, 2), field.along(1, 1)).x(), -0.1 / std::sqrt(1.01), 1e-6);
}

TEST_F(DepthPicture, ASpeckOfBoneBesideTheFaceDoesNotShrinkTheMap) {
  write(map_text());
  const DepthField alone(file());
  write(map_text() + "-14.75,14.25,0,0,0\n-14.25,14.25,0,0,0\n");
  const DepthField field(file());
  EXPECT_TRUE(field.shown_mm().isApprox(alone.shown_mm()));
  std::string piece = map_text();  // 3 mm wide
  for (int i = 0; i < 36; ++i) {
    piece += std::to_string(-14.75 + 0.5 * (i % 6)) + ',' + std::to_string(14.25 + 0.5 * (i / 6)) + ",0,0,0\n";
  }
  write(piece);
  EXPECT_NEAR(DepthField(file()).shown_mm().max().y(), 17, 1e-6) << "what is larger shows";
}

// Each column of a wide breach is taken up once: queued again by each of its neighbours they would fill the memory.
TEST_F(DepthPicture, ABreachThatReachesTheRimIsNoHoleHoweverWide) {
  constexpr int kSide = 1000;
  std::string text = "x_mm,y_mm,before_z_mm,after_z_mm,depth_mm\n";
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const bool bridge = i == kSide / 2 && j > kSide / 4;  // bone that parts the breach, not quite
      text += std::to_string(i) + "," + std::to_string(j) + (bridge ? ",0,-1,1\n" : ",0,,3\n");
    }
  }
  write(text);
  const DepthField field(file());
  EXPECT_EQ(field.perforated_mm2(), 0);
  EXPECT_EQ(field.deepest_mm(), 3);
}

// The columns are squares of half a millimetre: their own edges stand 0.14 and 0.13 mm off the circles, RMS.
TEST_F(DepthPicture, OutlinesAreRound) {
  write(map_text());
  const DepthField field(file());
  const auto outline = [&](double angle, double from_mm, double to_mm, const auto& inside) {
    for (int i = 0; i < 40; ++i) {
      const double middle_mm = 0.5 * (from_mm + to_mm);
      (inside(sample(field, middle_mm * Vec2(std::cos(angle), std::sin(angle)))) ? from_mm : to_mm) = middle_mm;
    }
    return from_mm;
  };
  double reamed_off_mm = 0;
  double bone_off_mm = 0;
  for (double angle = 0; angle < 2 * M_PI; angle += 0.01) {
    const double reamed_mm = outline(angle, 4, 8, [](const auto& s) { return s.reamed > 0.5 * s.bone; });
    const double bone_mm = outline(angle, 7, 9.9, [](const auto& s) { return s.bone > 0.5; });
    reamed_off_mm += 0.01 / (2 * M_PI) * (reamed_mm - 6) * (reamed_mm - 6);
    bone_off_mm += 0.01 / (2 * M_PI) * (bone_mm - 9) * (bone_mm - 9);
  }
  reamed_off_mm = std::sqrt(reamed_off_mm);
  bone_off_mm = std::sqrt(bone_off_mm);
  std::cout << "off by " << reamed_off_mm << " and " << bone_off_mm << " mm\n";
  EXPECT_LT(reamed_off_mm, 0.1);
  EXPECT_LT(bone_off_mm, 0.08);
}

TEST_F(DepthPicture, PatchesOfAColumnOrMoreStay) {
  using Columns = std::set<std::pair<int, int>>;
  const Columns cores{{5, 5}, {10, 10}, {11, 10}, {10, 11}};  // not reamed, where all round them is
  const Columns spots{{19, 5}, {19, 12}, {20, 13}};           // reamed, where nothing else is
  const Columns holes{{5, 16}, {19, 18}};                     // without bone
  const Columns islands{{26, 5}, {26, 12}, {27, 13}};         // of bone
  const auto bone = [&](int i, int j) { return (i < 23 && !holes.contains({i, j})) || islands.contains({i, j}); };
  const auto reamed = [&](int i, int j) {
    return bone(i, j) && ((i < 16 && !cores.contains({i, j})) || spots.contains({i, j}));
  };
  std::string text = kHeader;
  for (int j = 0; j < 24; ++j) {
    for (int i = 0; i < 30; ++i) {
      if (bone(i, j)) text += std::to_string(i) + ',' + std::to_string(j) + (reamed(i, j) ? ",0,-1,1\n" : ",0,0,0\n");
    }
  }
  write(text);
  const DepthField field(file());
  for (const Columns& patches : {cores, spots, holes, islands}) {
    for (const auto& [i, j] : patches) {
      const DepthField::Sample at = sample(field, Vec2(i, j));
      EXPECT_EQ(at.bone > 0.5, bone(i, j)) << i << ' ' << j;
      EXPECT_EQ(bone(i, j) && at.reamed > 0.5 * at.bone, reamed(i, j)) << i << ' ' << j;
    }
  }
}

// A core of five columns, a cross: its outline has to be nearer to a circle than the cross is, 0.27 columns RMS.
TEST_F(DepthPicture, ACoreOfFewColumnsIsRound) {
  std::string text = kHeader;
  for (int j = -12; j <= 12; ++j) {
    for (int i = -12; i <= 12; ++i) {
      text += std::to_string(i) + ',' + std::to_string(j) + (std::abs(i) + std::abs(j) > 1 ? ",0,-1,1\n" : ",0,0,0\n");
    }
  }
  write(text);
  const DepthField field(file());
  double sum = 0;
  double squares = 0;
  constexpr int kDirections = 90;
  for (int n = 0; n < kDirections; ++n) {
    const double angle = 2 * M_PI * n / kDirections;
    const auto core = [&](double radius) {
      const DepthField::Sample at = sample(field, radius * Vec2(std::cos(angle), std::sin(angle)));
      return at.reamed < 0.5 * at.bone;
    };
    double radius = 0;
    while (radius < 6 && core(radius)) radius += 0.01;
    sum += radius / kDirections;
    squares += radius * radius / kDirections;
  }
  std::cout << "radius " << sum << ", off by " << std::sqrt(squares - sum * sum) << " columns\n";
  EXPECT_NEAR(sum, std::sqrt(5 / M_PI), 0.4);
  EXPECT_LT(std::sqrt(squares - sum * sum), 0.12);
}

TEST_F(DepthPicture, ShowsDepthBoneHolesAndAir) {
  write_results(dir_.path(), {});
  write(map_text());
  write_depth_picture(dir_.path(), 4);
  const Picture shown = test::read_picture(dir_.path() + "/depth_map.png");
  ASSERT_EQ(shown.width, 1600);
  ASSERT_EQ(shown.height, 1080);
  const double px_per_mm = 0.95 * 1080 / 18;  // the bone's height
  const double middle = 0.5 * page_layout(1600, 1080).view_width_px;
  const auto color = [&](double x, double y) {
    return shown.at(static_cast<int>(middle + px_per_mm * x), static_cast<int>(540 - px_per_mm * y));
  };
  const auto expected = [](double fraction) -> Eigen::Vector3i {
    return (255 * depth_colors().at(fraction)).array().round().cast<int>();
  };
  EXPECT_LE((color(-3, 0.3) - expected(0.25)).cwiseAbs().maxCoeff(), 2);
  EXPECT_LE((color(3, 0.3) - expected(0.5)).cwiseAbs().maxCoeff(), 2);
  // Beside the contour line of the step between both depths.
  EXPECT_GT(color(0.6, 3).x(), 2 * color(0.6, 3).y()) << "a hole is red";
  EXPECT_TRUE(test::looks_like_bone(color(-7.5, 0)));
  EXPECT_GT(color(-8.6, 8.6).minCoeff(), 240) << "air";
}

TEST_F(DepthPicture, RimThatWasReamedAwayIsNoHole) {
  std::string text = kHeader;
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 12; ++i) {
      // Through: a strip from the left border to the middle, and one column by itself on the right.
      const bool through = (j == 6 && i < 6) || (j == 6 && i == 8);
      text += std::to_string(i) + ',' + std::to_string(j) + (through ? ",0,,2\n" : ",0,-1,1\n");
    }
  }
  write(text);
  const DepthField field(file());
  EXPECT_DOUBLE_EQ(sample(field, {5, 6}).perforated, 0);
  EXPECT_DOUBLE_EQ(sample(field, {8, 6}).perforated, 1);
  EXPECT_DOUBLE_EQ(field.perforated_mm2(), 1);
}

TEST_F(DepthPicture, NoneWithoutAMapOrADepth) {
  write_depth_picture(dir_.path(), 0);
  write(kHeader);
  write_depth_picture(dir_.path(), 0);
  write(std::string(kHeader) + "0.5,0.5,1,1,0\n1,0.5,1,1,0\n");
  write_depth_picture(dir_.path(), 0);
  EXPECT_FALSE(fs::exists(dir_.path() + "/depth_map.png"));
}

TEST_F(DepthPicture, DamagedMapsAreInputErrors) {
  expect_complaint("", "is empty");
  expect_complaint("x_mm,y_mm,before_z_mm,depth_mm\n", "1: after_z_mm: no such column");
  expect_complaint(std::string(kHeader) + "0,0,1,1\n", "2: found 4 cells; expected 5");
  expect_complaint(std::string(kHeader) + "0,0,,1,1\n", "2: before_z_mm: found ''");
  expect_complaint(std::string(kHeader) + "0,0,1,nan,1\n", "2: after_z_mm: found 'nan'");
  expect_complaint(std::string(kHeader) + "0,0,1,1,1\n0.000001,1000000,1,1,1\n1e6,0,1,1,0\n",
                   "do not lie on a regular grid");
}

}  // namespace
}  // namespace reamsim
