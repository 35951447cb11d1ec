#include "render/gl/cut_face.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kMostTexels = 4096;  // on a side

/// Density of the bone that is left round a point (voxel index space): the mean over the eight nearest voxels, each
/// weighted by nearness and by how much of it is bone, so that air beside it does not thin the cut's edge.
float density_at(const Voxmap& voxmap, const FillBricks& fill, const Vec3& point) {
  const Vec3 base = point.array().floor();
  const Vec3 t = point - base;
  double sum = 0;
  double weights = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i corner = base.cast<int>() + Vec3i(i & 1, i >> 1 & 1, i >> 2);
    if (!voxmap.grid.contains(corner)) continue;
    const std::uint8_t grade = voxmap.grade.get(corner);
    if (grade == 0) continue;
    const double near =
        ((i & 1) ? t.x() : 1 - t.x()) * ((i >> 1 & 1) ? t.y() : 1 - t.y()) * ((i >> 2) ? t.z() : 1 - t.z());
    const double weight = near * fill.get(corner);
    sum += weight * DensityMapping::density_from_grade(grade);
    weights += weight;
  }
  return weights > 0 ? static_cast<float>(sum / weights) : 0.0F;
}

/// A rectangle in the cut plane: origin and two axes of length 1 mm, B.
struct Rectangle {
  Vec3 origin_mm;
  Vec3 across;
  Vec3 upward;
  Vec2 size_mm;
};

/// The part of the cut plane that lies in the picture and in the bone's box.
Rectangle visible_rectangle(const Aabb& bone, const Camera& camera) {
  const Vec3 normal = camera.cut_plane->head<3>();
  const Mat3 bone_from_eye = camera.eye_from_bone.linear().transpose();
  Rectangle out;
  out.across = (bone_from_eye.col(0) - normal.dot(bone_from_eye.col(0)) * normal).normalized();
  out.upward = out.across.cross(normal).normalized();
  if (out.upward.dot(bone_from_eye.col(1)) < 0) out.upward = -out.upward;
  // The picture's middle, moved along the view into the plane.
  const Vec3 eye = camera.eye_from_bone.inverse().translation();
  const Vec3 view = bone_from_eye.col(2);
  const Vec3 middle = eye - view * ((normal.dot(eye) + (*camera.cut_plane)(3)) / normal.dot(view));
  const double slant = std::max(0.2, std::abs(normal.dot(view)));
  const Vec2 half = 0.5 * camera.mm_per_px * Vec2(camera.width_px, camera.height_px) / slant;
  Vec2 low = Vec2::Constant(1e30);
  Vec2 high = Vec2::Constant(-1e30);
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1 ? bone.max : bone.min).x(), (i & 2 ? bone.max : bone.min).y(),
                      (i & 4 ? bone.max : bone.min).z());
    const Vec2 at((corner - middle).dot(out.across), (corner - middle).dot(out.upward));
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  low = low.cwiseMax(-half);
  high = high.cwiseMin(half);
  out.size_mm = high - low;
  out.origin_mm = middle + low.x() * out.across + low.y() * out.upward;
  return out;
}

}  // namespace

CutFace sample_cut_face(const Voxmap& voxmap, const FillBricks& fill, const SolidField& field, const Camera& camera) {
  const VoxelGrid& grid = voxmap.grid;
  Aabb box = grid.bounds_mm();
  box.min.array() -= 3 * grid.voxel_mm;
  box.max.array() += 3 * grid.voxel_mm;
  const Rectangle rectangle = visible_rectangle(box, camera);
  CutFace out;
  if ((rectangle.size_mm.array() <= 0).any()) return out;
  const double step_mm =
      std::max({camera.mm_per_px, 0.25 * grid.voxel_mm, rectangle.size_mm.maxCoeff() / (kMostTexels - 2)});
  out.width = static_cast<int>(std::ceil(rectangle.size_mm.x() / step_mm)) + 1;
  out.height = static_cast<int>(std::ceil(rectangle.size_mm.y() / step_mm)) + 1;
  const Vec3 across = out.width * step_mm * rectangle.across;
  const Vec3 upward = out.height * step_mm * rectangle.upward;
  out.corners_mm = {rectangle.origin_mm, rectangle.origin_mm + across, rectangle.origin_mm + across + upward,
                    rectangle.origin_mm + upward};
  out.texels.resize(static_cast<std::size_t>(out.width) * out.height * 2);
  parallel_items(static_cast<std::size_t>(out.height), [&](std::size_t row) {
    std::vector<Vec3> points;
    for (int column = 0; column < out.width; ++column) {
      const Vec3 mm = rectangle.origin_mm + step_mm * ((column + 0.5) * rectangle.across +
                                                       (static_cast<double>(row) + 0.5) * rectangle.upward);
      points.emplace_back((mm - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5));
    }
    const std::vector<float> fields = field.at(points);
    for (std::size_t column = 0; column < points.size(); ++column) {
      float* texel = out.texels.data() + 2 * (row * points.size() + column);
      texel[0] = fields[column] < 0.45F ? density_at(voxmap, fill, points[column]) : 0.0F;
      texel[1] = -fields[column];
    }
  });
  return out;
}

}  // namespace reamsim
