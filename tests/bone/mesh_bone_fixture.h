// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gmock/gmock.h>

#include "bone_fixture.h"
#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

using ::testing::Contains;
using ::testing::HasSubstr;

/// Loads meshes from files as bones.
class MeshBone : public ::testing::Test {
 protected:
  BoneSettings settings_for(const TriangleMesh& mesh, double voxel_mm) const {
    BoneSettings settings;
    settings.source = BoneSource::mesh;
    settings.voxel_mm = voxel_mm;
    settings.mesh.path = dir_.path() + "/bone.stl";
    write_stl(settings.mesh.path, mesh);
    return settings;
  }
  FilledVoxmap load(const BoneSettings& settings) { return voxmap_from_mesh(settings, report_); }
  /// The message with which a mesh is refused.
  std::string refusal(const BoneSettings& settings) {
    return input_error([&] { load(settings); });
  }

  // Of the radiodensities that are the defaults.
  const int kCortical = DensityMapping::grade_from_density(DensityMapping().density_from_hu(1500));
  const int kTrabecular = DensityMapping::grade_from_density(DensityMapping().density_from_hu(300));
  TempDir dir_;
  Diagnostics report_;
};

}  // namespace reamsim::test
