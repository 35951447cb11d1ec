// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/solid_field.h"

#include <openvdb/tools/VolumeToMesh.h>
#include <algorithm>
#include <array>
#include <unordered_set>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "sim/base/parallel.h"
#include "sim/base/statistics.h"
#include "sim/bone/vdb/grids.h"

// OpenVDB's library instantiates this template; compiling it takes a minute.
extern template void openvdb::tools::VolumeToMesh::operator()(const openvdb::FloatGrid&);

namespace reamsim {
namespace {

constexpr int kBrickSide = FillBricks::kSide;
constexpr int kReach = 3;  // of the kernel: 2.5 standard deviations
constexpr int kGathered = kBrickSide + 2 * kReach;
constexpr float kAir = 0.5F;
constexpr float kBone = -0.5F;

using Kernel = std::array<float, 2 * kReach + 1>;
using Leaf = openvdb::FloatTree::LeafNodeType;

/// Convolves `kGathered` rows of `cells` values along the slowest axis into `kBrickSide` rows.
void smooth_rows(const Kernel& kernel, int cells, const float* in, float* out) {
  for (int row = 0; row < kBrickSide; ++row) {
    float* to = out + static_cast<std::ptrdiff_t>(row) * cells;
    std::fill(to, to + cells, 0.0F);
    for (int tap = 0; tap < static_cast<int>(kernel.size()); ++tap) {
      const float* from = in + static_cast<std::ptrdiff_t>(row + tap) * cells;
      const float weight = kernel[static_cast<std::size_t>(tap)];
      for (int i = 0; i < cells; ++i) to[i] += weight * from[i];
    }
  }
}

/// The field of one brick.
std::unique_ptr<Leaf> smoothed_leaf(const Occupancy& occupancy, const Kernel& kernel, const Vec3i& brick) {
  std::array<float, kGathered * kGathered * kGathered> fractions{};
  occupancy.gather(brick * kBrickSide - Vec3i::Constant(kReach), kGathered, fractions.data());
  std::array<float, kBrickSide * kGathered * kGathered> after_z{};
  smooth_rows(kernel, kGathered * kGathered, fractions.data(), after_z.data());
  std::array<float, kBrickSide * kBrickSide * kGathered> after_y{};
  for (int z = 0; z < kBrickSide; ++z) {
    smooth_rows(kernel, kGathered, after_z.data() + z * kGathered * kGathered,
                after_y.data() + z * kBrickSide * kGathered);
  }
  auto leaf = std::make_unique<Leaf>(vdb_coord(kBrickSide * brick), kAir, true);
  for (int z = 0; z < kBrickSide; ++z) {
    for (int y = 0; y < kBrickSide; ++y) {
      std::array<float, kBrickSide> row{};
      smooth_rows(kernel, 1, after_y.data() + kGathered * (y + kBrickSide * z), row.data());
      for (int x = 0; x < kBrickSide; ++x) {
        leaf->setValueOnly(Leaf::coordToOffset(openvdb::Coord(x, y, z)), 0.5F - row[static_cast<std::size_t>(x)]);
      }
    }
  }
  return leaf;
}

/// The common kind of the 27 bricks about this one, or kMixed.
Occupancy::Kind neighbourhood(const Occupancy& occupancy, const Vec3i& brick) {
  const Occupancy::Kind own = occupancy.kind(brick);
  bool alike = true;
  for_each_voxel(brick - Vec3i::Ones(), brick + Vec3i::Ones(),
                 [&](const Vec3i& near) { alike = alike && occupancy.kind(near) == own; });
  return alike ? own : Occupancy::Kind::kMixed;
}

}  // namespace

Occupancy::Occupancy(const Voxmap& voxmap, const FillBricks& fill)
    : voxmap_(voxmap), fill_(fill), bricks_{voxmap.grade.brick_dims()}, kinds_(bricks_.count(), Kind::kEmpty) {
  const std::vector<Vec3i> stored = voxmap.grade.stored_coords();
  parallel_items(stored.size(), [&](std::size_t i) { kinds_[bricks_.index(stored[i])] = classify(stored[i]); });
}

void Occupancy::update(const std::vector<Vec3i>& bricks) {
  for (const Vec3i& brick : bricks) kinds_[bricks_.index(brick)] = classify(brick);
}

Occupancy::Kind Occupancy::kind(const Vec3i& brick) const {
  return bricks_.contains(brick) ? kinds_[bricks_.index(brick)] : Kind::kEmpty;
}

Occupancy::Kind Occupancy::classify(const Vec3i& brick) const {
  const GradeBricks::Brick* grades = voxmap_.grade.brick(brick);
  if (grades == nullptr) return Kind::kEmpty;
  const FillBricks::Brick* fill = fill_.brick(brick);
  bool any_air = false;
  bool any_bone = false;
  for (std::size_t i = 0; i < grades->size(); ++i) {
    const bool bone = (*grades)[i] != 0;
    const int remaining = bone && fill != nullptr ? (*fill)[i] : FillBricks::kWhole;
    any_bone |= bone && remaining > 0;
    any_air |= !bone || remaining < FillBricks::kWhole;
    if (any_air && any_bone) return Kind::kMixed;
  }
  return any_bone ? Kind::kFull : Kind::kEmpty;
}

void Occupancy::gather(const Vec3i& lower, int side, float* out) const {
  gather_fractions({voxmap_, fill_}, lower, side, out);
}

SolidField::SolidField(const Occupancy& occupancy) : grid_(new ScalarGrid{make_float_grid(kAir)}) {
  // One brick around the bone: smoothing extends the field beyond the bone's bricks and the lattice.
  compute(occupancy, bricks_near_bone(occupancy.voxmap().grade));
}

void SolidField::update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks) {
  std::vector<Vec3i> touched;
  const BrickLattice padded{occupancy.brick_dims() + Vec3i::Constant(2)};
  std::unordered_set<std::size_t> seen;
  for (const Vec3i& brick : bricks) {
    for_each_voxel(brick - Vec3i::Ones(), brick + Vec3i::Ones(), [&](const Vec3i& near) {
      if (seen.insert(padded.index(near + Vec3i::Ones())).second) touched.push_back(near);
    });
  }
  compute(occupancy, touched);
}

void SolidField::compute(const Occupancy& occupancy, const std::vector<Vec3i>& bricks) {
  std::vector<std::unique_ptr<Leaf>> leaves(bricks.size());
  std::vector<Occupancy::Kind> kinds(bricks.size());
  Kernel kernel{};
  std::ranges::transform(gaussian_weights(kSmoothing_voxels, kReach), kernel.begin(),
                         [](double weight) { return static_cast<float>(weight); });
  parallel_items(bricks.size(), [&](std::size_t i) {
    kinds[i] = neighbourhood(occupancy, bricks[i]);
    if (kinds[i] == Occupancy::Kind::kMixed) leaves[i] = smoothed_leaf(occupancy, kernel, bricks[i]);
  });
  auto& tree = grid_->vdb->tree();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    if (leaves[i]) {
      tree.addLeaf(leaves[i].release());
    } else {
      tree.addTile(1, vdb_coord(kBrickSide * bricks[i]), kinds[i] == Occupancy::Kind::kFull ? kBone : kAir, false);
    }
  }
}

std::vector<float> SolidField::at(std::span<const Vec3> points) const {
  const auto accessor = grid_->vdb->getConstAccessor();
  std::vector<float> out;
  out.reserve(points.size());
  for (const Vec3& p : points) out.push_back(static_cast<float>(sample(accessor, vdb_point(p))));
  return out;
}

openvdb::FloatGrid::Ptr bricks_of(const openvdb::FloatGrid& field, const Vec3i& first, const Vec3i& last) {
  auto out = make_float_grid(field.background());
  auto from = field.getConstAccessor();
  for_each_voxel(first, last, [&](const Vec3i& brick) {
    const openvdb::Coord origin = vdb_coord(kBrickSide * brick);
    if (const Leaf* leaf = from.probeConstLeaf(origin)) {
      out->tree().addLeaf(new Leaf(*leaf));
    } else if (const float value = from.getValue(origin); value != field.background()) {
      out->tree().addTile(1, origin, value, false);
    }
  });
  return out;
}

IsoSurface extract_surface(const openvdb::FloatGrid& field, double level, openvdb::BoolGrid::ConstPtr where) {
  openvdb::tools::VolumeToMesh mesher(level, 0.0, false);
  if (where) mesher.setSurfaceMask(std::move(where));
  mesher(field);
  IsoSurface out;
  const auto& points = mesher.pointList();
  for (std::size_t i = 0; i < mesher.pointListSize(); ++i) {
    out.points.emplace_back(points[i].x(), points[i].y(), points[i].z());
  }
  const auto add = [&](const openvdb::Vec3I& triangle) {
    for (int corner = 0; corner < 3; ++corner) out.indices.push_back(triangle[corner]);
  };
  for (std::size_t pool = 0; pool < mesher.polygonPoolListSize(); ++pool) {
    const auto& polygons = mesher.polygonPoolList()[pool];
    for (std::size_t i = 0; i < polygons.numTriangles(); ++i) add(polygons.triangle(i));
    for (std::size_t i = 0; i < polygons.numQuads(); ++i) {
      const openvdb::Vec4I& q = polygons.quad(i);
      // Split along the shorter diagonal, which bends the surface less.
      const bool first = (points[q[0]] - points[q[2]]).lengthSqr() <= (points[q[1]] - points[q[3]]).lengthSqr();
      add(first ? openvdb::Vec3I(q[0], q[1], q[2]) : openvdb::Vec3I(q[0], q[1], q[3]));
      add(first ? openvdb::Vec3I(q[0], q[2], q[3]) : openvdb::Vec3I(q[1], q[2], q[3]));
    }
  }
  return out;
}

}  // namespace reamsim
