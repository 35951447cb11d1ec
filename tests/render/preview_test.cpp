// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scene/load_bone.h"

namespace reamsim {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// HU that rise by 10 per mm along x, and bone beyond x = 4 mm.
SegmentedScan ramp(const Vec3i& dims, const Vec3& spacing_mm) {
  SegmentedScan out;
  out.hu.lattice = {dims, spacing_mm, Vec3(-2, 5, 7)};
  out.hu.lattice.for_each([&](const Vec3i& voxel, std::size_t) {
    const double x = out.hu.lattice.center_mm(voxel).x();
    out.hu.value.push_back(static_cast<float>(10 * x));
    out.field.push_back(static_cast<float>(10 * (x - 4)));
  });
  return out;
}

TEST(PreviewVolume, KeepsAScanThatFits) {
  const SegmentedScan scan = ramp({10, 4, 3}, {1, 0.5, 2});
  const PreviewVolume volume = preview_of_scan(scan, 120);
  EXPECT_EQ(volume.lattice.dims, scan.hu.lattice.dims);
  EXPECT_EQ(volume.value, scan.hu.value);
}

TEST(PreviewVolume, AveragesALargeScanWithoutShiftingIt) {
  const SegmentedScan scan = ramp({41, 12, 9}, {0.5, 0.5, 1.5});
  const PreviewVolume volume = preview_of_scan(scan, 1000);
  EXPECT_LE(volume.lattice.size(), 1000);
  EXPECT_EQ(volume.lattice.spacing_mm.z(), 1.5) << "the coarsest axis comes last";
  EXPECT_NEAR(volume.lattice.bounds_mm().min.x(), scan.hu.lattice.bounds_mm().min.x(), 1e-12);
  volume.lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    // The last box may extend beyond the scan.
    if (voxel.x() + 1 == volume.lattice.dims.x()) return;
    EXPECT_NEAR(volume.value[at], 10 * volume.lattice.center_mm(voxel).x(), 1e-3);
    EXPECT_EQ(volume.bone[at] > 0, volume.lattice.center_mm(voxel).x() > 4);
  });
}

TEST(PreviewVolume, AScanWithoutSegmentationHasNoBone) {
  SegmentedScan scan = ramp({4, 4, 4}, {1, 1, 1});
  scan.field.clear();
  const PreviewVolume volume = preview_of_scan(scan, 64);
  EXPECT_THAT(volume.bone, IsEmpty());
  EXPECT_TRUE(volume_json(volume)["bone"].is_null());
}

Bone sphere(double voxel_mm) {
  BoneSettings settings;
  settings.voxel_mm = voxel_mm;
  settings.phantom.shape = PhantomShape::sphere;
  settings.phantom.radius_mm = 8;
  settings.surface_voxels = SurfaceVoxels::partial;
  Diagnostics report;
  return load_bone(settings, report);
}

TEST(PreviewVolume, AveragesAVoxmapWithoutLosingBone) {
  const Bone bone = sphere(0.25);
  const PreviewVolume volume = preview_of_voxmap(bone, 20'000);
  EXPECT_LE(volume.lattice.size(), 20'000);
  double bone_mm3 = 0;
  for (const float field : volume.bone) bone_mm3 += 0.5 * (1 + static_cast<double>(field)) * volume.lattice.voxel_mm3();
  EXPECT_NEAR(bone_mm3, bone.view().bone_mm3(), 0.01);
  // A cell in the middle is all bone of the phantom's density; the surface lies where half of a cell is bone.
  const Vec3i middle = volume.lattice.voxel_of(Vec3::Zero());
  EXPECT_NEAR(volume.value[volume.lattice.index(middle)], 1.8, 0.01);
  EXPECT_NEAR(volume.bone[volume.lattice.index(middle)], 1, 1e-5);
  volume.lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    const double away_mm = volume.lattice.center_mm(voxel).norm() - 8;
    if (std::abs(away_mm) < volume.lattice.spacing_mm.x()) return;
    EXPECT_EQ(volume.bone[at] > 0, away_mm < 0) << away_mm;
  });
}

TEST(PreviewPage, HoldsScenarioAndBoneAndAsksForNothing) {
  PreviewRequest request;
  request.scenario.bone.phantom.shape = PhantomShape::sphere;
  request.scenario.bone.voxel_mm = 1;
  request.scenario.tool.mesh = "no such reamer.stl";
  request.scenario.motion.plunge = PlungeSettings();
  request.text = "# </script> stays text\nversion: 2\n";
  request.file_name = "a.yaml";
  request.source = "<a>";
  Diagnostics report;
  const std::string page = preview_page(request, report);
  EXPECT_THAT(page, HasSubstr("<title>&lt;a&gt; "));
  EXPECT_THAT(page, HasSubstr("# \\u003c/script> stays text\\nversion: 2\\n"));
  EXPECT_THAT(page, HasSubstr("no such reamer.stl")) << "what stops a run is shown";
  EXPECT_THAT(page, HasSubstr("content=\"default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'"));
}

}  // namespace
}  // namespace reamsim
