#include "sim/metrics/native_face.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

constexpr double kSlopeRadius_mm = 1.5;
/// The face is looked for this far above the highest point of the rim, and as deep below the lowest as a bowl of that
/// width could be, but no further than its inner radius.
constexpr double kAboveRim_mm = 3;

/// The face's heights over a raster in the outline's plane.
class FaceRaster {
 public:
  FaceRaster(const ReamedBone& bone, const FaceOutline& outline) : outline_(outline) {
    const Aabb& box = outline.box_mm();
    const double voxel_mm = bone.voxmap.grid.voxel_mm;
    pitch_mm_ = std::max({voxel_mm, kFacePitch_mm, (box.max - box.min).head<2>().maxCoeff() / kMaxColumns});
    first_ = (box.min.head<2>() / pitch_mm_).array().floor().cast<int>();
    const Eigen::Vector2i last = (box.max.head<2>() / pitch_mm_).array().floor().cast<int>();
    count_ = last - first_ + Eigen::Vector2i::Ones();
    cells_.resize(static_cast<std::size_t>(count_.x()) * static_cast<std::size_t>(count_.y()));
    SurfaceProbe probe(bone, outline.bone_from_outline(), box.max.z() + kAboveRim_mm,
                       box.min.z() - std::max(outline.inner_radius_mm(), kAboveRim_mm));
    for_each([&](int i, int j) {
      if (outline_.inside_mm(place_mm(i, j)) > 0) cell(i, j) = probe.at(place_mm(i, j));
    });
  }

  template <class Visit>
  void for_each(const Visit& visit) {
    for (int j = 0; j < count_.y(); ++j) {
      for (int i = 0; i < count_.x(); ++i) visit(i, j);
    }
  }

  [[nodiscard]] std::optional<SurfaceColumn>& cell(int i, int j) {
    return cells_[static_cast<std::size_t>(i) + static_cast<std::size_t>(count_.x()) * static_cast<std::size_t>(j)];
  }
  [[nodiscard]] Vec2 place_mm(int i, int j) const {
    return pitch_mm_ * (Vec2(first_.x() + i, first_.y() + j) + Vec2::Constant(0.5));
  }
  [[nodiscard]] Vec3 in_bone(int i, int j) {
    const Vec2 place = place_mm(i, j);
    return outline_.bone_from_outline() * Vec3(place.x(), place.y(), cell(i, j)->height_mm);
  }
  [[nodiscard]] double pitch_mm() const { return pitch_mm_; }

  /// Area of the surface over its projection, from the least-squares plane through the heights nearby.
  [[nodiscard]] double stretch(int i, int j) {
    const int reach = std::max(2, static_cast<int>(std::lround(kSlopeRadius_mm / pitch_mm_)));
    Mat3 products = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (int dj = -std::min(reach, j); dj <= std::min(reach, count_.y() - 1 - j); ++dj) {
      for (int di = -std::min(reach, i); di <= std::min(reach, count_.x() - 1 - i); ++di) {
        const auto& near = cell(i + di, j + dj);
        if (!near) continue;
        const Vec3 row(1, di * pitch_mm_, dj * pitch_mm_);
        products += row * row.transpose();
        right += near->height_mm * row;
      }
    }
    const Vec3 plane = products.ldlt().solve(right);
    const double slope2 = plane.tail<2>().squaredNorm();
    return std::isfinite(slope2) ? std::sqrt(1 + std::min(slope2, kMaxSlope * kMaxSlope)) : 1;
  }

 private:
  static constexpr double kMaxSlope = 3;  ///< a step down over the edge is no slope of the face

  const FaceOutline& outline_;
  double pitch_mm_ = 0;
  Eigen::Vector2i first_;
  Eigen::Vector2i count_;
  std::vector<std::optional<SurfaceColumn>> cells_;
};

}  // namespace

NativeFace measure_native_face(const ReamedBone& bone, const FaceOutline& outline) {
  FaceRaster raster(bone, outline);
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const double cell_mm2 = raster.pitch_mm() * raster.pitch_mm();
  const double margin_mm = std::min(kRimMargin_mm, outline.inner_radius_mm() / 4);
  NativeFace out;
  FacePoints points{.points_mm = {}, .point_mm2 = cell_mm2, .voxel_mm = voxel_mm};
  raster.for_each([&](int i, int j) {
    const std::optional<SurfaceColumn>& cell = raster.cell(i, j);
    if (!cell) return;
    const double area_mm2 = cell_mm2 * raster.stretch(i, j);
    out.area_mm2 += area_mm2;
    if (cell->reamed) out.reamed_mm2 += area_mm2;
    if (outline.inside_mm(raster.place_mm(i, j)) >= margin_mm) points.points_mm.push_back(raster.in_bone(i, j));
  });
  out.surface = fit_face(points, outline.bone_from_outline().linear().col(2));
  return out;
}

}  // namespace reamsim
