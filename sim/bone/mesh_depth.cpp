// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_depth.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/base/error.h"
#include "sim/bone/vdb/mesh_distance.h"
#include "sim/bone/voxmap/lattice.h"

namespace reamsim {

namespace {

/// The least number of samples across a layer.
constexpr double kSamplesInLayer = 5;
/// Every voxel is sampled down to this depth, voxels, where the samples below are further apart.
constexpr double kNearVoxels = 3;
/// Sampled beyond the layer, so that its end lies between samples.
constexpr double kBeyond = 2;

/// The samples around a brick, for linear interpolation at its voxels.
class SamplesAround {
 public:
  SamplesAround(const openvdb::FloatTree& samples, const Vec3i& first_voxel, int ratio)
      : ratio_(ratio), first_(first_voxel / ratio) {
    for_each_voxel(Vec3i::Constant(kSide), [&](const Vec3i& v) {
      const Vec3i at = first_ + v;
      values_[place(v)] = samples.getValue({at.x(), at.y(), at.z()});
    });
  }

  /// The distance at a voxel of the brick, voxels.
  [[nodiscard]] float at(const Vec3i& voxel) const {
    const Vec3i lower = voxel / ratio_;
    const Vec3 fraction = (voxel - ratio_ * lower).cast<double>() / ratio_;
    double sum = 0;
    for_each_trilinear_weight(fraction, [&](const Vec3i& step, double weight) {
      sum += weight * double{values_[place(lower - first_ + step)]};
    });
    return static_cast<float>(ratio_ * sum);
  }

 private:
  static constexpr int kSide = BrickLattice::kSide / 2 + 1;  // samples are at least two voxels apart

  static std::size_t place(const Vec3i& v) { return static_cast<std::size_t>(v.x() + kSide * (v.y() + kSide * v.z())); }

  int ratio_;
  Vec3i first_;
  std::array<float, std::size_t{kSide} * kSide * kSide> values_{};
};

}  // namespace

MeshDepth::MeshDepth(const std::string& path, const TriangleMesh& mesh, const VoxelGrid& grid, double layer_voxels)
    : ratio_(std::max(1, static_cast<int>(layer_voxels / kSamplesInLayer))) {
  const DistanceSampling near{.first_mm = grid.center_mm({0, 0, 0}),
                              .spacing_mm = grid.voxel_mm,
                              .outer_spacings = kMarginVoxels - 1,
                              .inner_spacings = ratio_ == 1 ? layer_voxels + kBeyond : kNearVoxels};
  DistanceSampling deep = near;
  deep.spacing_mm = ratio_ * grid.voxel_mm;
  deep.inner_spacings = layer_voxels / ratio_ + kBeyond;
  try {
    near_ = mesh_distance(mesh, near);
    deep_ = ratio_ == 1 ? near_ : mesh_distance(mesh, deep);
  } catch (const std::bad_alloc&) {
    throw InputError({path, 0, 0}, "", "the distance field of the mesh does not fit into memory",
                     "increase bone.voxel_mm");
  } catch (const openvdb::Exception&) {
    throw InputError({path, 0, 0}, "", "the mesh cannot be voxelized", "give a closed surface");
  }
}

float MeshDepth::below(const Vec3& voxel) const {
  const Vec3 sample = voxel / ratio_;
  return static_cast<float>(ratio_) *
         openvdb::tools::BoxSampler::sample(deep_->tree(), openvdb::Vec3d(sample.x(), sample.y(), sample.z()));
}

void MeshDepth::of_brick(const Vec3i& brick, Distances& out) const {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  static_assert(Leaf::DIM == BrickLattice::kSide);
  const Vec3i first = BrickLattice::kSide * brick;
  const openvdb::Coord corner(first.x(), first.y(), first.z());
  const Leaf* leaf = near_->tree().probeConstLeaf(corner);
  const float all = leaf == nullptr ? near_->tree().getValue(corner) : 0;
  std::optional<SamplesAround> samples;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    const Vec3i v = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    float& distance = out[static_cast<std::size_t>(offset)];
    distance = leaf == nullptr ? all : leaf->getValue(Leaf::coordToOffset({v.x(), v.y(), v.z()}));
    if (!interpolated() || distance > -kNearVoxels) continue;
    if (!samples) samples.emplace(deep_->tree(), first, ratio_);
    distance = samples->at(first + v);
  }
}

}  // namespace reamsim
