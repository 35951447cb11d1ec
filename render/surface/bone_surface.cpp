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
constexpr float kBelow_voxels = 1.2F;  // where a vertex's density is read
constexpr int kPointRounds = 2;
static_assert(kNormalRounds + kPointRounds == kAttributeReach);
constexpr float kMostMove_voxels = 0.4F;
constexpr int kDepthRounds = 4;         // smooths the steps of the two voxel faces that a depth lies between
constexpr float kSurelyReamed = 0.99F;  // where it is less certain is the edge of what was reamed
constexpr int kEdgeRounds = 6;          // takes the teeth off the reamed face's edge

/// Outward normal: the field's gradient over a wide step, which evens out what is left of the voxels' steps.
Eigen::Vector3f normal_at(const Accessor& field, const Vec3d& p) {
  constexpr double kStep = 1.6;
  Vec3d slope;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d step(0.0);
    step[axis] = kStep;
    slope[axis] = sample(field, p + step) - sample(field, p - step);
  }
  const double length = slope.length();
  if (length < 1e-9) return Eigen::Vector3f::UnitZ();
  return Eigen::Vector3d(slope.x() / length, slope.y() / length, slope.z() / length).cast<float>();
}

/// Density just below the surface: of the nearest bone voxels, weighted by nearness.
float density_at(const Voxmap& voxmap, const Eigen::Vector3f& inside) {
  const Eigen::Vector3f base = inside.array().floor();
  const Eigen::Vector3f t = inside - base;
  float sum = 0;
  float weights = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i corner = base.cast<int>() + Vec3i(i & 1, i >> 1 & 1, i >> 2);
    if (!voxmap.grid.contains(corner)) continue;
    const std::uint8_t grade = voxmap.grade.get(corner);
    if (grade == 0) continue;
    const float weight =
        ((i & 1) ? t.x() : 1 - t.x()) * ((i >> 1 & 1) ? t.y() : 1 - t.y()) * ((i >> 2) ? t.z() : 1 - t.z());
    sum += weight * static_cast<float>(DensityMapping::density_from_grade(grade));
    weights += weight;
  }
  return weights > 0 ? sum / weights : 0;
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

/// What reaming did at each vertex.
struct Reaming {
  explicit Reaming(std::size_t count) : fraction(count), depth_mm(count) {}

  std::vector<float> fraction;  ///< how certain it is that material was removed
  std::vector<float> depth_mm;
};

/// `iso`: where the field is zero, which the unreamed bone's field is to be compared with. `points`: where the vertices
/// have come to, or a depth would show the steps that they have left.
Reaming reaming_at(const IsoSurface& iso, const std::vector<Eigen::Vector3f>& points, double voxel_mm,
                   const UnreamedSurface& unreamed) {
  Reaming out(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const ReamingSampler sampler(unreamed);
    for (std::size_t i = begin; i < end; ++i) {
      out.fraction[i] = sampler.fraction(vdb_point(iso.points[i]));
      if (out.fraction[i] > 0) out.depth_mm[i] = sampler.depth_mm(vdb_point(points[i] * static_cast<float>(voxel_mm)));
    }
  });
  return out;
}

/// Smooths away what the voxels' steps have left in it.
void smooth(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points, Reaming& reaming) {
  if (std::ranges::all_of(reaming.fraction, [](float fraction) { return fraction == 0; })) return;
  const std::vector<float> even = mean_value_weights(neighbours, points);
  smooth_values(neighbours, even, reaming.fraction, reaming.depth_mm, kDepthRounds);
  smooth_values(neighbours, even, std::vector<float>(reaming.fraction.size(), 1), reaming.fraction, kEdgeRounds);
}

/// Calls action(a vertex's numbers, where it is in voxel index space).
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
  fit_to_normals(neighbours, normals, points, kPointRounds, kMostMove_voxels);
  Reaming reaming = reaming_at(iso, points, grid.voxel_mm, fields.unreamed);
  smooth(neighbours, points, reaming);
  out.vertices.resize(points.size() * BoneSurface::kStride);
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 mm = grid.origin_mm + grid.voxel_mm * (points[i].cast<double>() + Vec3::Constant(0.5));
      float* v = out.vertices.data() + i * BoneSurface::kStride;
      Eigen::Map<Eigen::Vector3f>{v} = mm.cast<float>();
      Eigen::Map<Eigen::Vector3f>{v + 3} = normals[i];
      v[6] = reaming.depth_mm[i];
      v[7] = reaming.fraction[i];
    }
  });
  return out;
}

void add_density_and_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    const Eigen::Map<const Eigen::Vector3f> normal(v + 3);
    v[8] = density_at(fields.voxmap, point - kBelow_voxels * normal);
    v[9] = fields.ambient.accessibility(point, normal);
  });
  surface.deepest_mm = 0;
  const VoxelGrid& grid = fields.voxmap.grid;
  const Vec3 first_center = grid.origin_mm + Vec3::Constant(0.5 * grid.voxel_mm);
  const ReamingSampler sampler(fields.unreamed);
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    if (v[7] <= kSurelyReamed) continue;
    const Eigen::Vector3f point_mm = (Eigen::Map<const Eigen::Vector3f>{v}.cast<double>() - first_center).cast<float>();
    surface.deepest_mm = std::max(surface.deepest_mm, double{sampler.depth_mm(vdb_point(point_mm))});
  }
}

void update_ambient(const BoneFields& fields, BoneSurface& surface) {
  for_each_vertex(fields.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    v[9] = fields.ambient.accessibility(point, Eigen::Map<const Eigen::Vector3f>{v + 3});
  });
}

}  // namespace reamsim
