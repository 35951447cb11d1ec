// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/bone_faces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kGathered = RS_BRICK_SIDE + 2;  // a brick and one voxel around it
using Fractions = std::array<float, kGathered * kGathered * kGathered>;

/// The direction of the outward normal at a cell of gathered fractions; zero where they do not change.
Eigen::Vector3f outward_normal(const Fractions& fractions, const Vec3i& cell) {
  Eigen::Vector3f slope = Eigen::Vector3f::Zero();
  for_each_voxel(-Vec3i::Ones(), Vec3i::Ones(), [&](const Vec3i& step) {
    const Vec3i at = cell + step;
    const float fraction = fractions[index_in(Vec3i::Constant(kGathered), at)];
    const Vec3i weight = Vec3i::Constant(2) - step.cwiseAbs();
    for (int axis = 0; axis < 3; ++axis) {
      const int others = weight.prod() / weight[axis];
      slope[axis] -= static_cast<float>(step[axis] * others) * fraction;
    }
  });
  return slope;
}

bool has_face(std::uint8_t grade, std::uint16_t fill) {
  return grade != 0 && fill != 0 && fill != FillBricks::kWhole;
}

/// The faces of a brick by place; RS_NO_FACE where there is none.
std::vector<rs_i32> faces_of(const BoneView& bone, const Vec3i& brick) {
  std::vector<rs_i32> out;
  const FillBricks::Brick* fill = bone.fill_before.brick(brick);
  if (fill == nullptr) return out;
  const GradeBricks::Brick& grades = *bone.voxmap.grade.brick(brick);
  Fractions fractions{};
  gather_fractions({bone.voxmap, bone.fill_before}, RS_BRICK_SIDE * brick - Vec3i::Ones(), kGathered, fractions.data());
  out.assign(RS_BRICK_VOXELS, RS_NO_FACE);
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const auto i = static_cast<std::size_t>(offset);
    if (!has_face(grades[i], (*fill)[i])) continue;
    const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    const Eigen::Vector3f normal = outward_normal(fractions, voxel + Vec3i::Ones());
    out[static_cast<std::size_t>(rs_brick_offset(voxel.x(), voxel.y(), voxel.z()))] = packed_face((*fill)[i], normal);
  }
  return out;
}

}  // namespace

rs_i32 packed_face(std::uint16_t fill, const Eigen::Vector3f& normal) {
  const float largest = normal.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return RS_NO_FACE - RS_WHOLE_FILL + fill;
  const Eigen::Vector3f along = normal / largest;
  rs_i32 face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    face |= static_cast<rs_i32>(std::lround(RS_FACE_STEPS * (1 + along[axis]))) << (16 + RS_FACE_BITS * axis);
  }
  float n[3];
  rs_face_normal(face, n);
  const float outside = 1 - static_cast<float>(fill) / FillBricks::kWhole;
  for (int bit = 1 << 15; bit != 0; bit >>= 1) {  // the largest distance with at most this fraction outside
    if (rs_outside_fraction(n, rs_face_away(face | bit)) <= outside) face |= bit;
  }
  return face;
}

BoneFaces::BoneFaces(const BoneView& bone)
    : lattice_(BrickLattice::over(bone.voxmap.grid.dims)), number_of_brick_(lattice_.count(), -1) {
  const std::vector<Vec3i> stored = bone.voxmap.grade.stored_coords();
  parallel_in_order<std::vector<rs_i32>>(
      stored.size(), 1024, [&](std::size_t i, std::vector<rs_i32>& out) { out = faces_of(bone, stored[i]); },
      [&](std::size_t i, const std::vector<rs_i32>& found) {
        FaceBrick brick{};
        const std::size_t before = faces_.size();
        for (std::size_t place = 0; place < found.size(); ++place) {
          if (place % 32 == 0) brick.begin[place / 32] = static_cast<rs_u32>(faces_.size());
          if (found[place] == RS_NO_FACE) continue;
          brick.there[place / 32] |= 1U << (place % 32);
          faces_.push_back(found[place]);
        }
        if (faces_.size() == before) return;
        number_of_brick_[lattice_.index(stored[i])] = static_cast<rs_i32>(bricks_.size());
        bricks_.push_back(brick);
      });
}

rs_i32 BoneFaces::at(const Vec3i& voxel) const {
  const rs_i32 number = number_of_brick_[lattice_.index(BrickLattice::brick_of(voxel))];
  const FaceBrick* brick = number < 0 ? nullptr : &bricks_[static_cast<std::size_t>(number)];
  return rs_face_at(brick, faces_.data(), rs_brick_offset(voxel.x() & 7, voxel.y() & 7, voxel.z() & 7));
}

DeviceFaces upload_faces(const cl::Device& device, const BoneView& bone) {
  const BoneFaces faces(bone);
  std::vector<cl_int> number_of_slot;
  for_each_slot(bone.voxmap.grade, [&](const Vec3i& coord, const GradeBricks::Brick&) {
    number_of_slot.push_back(faces.number_of_brick_[faces.lattice_.index(coord)]);
  });
  return {cl::upload(device, number_of_slot, "the table of the bone's faces"),
          cl::upload(device, faces.bricks_, "the table of the bone's faces"),
          cl::upload(device, faces.faces_, "the bone's faces")};
}

std::size_t bone_faces_bytes(const BoneView& bone) {
  std::size_t bricks = 0, faces = 0;
  bone.fill_before.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(coord);
    const std::size_t before = faces;
    for (std::size_t i = 0; grades != nullptr && i < fill.size(); ++i) faces += has_face((*grades)[i], fill[i]) ? 1 : 0;
    if (faces > before) ++bricks;
  });
  return sizeof(cl_int) * bone.voxmap.grade.stored_bricks() + sizeof(FaceBrick) * std::max<std::size_t>(1, bricks) +
         sizeof(cl_int) * std::max<std::size_t>(1, faces);
}

}  // namespace reamsim
