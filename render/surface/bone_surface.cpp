// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/bone_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/surface/scalar_grid.h"
#include "render/surface/surface_smoothing.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

using Accessor = openvdb::FloatGrid::ConstAccessor;
using openvdb::Vec3d;

constexpr std::size_t kGrain = 2048;
constexpr int kNormalRounds = 4;
constexpr float kDensityDepth_voxels = 1.2F;
constexpr int kPointRounds = 2;
static_assert(kNormalRounds + kPointRounds == kAttributeReach);
constexpr float kMaxDisplacement_voxels = 0.4F;
constexpr int kDepthRounds = 4;           // smooth the voxel steps of the depth
constexpr float kCertainlyReamed = 0.6F;  // below: the edge of the reamed face
constexpr int kProjectionSteps = 2;       // Newton's, to the surface
constexpr double kMaxProjection = 1;      // of a step, in gradients of the field
constexpr int kEdgeRounds = 2;            // smooth the edge of the reamed face where whole voxels are removed

/// Outward normal: the field's gradient over a step wide enough to average out voxel steps.
Eigen::Vector3f normal_at(const Accessor& field, const Vec3d& p) {
  const Vec3d slope = central_difference([&](const Vec3d& at) { return sample(field, at); }, p, 1.6);
  const double length = slope.length();
  if (length < 1e-9) return Eigen::Vector3f::UnitZ();
  return Eigen::Vector3d(slope.x() / length, slope.y() / length, slope.z() / length).cast<float>();
}

Vec3d vdb_point(const Eigen::Vector3f& p) {
  return {p.x(), p.y(), p.z()};
}

std::vector<Eigen::Vector3f> normals_at(const std::vector<Eigen::Vector3f>& points, const SolidField& field) {
  std::vector<Eigen::Vector3f> normals(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Accessor now = field.grid().vdb->getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) normals[i] = normal_at(now, vdb_point(points[i]));
  });
  return normals;
}

/// The point of the surface, where the field is zero, next to a point near it. Voxel index space.
Vec3d on_surface(const Accessor& field, Vec3d p) {
  const auto value = [&](const Vec3d& at) { return sample(field, at); };
  for (int step = 0; step < kProjectionSteps; ++step) {
    const Vec3d slope = central_difference(value, p, 0.5);
    p -= slope * std::clamp(value(p) / std::max(slope.lengthSqr(), 1e-4), -kMaxProjection, kMaxProjection);
  }
  return p;
}

/// Removal at each vertex. It is read on the surface: the fitted vertices lie beside it by a part of a voxel.
std::vector<Removal> removal_at(const std::vector<Eigen::Vector3f>& points, const BoneFields& fields) {
  std::vector<Removal> out(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const ReamingSampler sampler(fields.unreamed);
    const Accessor now = fields.solid.grid().vdb->getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d p = vdb_point(points[i]);
      if (sampler.removed(now, p) > 0) out[i] = sampler.removal(now, on_surface(now, p));
    }
  });
  return out;
}

/// Calls action(the floats of a vertex, its position in voxel index space).
template <typename Action>
void for_each_vertex(const VoxelGrid& grid, BoneSurface& surface, const Action& action) {
  parallel_ranges(surface.vertices.size() / BoneSurface::kStride, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float* v = surface.vertices.data() + i * BoneSurface::kStride;
      const Vec3 mm = Eigen::Map<const Eigen::Vector3f>{v}.cast<double>();
      const Eigen::Vector3f point =
          ((mm - grid.origin_mm) / grid.voxel_mm).cast<float>() - Eigen::Vector3f::Constant(0.5F);
      action(v, point);
    }
  });
}

}  // namespace

BoneFields::BoneFields(const Voxmap& bone, FillBricks fill_now, const UnreamedSurface& unreamed_surface)
    : voxmap(bone),
      fill(std::move(fill_now)),
      unreamed(unreamed_surface),
      occupancy(voxmap, fill),
      solid(occupancy),
      ambient(occupancy) {
  fill.take_changed();
}

std::vector<Vec3i> BoneFields::update() {
  std::vector<Vec3i> bricks = fill.take_changed();
  occupancy.update(bricks);
  solid.update(occupancy, bricks);
  ambient.update(occupancy, bricks);
  return bricks;
}

BoneSurface make_bone_surface(const BoneFields& fields) {
  BoneSurface out = add_vertex_attributes(extract_surface(*fields.solid.grid().vdb, 0), fields);
  add_density_and_ambient(fields, out);
  return out;
}

BoneSurface add_vertex_attributes(const IsoSurface& iso, const BoneFields& fields) {
  const VoxelGrid& grid = fields.voxmap.grid;
  BoneSurface out;
  out.indices = iso.indices;
  std::vector<Eigen::Vector3f> points = iso.points;
  std::vector<Eigen::Vector3f> normals = normals_at(iso.points, fields.solid);
  const Neighbours neighbours(points.size(), out.indices);
  smooth_normals(neighbours, normals, kNormalRounds);
  fit_to_normals(neighbours, normals, points, kPointRounds, kMaxDisplacement_voxels);
  Reaming reaming = reaming_at(removal_at(points, fields), fields.unreamed,
                               [&](std::size_t i) { return vdb_point(points[i] * static_cast<float>(grid.voxel_mm)); });
  reaming.smooth(neighbours, points, kDepthRounds, kEdgeRounds);
  out.vertices.resize(points.size() * BoneSurface::kStride);
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 mm = grid.origin_mm + grid.voxel_mm * (points[i].cast<double>() + Vec3::Constant(0.5));
      float* v = out.vertices.data() + i * BoneSurface::kStride;
      Eigen::Map<Eigen::Vector3f>{v} = mm.cast<float>();
      Eigen::Map<Eigen::Vector3f>{v + BoneSurface::kNormal} = normals[i];
      v[BoneSurface::kDepth] = reaming.depth_mm[i];
      v[BoneSurface::kReamed] = reaming.reamed[i];
    }
  });
  return out;
}

void add_density_and_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    const Eigen::Map<const Eigen::Vector3f> normal(v + BoneSurface::kNormal);
    const Eigen::Vector3f below = point - kDensityDepth_voxels * normal;
    v[BoneSurface::kDensity] = mean_density<float>(fields.voxmap, below, [](const Vec3i&) { return 1.0F; });
    v[BoneSurface::kAccessibility] = fields.ambient.accessibility(point, normal);
  });
  surface.deepest_mm = 0;
  const VoxelGrid& grid = fields.voxmap.grid;
  const Vec3 first_center = grid.origin_mm + Vec3::Constant(0.5 * grid.voxel_mm);
  const ReamingSampler sampler(fields.unreamed);
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    if (v[BoneSurface::kReamed] <= kCertainlyReamed) continue;
    const Eigen::Vector3f point_mm = (Eigen::Map<const Eigen::Vector3f>{v}.cast<double>() - first_center).cast<float>();
    surface.deepest_mm = std::max(surface.deepest_mm, double{sampler.depth_mm(vdb_point(point_mm))});
  }
}

void update_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    v[BoneSurface::kAccessibility] =
        fields.ambient.accessibility(point, Eigen::Map<const Eigen::Vector3f>{v + BoneSurface::kNormal});
  });
}

}  // namespace reamsim
