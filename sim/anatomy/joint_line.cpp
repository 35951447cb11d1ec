// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/run_metrics.h"

#include <fmt/core.h>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

constexpr double kSlopeRadius_mm = 1.5;
constexpr double kFacePitch_mm = 0.5;  // lines of sight on a face are at least this far apart
/// Points nearer to the rim, which is rounded and picked by hand, are not fitted; at most a quarter of the inner
/// radius.
constexpr double kRimMargin_mm = 2.5;
constexpr double kMaxAxisError_deg = 1;     // an axis with a larger standard error is rejected
constexpr double kMinFittedFraction = 0.7;  // with a smaller fraction of inliers a face is not one surface
/// Lines of sight start this far above the highest point of the rim. They end below the lowest point, by the inner
/// radius of the face: a bowl of that width is not deeper.
constexpr double kAboveRim_mm = 3;

Vec2 centroid_of(const std::vector<Vec2>& corners) {
  Vec2 sum = Vec2::Zero();
  double doubled_area = 0;
  for_each_side(corners, [&](const Vec2& a, const Vec2& b) {
    const double cross = a.x() * b.y() - a.y() * b.x();
    doubled_area += cross;
    sum += cross * (a + b) / 3;
  });
  return doubled_area == 0 ? Vec2(Vec2::Zero()) : Vec2(sum / doubled_area);
}

/// The heights of the face on a regular grid in the plane of the outline.
class FaceGrid {
 public:
  FaceGrid(const BoneView& bone, const FaceOutline& outline) : outline_(outline) {
    const Aabb& box = outline.box_mm;
    const double voxel_mm = bone.voxmap.grid.voxel_mm;
    pitch_mm_ = std::max({voxel_mm, kFacePitch_mm, (box.max - box.min).head<2>().maxCoeff() / kMaxColumns});
    first_ = (box.min.head<2>() / pitch_mm_).array().floor().cast<int>();
    const Eigen::Vector2i last = (box.max.head<2>() / pitch_mm_).array().floor().cast<int>();
    count_ = last - first_ + Eigen::Vector2i::Ones();
    cells_.resize(static_cast<std::size_t>(count_.x()) * static_cast<std::size_t>(count_.y()));
    const SurfaceProbe probe = probe_surface(bone, outline.bone_from_outline, box.max.z() + kAboveRim_mm,
                                             box.min.z() - std::max(outline.inner_radius_mm(), kAboveRim_mm));
    for_each([&](int i, int j) {
      if (outline_.inside_mm(place_mm(i, j)) > 0) cell(i, j) = probe(place_mm(i, j));
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
    return outline_.bone_from_outline * Vec3(place.x(), place.y(), cell(i, j)->height_mm);
  }
  [[nodiscard]] double pitch_mm() const { return pitch_mm_; }

  /// Area of the surface over that of its projection, from the least-squares plane through the neighbouring heights.
  [[nodiscard]] double area_ratio(int i, int j) {
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
    const Vec3 plane = solve_ldlt(products, right);
    const double slope2 = plane.tail<2>().squaredNorm();
    return std::isfinite(slope2) ? std::sqrt(1 + std::min(slope2, kMaxSlope * kMaxSlope)) : 1;
  }

 private:
  static constexpr double kMaxSlope = 3;  ///< a steeper step is the edge of the face

  const FaceOutline& outline_;
  double pitch_mm_ = 0;
  Eigen::Vector2i first_;
  Eigen::Vector2i count_;
  std::vector<std::optional<SurfaceColumn>> cells_;
};

constexpr const char* kNoRim =
    "the rim of the face is unknown: set bone.glenoid.rim_mm (glenoid and cup phantoms have their own)";

/// Largest residual of a native face, mm; one voxel where that is more. For a reamed face it is one voxel.
constexpr double kRoughest_mm = 0.5;

/// Why a surface has no axis; "" if it has one.
std::string fit_failure(const std::optional<FaceSurface>& surface, double roughest_mm) {
  if (!surface) return "the face is too small for a fit";
  if (surface->fitted_fraction < kMinFittedFraction) {
    return fmt::format("the face is not a single sphere or plane: only {:.0f} % of it lies on the best fit",
                       100 * surface->fitted_fraction);
  }
  if (surface->rms_mm > roughest_mm) {
    return fmt::format("the face is not a single sphere or plane: the best fit leaves a residual of {:.2f} mm",
                       surface->rms_mm);
  }
  return "";
}

Measured<FaceAxis> checked(const std::optional<FaceAxis>& axis) {
  if (!axis) {
    return Missing{
        "the sphere fitted to the face is too small: its radius does not exceed its distance from the centre of the "
        "face"};
  }
  if (axis->error_deg <= kMaxAxisError_deg) return *axis;
  return Missing{fmt::format("the face is too small or too rough: the standard error of its axis is {:.1f} degrees",
                             axis->error_deg)};
}

Measured<FaceAxis> native_axis(const NativeFace& face, const std::optional<Vec3>& center_mm, double voxel_mm) {
  const std::string failure = fit_failure(face.surface, std::max(kRoughest_mm, voxel_mm));
  if (!failure.empty()) return Missing{failure};
  // A face of unknown centre has the mean of its points.
  return checked(axis_through(*face.surface, center_mm.value_or(face.surface->plane.point_mm)));
}

Measured<FaceAxis> reamed_axis(const std::optional<FaceSurface>& surface, const Rigid& bone_from_tool,
                               double voxel_mm) {
  if (const std::string failure = fit_failure(surface, voxel_mm); !failure.empty()) return Missing{failure};
  const auto meets = meeting_point(*surface, bone_from_tool.translation(), bone_from_tool.linear().col(2));
  if (!meets) return Missing{"the reamer's axis does not meet the surface through the reamed face"};
  return checked(axis_through(*surface, *meets));
}

/// Why a point does not lie on the reamed face; "" if most columns around it are reamed and few are reamed through. The
/// core of a cannulated reamer is narrower than this neighbourhood.
std::string location_failure(const ColumnMap& map, const Vec3& point_mm) {
  constexpr double kRadius_mm = 3;
  constexpr double kMinReamed = 0.5;
  constexpr double kMaxThrough = 0.1;
  const Vec3 center = map.bone_from_map.inverse() * point_mm;
  int all = 0;
  int reamed = 0;
  int through = 0;
  map.for_each([&](const ColumnPlace& place) {
    if ((map.center_mm(place) - center.head<2>()).norm() > kRadius_mm) return;
    ++all;
    reamed += map.at(place).state == ColumnState::reamed ? 1 : 0;
    through += map.at(place).state == ColumnState::through ? 1 : 0;
  });
  const double columns = std::numbers::pi * kRadius_mm * kRadius_mm / (map.pitch_mm * map.pitch_mm);
  if (through > kMaxThrough * columns) return "the bone is perforated where the Friedman axis meets it";
  if (all == 0 || reamed < kMinReamed * columns) return "the Friedman axis meets the bone outside the reamed face";
  return "";
}

Measured<double> medialization(const JointLine& line, const ColumnMap& map, const BoneAxes& axes) {
  const Measured<Vec3> before = point_on_native_face(line, axes);
  if (!axes.scapula || !axes.face_center_mm || !line.native.value) return Missing{before.reason};
  if (!line.reamed.value) return Missing{"reamed face: " + line.reamed.reason};
  const Vec3& lateral = axes.scapula->lateral;
  const auto after = meeting_point(*line.reamed_surface, *axes.face_center_mm, lateral);
  if (!before.value || !after) return Missing{"the Friedman axis does not meet the surface through the face"};
  if (const std::string failure = location_failure(map, *after); !failure.empty()) return Missing{failure};
  return (*before.value - *after).dot(lateral);
}

}  // namespace

std::optional<FaceOutline> FaceOutline::of(const std::vector<Vec3>& rim_mm, const Vec3& outward) {
  const std::optional<PlaneFit> plane = fit_plane(rim_mm, outward);
  if (!plane) return std::nullopt;
  FaceOutline out;
  out.bone_from_outline = frame_at(plane->point_mm, plane->normal);
  const auto set_corners = [&] {
    out.corners_mm.clear();
    out.box_mm = Aabb::none();
    const Rigid outline_from_bone = out.bone_from_outline.inverse();
    for (const Vec3& point : rim_mm) {
      const Vec3 place = outline_from_bone * point;
      out.corners_mm.emplace_back(place.head<2>());
      out.box_mm.extend(place);
    }
  };
  set_corners();
  const Vec2 centroid = centroid_of(out.corners_mm);
  out.bone_from_outline.translation() = out.bone_from_outline * Vec3(centroid.x(), centroid.y(), 0);
  set_corners();
  return out;
}

double FaceOutline::inside_mm(const Vec2& place) const {
  double distance = std::numeric_limits<double>::infinity();
  bool inside = false;
  for_each_side(corners_mm, [&](const Vec2& a, const Vec2& b) {
    distance = std::min(distance, implicit::distance_to_segment(place, a, b));
    inside ^= (a.y() > place.y()) != (b.y() > place.y()) &&
              place.x() < a.x() + (place.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
  });
  return inside ? distance : -distance;
}

NativeFace measure_native_face(const BoneView& bone, const FaceOutline& outline) {
  FaceGrid grid(bone, outline);
  const double cell_mm2 = grid.pitch_mm() * grid.pitch_mm();
  const double margin_mm = std::min(kRimMargin_mm, outline.inner_radius_mm() / 4);
  NativeFace out;
  FacePoints points{.points_mm = {}, .point_mm2 = cell_mm2, .voxel_mm = bone.voxmap.grid.voxel_mm};
  grid.for_each([&](int i, int j) {
    const std::optional<SurfaceColumn>& cell = grid.cell(i, j);
    if (!cell) return;
    const double area_mm2 = cell_mm2 * grid.area_ratio(i, j);
    out.area_mm2 += area_mm2;
    if (cell->reamed) out.reamed_mm2 += area_mm2;
    if (outline.inside_mm(grid.place_mm(i, j)) >= margin_mm) points.points_mm.push_back(grid.in_bone(i, j));
  });
  out.surface = fit_face(points, outline.bone_from_outline.linear().col(2));
  return out;
}

FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const double superior = std::clamp(direction.dot(axes.superior), -1.0, 1.0);
  return {.version_deg = kDegrees * std::atan2(-direction.dot(axes.anterior), direction.dot(axes.lateral)),
          .inclination_deg = kDegrees * std::asin(superior)};
}

Measured<FaceAngles> angles_of(const Measured<FaceAxis>& axis, const std::optional<ScapularAxes>& frame,
                               const char* without_frame) {
  if (!axis.value) return Missing{axis.reason};
  if (!frame) return Missing{without_frame};
  return face_angles(axis.value->direction, *frame);
}

Measured<Vec3> point_on_native_face(const JointLine& line, const BoneAxes& axes) {
  if (!axes.scapula || !axes.face_center_mm) {
    return Missing{"the Friedman axis is unknown: set bone.glenoid.landmarks"};
  }
  if (!line.native.value) return Missing{"native face: " + line.native.reason};
  const auto point = meeting_point(*line.native_face->surface, *axes.face_center_mm, axes.scapula->lateral);
  if (!point) return Missing{"the Friedman axis does not meet the surface through the face"};
  return *point;
}

JointLine measure_joint_line(const BoneView& bone, const ColumnMap& map, const ReamedFace& face, const BoneAxes& axes) {
  JointLine out;
  const double voxel_mm = bone.voxmap.grid.voxel_mm;
  const Vec3 reamer = map.bone_from_map.linear().col(2);
  FacePoints points{.points_mm = {}, .point_mm2 = map.pitch_mm * map.pitch_mm, .voxel_mm = voxel_mm};
  constexpr std::size_t kMaxPoints = 3000;  // more do not improve the fit
  const std::size_t step = 1 + face.columns.size() / kMaxPoints;
  points.point_mm2 *= static_cast<double>(step);
  for (std::size_t i = 0; i < face.columns.size(); i += step) {
    points.points_mm.push_back(map.in_bone(face.columns[i], map.at(face.columns[i]).after_mm));
  }
  out.reamed_surface = fit_face(points, reamer);
  out.reamed = reamed_axis(out.reamed_surface, map.bone_from_map, voxel_mm);
  const Vec3 outward = axes.known() ? axes.known()->lateral : reamer;
  if (const auto outline = FaceOutline::of(axes.rim_mm, outward)) {
    out.native_face = measure_native_face(bone, *outline);
    out.native = native_axis(*out.native_face, axes.face_center_mm, voxel_mm);
    out.reamed_fraction = out.native_face->area_mm2 > 0
                              ? Measured<double>(out.native_face->reamed_mm2 / out.native_face->area_mm2)
                              : Missing{"no bone lies within the rim of the face"};
  } else {
    out.native.reason = out.reamed_fraction.reason = kNoRim;
  }
  out.medialization_mm = medialization(out, map, axes);
  return out;
}

}  // namespace reamsim
