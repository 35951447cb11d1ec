// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/scene.h"

#include <algorithm>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr int kMaxTexels = 4096;  // on a side

/// A rectangle in the cut plane, B; `across` and `upward` are unit vectors.
struct Rectangle {
  Vec3 origin_mm;
  Vec3 across;
  Vec3 upward;
  Vec2 size_mm;
};

/// The part of the cut plane in the picture and in the bone's box.
Rectangle visible_rectangle(const Aabb& bone, const Camera& camera) {
  const Vec3 normal = camera.cut_plane->head<3>();
  const Mat3 bone_from_eye = camera.eye_from_bone.linear().transpose();
  Rectangle out;
  out.across = (bone_from_eye.col(0) - normal.dot(bone_from_eye.col(0)) * normal).normalized();
  out.upward = out.across.cross(normal).normalized();
  if (out.upward.dot(bone_from_eye.col(1)) < 0) out.upward = -out.upward;
  // The centre of the picture, projected along the view into the plane.
  const Vec3 eye = camera.eye_from_bone.inverse().translation();
  const Vec3 view = bone_from_eye.col(2);
  const Vec3 middle = eye - view * ((normal.dot(eye) + (*camera.cut_plane)(3)) / normal.dot(view));
  const double slant = std::max(0.2, std::abs(normal.dot(view)));
  const Vec2 half = 0.5 * camera.mm_per_px * Vec2(camera.width_px, camera.height_px) / slant;
  Eigen::AlignedBox2d extent;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = bone.corner(i);
    extent.extend(Vec2((corner - middle).dot(out.across), (corner - middle).dot(out.upward)));
  }
  const Vec2 low = extent.min().cwiseMax(-half);
  const Vec2 high = extent.max().cwiseMin(half);
  out.size_mm = high - low;
  out.origin_mm = middle + low.x() * out.across + low.y() * out.upward;
  return out;
}

/// The texels at most `reach` columns and rows from a marked one.
std::vector<std::uint8_t> dilated(const std::vector<std::uint8_t>& marked, int width, int height, int reach) {
  std::vector<std::uint8_t> out(marked.size(), 0);
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] == 0) continue;
    const int column = static_cast<int>(i) % width, row = static_cast<int>(i) / width;
    const int first = std::max(column - reach, 0), last = std::min(column + reach, width - 1);
    for (int line = std::max(row - reach, 0); line <= std::min(row + reach, height - 1); ++line) {
      std::fill_n(out.begin() + line * width + first, last - first + 1, std::uint8_t{1});
    }
  }
  return out;
}

/// Draws the boundary between the layers of a bone at its depth. `points` in voxel index space, row by row.
void draw_layers(const BoneFields& bone, const std::vector<Vec3>& points, double step_voxels, CutFace& face) {
  const LayerBoundary boundary(bone.voxmap, bone.unreamed, points.front(), points.back(),
                               points[static_cast<std::size_t>(face.width) - 1]);
  std::vector<std::uint8_t> mixed(points.size());
  parallel_items(points.size(), 4096, [&](std::size_t i) { mixed[i] = boundary.near(points[i]) ? 1 : 0; });
  const std::vector<std::uint8_t> near =
      dilated(mixed, face.width, face.height, static_cast<int>(std::ceil(1 / step_voxels)));
  parallel_items(points.size(), 256, [&](std::size_t i) {
    if (near[i] != 0 && face.texels[2 * i] > 0) {
      face.texels[2 * i] = static_cast<float>(boundary.density_at(points[i], step_voxels));
    }
  });
}

}  // namespace

CutFace sample_cut_face(const BoneFields& bone, const Camera& camera) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const Rectangle rectangle = visible_rectangle(grid.bounds_mm().expanded(3 * grid.voxel_mm), camera);
  CutFace out;
  if ((rectangle.size_mm.array() <= 0).any()) return out;
  const double step_mm =
      std::max({camera.mm_per_px, 0.25 * grid.voxel_mm, rectangle.size_mm.maxCoeff() / (kMaxTexels - 2)});
  out.width = static_cast<int>(std::ceil(rectangle.size_mm.x() / step_mm)) + 1;
  out.height = static_cast<int>(std::ceil(rectangle.size_mm.y() / step_mm)) + 1;
  const Vec3 across = out.width * step_mm * rectangle.across;
  const Vec3 upward = out.height * step_mm * rectangle.upward;
  out.corners_mm = {rectangle.origin_mm, rectangle.origin_mm + across, rectangle.origin_mm + across + upward,
                    rectangle.origin_mm + upward};
  out.texels.resize(static_cast<std::size_t>(out.width) * out.height * 2);
  // By fill, so that air does not reduce the density at the edge of the cut.
  const auto by_fill = [&](const Vec3i& voxel) { return static_cast<double>(bone.fill.get(voxel)); };
  // Only layers need all of them, 24 bytes per texel.
  std::vector<Vec3> all(bone.voxmap.layers ? out.texels.size() / 2 : 0);
  parallel_items(static_cast<std::size_t>(out.height), [&](std::size_t row) {
    std::vector<Vec3> points(static_cast<std::size_t>(out.width));
    for (std::size_t column = 0; column < points.size(); ++column) {
      const Vec3 mm = rectangle.origin_mm + step_mm * ((static_cast<double>(column) + 0.5) * rectangle.across +
                                                       (static_cast<double>(row) + 0.5) * rectangle.upward);
      points[column] = (mm - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5);
    }
    const std::vector<float> fields = bone.solid.at(points);
    for (std::size_t column = 0; column < points.size(); ++column) {
      float* texel = out.texels.data() + 2 * (row * points.size() + column);
      texel[0] =
          fields[column] < 0.45F ? static_cast<float>(mean_density<double>(bone.voxmap, points[column], by_fill)) : 0;
      texel[1] = -fields[column];
    }
    if (!all.empty()) std::ranges::copy(points, all.begin() + static_cast<std::ptrdiff_t>(row * points.size()));
  });
  if (bone.voxmap.layers) draw_layers(bone, all, step_mm / grid.voxel_mm, out);
  return out;
}

}  // namespace reamsim
