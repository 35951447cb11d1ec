// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "sim/base/error.h"
#include "sim/bone/bone.h"

namespace reamsim::test {

inline BoneSettings phantom(PhantomShape shape, double voxel_mm) {
  BoneSettings settings;
  settings.source = BoneSource::phantom;
  settings.side = BodySide::left;
  settings.voxel_mm = voxel_mm;
  settings.phantom.shape = shape;
  return settings;
}

inline Bone make(const BoneSettings& settings) {
  Diagnostics report;
  return bone_from_phantom(settings, report);
}

/// The message of the InputError that `work` throws, one line; fails the test when it throws none.
inline std::string input_error(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

/// Grade of the voxel that holds a point of B; 0 outside the lattice.
inline int grade_at(const BoneView& bone, const Vec3& point_mm) {
  const Vec3i voxel = bone.voxmap.grid.voxel_of(point_mm);
  if (!bone.voxmap.grid.contains(voxel)) return 0;
  return bone.voxmap.grade.get(voxel);
}

/// Voxels of one grade.
inline std::int64_t count_grade(const BoneView& bone, int grade) {
  std::int64_t count = 0;
  for_each_bone_voxel(bone, [&](const Vec3i&, std::uint8_t its, std::uint16_t) { count += its == grade ? 1 : 0; });
  return count;
}

}  // namespace reamsim::test
