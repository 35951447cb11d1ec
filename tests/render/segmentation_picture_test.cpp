// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/figures.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/render/picture_file.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

constexpr int kSide = 20;

/// A square of bone in air, 10 voxels of 1 mm wide, from voxel 5 on.
ScanPlane square_plane(const std::string& name) {
  ScanPlane plane{.name = name,
                  .columns = kSide,
                  .rows = kSide,
                  .spacing_mm = {1, 1},
                  .through = {2, 2},
                  .left = "R",
                  .right = "L",
                  .top = "A",
                  .bottom = "P",
                  .hu = {},
                  .field = {}};
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const bool bone = column >= 5 && column < 15 && row >= 5 && row < 15;
      plane.hu.push_back(bone ? 1000.0F : -1000.0F);
      plane.field.push_back(bone ? 1.0F : -1.0F);
    }
  }
  return plane;
}

TEST(SegmentationPicture, OutlinesTheBoneWhereItsFieldEnds) {
  const TempDir dir;
  Segmentation segmentation;
  segmentation.method = "threshold";
  for (const char* name : {"axial", "coronal", "sagittal"}) segmentation.planes.push_back(square_plane(name));
  write_segmentation_picture(dir.path(), segmentation);
  const Picture picture = read_picture(dir.path() + "/segmentation.png");
  ASSERT_EQ(picture.width, 1920);
  // Three panels of 20 mm and four gaps of 24 px share the width.
  const double px_per_mm = (1920 - 4 * 24) / 60.0;
  const auto color = [&](int panel, double column, double row) {
    const double left = 24 + panel * (kSide * px_per_mm + 24);
    return picture.at(static_cast<int>(left + (column + 0.5) * px_per_mm),
                      static_cast<int>(44 + (row + 0.5) * px_per_mm));
  };
  for (int panel = 0; panel < 3; ++panel) {
    const Eigen::Vector3i inside = color(panel, 10, 8), air = color(panel, 1.5, 8), edge = color(panel, 4.5, 8);
    EXPECT_GT(inside.minCoeff(), 230) << panel;
    EXPECT_LT(air.maxCoeff(), 20) << panel;
    EXPECT_GT(edge[0] - edge[2], 60) << "orange, in panel " << panel << ": " << edge.transpose();
  }
}

TEST(SegmentationPicture, NoneWithoutPlanes) {
  const TempDir dir;
  write_segmentation_picture(dir.path(), Segmentation());
  EXPECT_FALSE(std::filesystem::exists(dir.path() + "/segmentation.png"));
}

}  // namespace
}  // namespace reamsim::test
