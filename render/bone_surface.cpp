#include "render/bone_surface.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

#include "render/reamed_share.h"
#include "render/surface_smoothing.h"
#include "sim/base/parallel.h"

namespace reamsim {
namespace {

using Accessor = openvdb::FloatGrid::ConstAccessor;
using openvdb::Vec3d;

constexpr std::size_t kGrain = 2048;
constexpr int kNormalRounds = 36;      // reaches about six voxels
constexpr float kBelow_voxels = 1.2F;  // where a vertex's density is read
constexpr int kPointRounds = 12;
constexpr float kMostMove_voxels = 0.4F;
constexpr int kDepthRounds = 5;  // evens out the steps of the two voxel faces that a depth lies between
constexpr int kEdgeRounds = 6;   // takes the teeth off the reamed face's edge

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

/// What is found at each vertex, before it goes into the vertex buffer.
struct Findings {
  explicit Findings(std::size_t count) : normal(count), reamed(count), depth_mm(count) {}

  std::vector<Eigen::Vector3f> normal;
  std::vector<float> reamed;
  std::vector<float> depth_mm;
};

Findings look_at_vertices(const std::vector<openvdb::Vec3s>& points, double voxel_mm, const SolidField& field,
                          const UnreamedSurface& unreamed) {
  Findings out(points.size());
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Accessor now = field.grid().getConstAccessor();
    const Accessor before = unreamed.field().getConstAccessor();
    const Accessor depths = unreamed.depth().getConstAccessor();
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d p(points[i]);
      out.normal[i] = normal_at(now, p);
      out.reamed[i] = reamed_share(sample(before, p));
      const Vec3d in_depth_cells = unreamed.depth().transform().worldToIndex(p * voxel_mm);
      if (out.reamed[i] > 0) out.depth_mm[i] = static_cast<float>(std::max(0.0, sample(depths, in_depth_cells)));
    }
  });
  return out;
}

double deepest_mm(const Findings& found) {
  float deepest = 0;
  for (std::size_t i = 0; i < found.reamed.size(); ++i) {
    if (found.reamed[i] >= 1) deepest = std::max(deepest, found.depth_mm[i]);
  }
  return deepest;
}

/// Evens out what the voxels' steps have left in what was found, and in the points themselves.
void smooth(const Neighbours& neighbours, Findings& found, std::vector<Eigen::Vector3f>& points) {
  smooth_normals(neighbours, found.normal, kNormalRounds);
  smooth_values(neighbours, found.reamed, found.depth_mm, kDepthRounds);
  smooth_values(neighbours, std::vector<float>(points.size(), 1), found.reamed, kEdgeRounds);
  fit_to_normals(neighbours, found.normal, points, kPointRounds, kMostMove_voxels);
}

std::vector<Eigen::Vector3f> eigen_points(const IsoSurface& iso) {
  std::vector<Eigen::Vector3f> out;
  out.reserve(iso.points.size());
  for (const openvdb::Vec3s& p : iso.points) out.emplace_back(p.x(), p.y(), p.z());
  return out;
}

}  // namespace

BoneSurface make_bone_surface(const Voxmap& voxmap, const SolidField& field, const AmbientLight& ambient,
                              const UnreamedSurface& unreamed) {
  const IsoSurface iso = extract_surface(field.grid(), 0);
  const double voxel_mm = voxmap.grid.voxel_mm;
  BoneSurface out;
  out.indices = flat_indices(iso);
  Findings found = look_at_vertices(iso.points, voxel_mm, field, unreamed);
  out.deepest_mm = deepest_mm(found);
  std::vector<Eigen::Vector3f> points = eigen_points(iso);
  smooth(Neighbours(points.size(), out.indices), found, points);
  out.vertices.resize(points.size() * BoneSurface::kStride);
  parallel_ranges(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 mm = voxmap.grid.origin_mm + voxel_mm * (points[i].cast<double>() + Vec3::Constant(0.5));
      float* v = out.vertices.data() + i * BoneSurface::kStride;
      Eigen::Map<Eigen::Vector3f>{v} = mm.cast<float>();
      Eigen::Map<Eigen::Vector3f>{v + 3} = found.normal[i];
      v[6] = found.depth_mm[i];
      v[7] = found.reamed[i];
      v[8] = density_at(voxmap, points[i] - kBelow_voxels * found.normal[i]);
      v[9] = ambient.openness(points[i], found.normal[i]);
    }
  });
  return out;
}

}  // namespace reamsim
