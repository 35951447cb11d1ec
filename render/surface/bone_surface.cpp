#include "render/surface/bone_surface.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

#include "render/surface/reamed_share.h"
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
static_assert(kNormalRounds + kPointRounds == kDressReach);
constexpr float kMostMove_voxels = 0.4F;
constexpr int kDepthRounds = 4;         // evens out the steps of the two voxel faces that a depth lies between
constexpr float kSurelyReamed = 0.99F;  // where material is less surely gone is the edge of what was reamed
constexpr int kEdgeRounds = 6;          // takes the teeth off the reamed face's edge

double sample(const Accessor& accessor, const Vec3d& point) {
  return openvdb::tools::BoxSampler::sample(accessor, point);
}

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

std::vector<Eigen::Vector3f> normals_at(const std::vector<openvdb::Vec3s>& points, const SolidField& field) {
  std::vector<Eigen::Vector3f> normals(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Accessor now = field.grid().getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) normals[i] = normal_at(now, Vec3d(points[i]));
  });
  return normals;
}

/// Depth at a point of the space of voxel indices times voxel_mm, by an accessor of unreamed.depth().
float depth_at(const UnreamedSurface& unreamed, const Accessor& depths, const Eigen::Vector3f& point_mm) {
  const Vec3d cell = unreamed.depth().transform().worldToIndex(Vec3d(point_mm.x(), point_mm.y(), point_mm.z()));
  return static_cast<float>(std::max(0.0, sample(depths, cell)));
}

/// What reaming did at each vertex.
struct Reaming {
  explicit Reaming(std::size_t count) : share(count), depth_mm(count) {}

  std::vector<float> share;  ///< how surely material is gone
  std::vector<float> depth_mm;
};

/// `iso`: where the field is zero, which the unreamed bone's field is to be compared with. `points`: where the vertices
/// have come to, or a depth would show the steps that they have left.
Reaming reaming_at(const IsoSurface& iso, const std::vector<Eigen::Vector3f>& points, double voxel_mm,
                   const UnreamedSurface& unreamed) {
  Reaming out(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Accessor before = unreamed.field().getConstAccessor();
    const Accessor depths = unreamed.depth().getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) {
      out.share[i] = reamed_share(sample(before, Vec3d(iso.points[i])));
      if (out.share[i] > 0) out.depth_mm[i] = depth_at(unreamed, depths, points[i] * static_cast<float>(voxel_mm));
    }
  });
  return out;
}

/// Evens out what the voxels' steps have left in what was found.
void smooth(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points, Reaming& reaming) {
  if (std::ranges::all_of(reaming.share, [](float share) { return share == 0; })) return;
  const std::vector<float> even = even_weights(neighbours, points);
  smooth_values(neighbours, even, reaming.share, reaming.depth_mm, kDepthRounds);
  smooth_values(neighbours, even, std::vector<float>(reaming.share.size(), 1), reaming.share, kEdgeRounds);
}

std::vector<Eigen::Vector3f> eigen_points(const IsoSurface& iso) {
  std::vector<Eigen::Vector3f> out;
  out.reserve(iso.points.size());
  for (const openvdb::Vec3s& p : iso.points) out.emplace_back(p.x(), p.y(), p.z());
  return out;
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

BoneSurface make_bone_surface(const BoneLook& look) {
  BoneSurface out = dress_surface(extract_surface(look.field.grid(), 0), look);
  complete(look, out);
  return out;
}

BoneSurface dress_surface(const IsoSurface& iso, const BoneLook& look) {
  const VoxelGrid& grid = look.voxmap.grid;
  BoneSurface out;
  out.indices = flat_indices(iso);
  std::vector<Eigen::Vector3f> points = eigen_points(iso);
  std::vector<Eigen::Vector3f> normals = normals_at(iso.points, look.field);
  const Neighbours neighbours(points.size(), out.indices);
  smooth_normals(neighbours, normals, kNormalRounds);
  fit_to_normals(neighbours, normals, points, kPointRounds, kMostMove_voxels);
  Reaming reaming = reaming_at(iso, points, grid.voxel_mm, look.unreamed);
  smooth(neighbours, points, reaming);
  out.vertices.resize(points.size() * BoneSurface::kStride);
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 mm = grid.origin_mm + grid.voxel_mm * (points[i].cast<double>() + Vec3::Constant(0.5));
      float* v = out.vertices.data() + i * BoneSurface::kStride;
      Eigen::Map<Eigen::Vector3f>{v} = mm.cast<float>();
      Eigen::Map<Eigen::Vector3f>{v + 3} = normals[i];
      v[6] = reaming.depth_mm[i];
      v[7] = reaming.share[i];
    }
  });
  return out;
}

void complete(const BoneLook& look, BoneSurface& surface) {
  for_each_vertex(look.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    const Eigen::Map<const Eigen::Vector3f> normal(v + 3);
    v[8] = density_at(look.voxmap, point - kBelow_voxels * normal);
    v[9] = look.ambient.openness(point, normal);
  });
  surface.deepest_mm = 0;
  const VoxelGrid& grid = look.voxmap.grid;
  const Vec3 first_center = grid.origin_mm + Vec3::Constant(0.5 * grid.voxel_mm);
  const Accessor depths = look.unreamed.depth().getConstAccessor();
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    if (v[7] <= kSurelyReamed) continue;
    const Eigen::Vector3f point_mm = (Eigen::Map<const Eigen::Vector3f>{v}.cast<double>() - first_center).cast<float>();
    surface.deepest_mm = std::max(surface.deepest_mm, double{depth_at(look.unreamed, depths, point_mm)});
  }
}

void renew_openness(const BoneLook& look, BoneSurface& surface) {
  for_each_vertex(look.voxmap.grid, surface, [&](float* v, const Eigen::Vector3f& point) {
    v[9] = look.ambient.openness(point, Eigen::Map<const Eigen::Vector3f>{v + 3});
  });
}

}  // namespace reamsim
