// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/run_metrics.h"

#include <cmath>

#include "sim/base/parallel.h"
#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

constexpr double kSurfaceFraction = 0.5;  // fraction at the surface of the bone
constexpr double kRayVoxels = 0.5;        // step along a ray
constexpr int kHalvings = 12;             // of the last step
constexpr double kFaceCosine = 0.7071;    // a surface steeper than 45° against the implant is a wall
constexpr double kSurfaceVoxels = 0.5;    // a gap between back and bone begins this far above the bone

/// The bone around a seated implant; points are in its frame.
class BoneAround {
 public:
  BoneAround(const BoneView& bone, const SeatedImplant& implant, const ImplantShape& shape)
      : implant_(implant),
        shape_(shape),
        fractions_(bone, DensityMapping::kMaxDensity_g_cm3),
        voxel_mm_(bone.voxmap.grid.voxel_mm) {
    const VoxelGrid& grid = bone.voxmap.grid;
    const Vec3 size_mm = grid.voxel_mm * grid.dims.cast<double>();
    center_mm_ = implant.bone_from_implant.inverse() * (grid.origin_mm + size_mm / 2);
    radius_mm_ = size_mm.norm() / 2;
  }

  [[nodiscard]] double voxel_mm() const { return voxel_mm_; }
  [[nodiscard]] bool below_back(const Vec3& point) const { return point.z() < shape_.level_mm(point.head<2>()); }
  [[nodiscard]] bool in_bone(const Vec3& point) { return fraction_at(point) >= kSurfaceFraction; }
  /// Air below the back that is not the gap between back and bone. The voxel under the back is left out, because the
  /// interpolation rounds the edge of the face there.
  [[nodiscard]] bool outside(const Vec3& point) {
    return !in_bone(point) && below_back(point + voxel_mm_ * Vec3::UnitZ()) && !in_gap(point);
  }

  /// Distance along a ray to the outer surface of the bone, without the face that the peg enters; at most `most_mm`.
  [[nodiscard]] double wall_mm(const Vec3& from, const Vec3& direction, double most_mm) {
    if (outside(from)) return 0;
    const double step_mm = kRayVoxels * voxel_mm_;
    // Beyond the sphere around the lattice everything is air.
    const double last_mm = std::min(most_mm, (from - center_mm_).norm() + radius_mm_ + voxel_mm_) + step_mm;
    bool was_in_bone = in_bone(from);
    for (double along_mm = step_mm; along_mm < last_mm; along_mm += step_mm) {
      const bool is_in_bone = in_bone(from + along_mm * direction);
      if (was_in_bone && !is_in_bone) {
        const auto inside = [&](double mm) { return in_bone(from + mm * direction); };
        const double surface_mm = implicit::bisect(along_mm - step_mm, along_mm, kHalvings, inside).middle();
        if (!is_face(from + surface_mm * direction)) return std::min(surface_mm, most_mm);
      }
      was_in_bone = is_in_bone;
    }
    return most_mm;
  }

 private:
  /// Whether a point of the surface belongs to the face: above the back, in the gap below the footprint, or beside the
  /// footprint and facing as the implant does.
  [[nodiscard]] bool is_face(const Vec3& surface) {
    if (!below_back(surface + voxel_mm_ * Vec3::UnitZ()) || in_gap(surface)) return true;
    return !(shape_.covers(surface.head<2>()) && column_at(surface)) && normal_at(surface).z() > kFaceCosine;
  }

  /// Unit vector out of the bone at its surface.
  [[nodiscard]] Vec3 normal_at(const Vec3& surface) {
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = voxel_mm_ * Vec3::Unit(axis);
      out[axis] = fraction_at(surface - step) - fraction_at(surface + step);
    }
    return out.normalized();
  }

  [[nodiscard]] double fraction_at(const Vec3& point) {
    return fractions_.at(implant_.bone_from_implant * point).after;
  }

  /// The column of the map at a point; nullptr outside the map.
  [[nodiscard]] const Column* column_at(const Vec3& point) const {
    const ColumnMap& map = implant_.map;
    const Vec2 at = (point.head<2>() - map.corner_mm) / map.pitch_mm;
    const ColumnPlace place(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    return map.contains(place) ? &map.at(place) : nullptr;
  }

  /// Whether a point below the footprint lies between the back of the implant and the bone.
  [[nodiscard]] bool in_gap(const Vec3& point) const {
    if (!shape_.covers(point.head<2>())) return false;
    const Column* column = column_at(point);
    if (column == nullptr || !column->has_bone()) return false;
    const double surface_mm = column->after_mm - implant_.apex_mm;
    if (shape_.level_mm(point.head<2>()) - surface_mm > kOverhangDepth_mm) return false;
    return point.z() > surface_mm - kSurfaceVoxels * voxel_mm_;
  }

  const SeatedImplant& implant_;
  const ImplantShape& shape_;
  BoneFractions fractions_;
  double voxel_mm_;
  Vec3 center_mm_;
  double radius_mm_;
};

PegWall measure_peg(BoneAround& bone, const PegSurface& peg) {
  PegWall out;
  for (const PegSurface::Circumference& one : peg.circumferences) {
    if (!bone.below_back(one.center_mm)) continue;
    bool all_in_bone = true, any_outside = false;
    for (const PegPoint& p : one.points) {
      if (bone.in_bone(p.at_mm)) continue;
      all_in_bone = false;
      any_outside |= bone.outside(p.at_mm);
    }
    out.length_mm += one.length_mm;
    out.in_bone_mm += all_in_bone ? one.length_mm : 0;
    out.perforated_mm += any_outside ? one.length_mm : 0;
  }
  if (out.length_mm == 0) return out;
  constexpr double kFar_mm = 1e9;
  double least_mm = out.perforated_mm > 0 ? 0 : kFar_mm;
  for (const PegPoint& ray : peg.rays) {
    if (least_mm > 0 && bone.below_back(ray.at_mm))
      least_mm = std::min(least_mm, bone.wall_mm(ray.at_mm, ray.outward, least_mm));
  }
  if (least_mm < kFar_mm) out.least_wall_mm = least_mm;
  return out;
}

void set_angles(Planning& out, const Vec3& axis, const JointLine& line, const BoneAxes& axes) {
  out.planned = angles_of(FaceAxis{.direction = axis}, axes.scapula, kNoScapularFrame);
  out.native = angles_of(line.native, axes.scapula, kNoScapularFrame);
  const auto& known = axes.known();
  if (known && line.native.value) {
    out.corrected = face_angles(line.native.value->direction, *known) - face_angles(axis, *known);
  } else {
    out.corrected =
        Missing{known ? "native face: " + line.native.reason : "neither a scapular nor a glenoid frame is defined"};
  }
}

/// The distance along a line in the frame of the implant to the articular surface; nullopt where they do not meet.
std::optional<double> meets_articular(const ImplantSettings& implant, const Vec3& point, const Vec3& direction) {
  if (implant.backside_radius_mm == 0) {
    constexpr double kAlong = 1e-3;
    if (std::abs(direction.z()) < kAlong) return std::nullopt;
    return (implant.thickness_mm - point.z()) / direction.z();
  }
  const Vec3 from = point - Vec3(0, 0, implant.thickness_mm + implant.backside_radius_mm);
  const double middle = -from.dot(direction);
  const double squared = middle * middle - from.squaredNorm() + std::pow(implant.backside_radius_mm, 2);
  if (squared < 0) return std::nullopt;
  const double half = std::sqrt(squared);
  const auto height = [&](double along) { return point.z() + along * direction.z(); };
  return height(middle - half) < height(middle + half) ? middle - half : middle + half;
}

Measured<double> medialization(const Rigid& bone_from_implant, const ImplantSettings& implant, const JointLine& line,
                               const BoneAxes& axes) {
  const Measured<Vec3> before = point_on_native_face(line, axes);
  if (!before.value) return Missing{before.reason};
  const Rigid implant_from_bone = bone_from_implant.inverse();
  const auto lateral_mm =
      meets_articular(implant, implant_from_bone * *before.value, implant_from_bone.linear() * axes.scapula->lateral);
  if (!lateral_mm) return Missing{"the Friedman axis does not meet the implant"};
  return -*lateral_mm;
}

/// Lengths of vault bone along a column, mm.
struct VaultColumn {
  double before_mm = 0;
  double left_mm = 0;
};

VaultColumn vault_column(ColumnBone& bone, const SeatedImplant& implant, const FootprintColumn& at, double depth_mm) {
  const Column& column = implant.map.at(at.place);
  if (column.state == ColumnState::air) return {};
  const double bottom_mm = column.before_mm - depth_mm;
  // A column that was reamed through has no cover any more.
  const double cover = column.cover > 0 ? column.cover : 1;
  VaultColumn out;
  out.before_mm = bone.continuous_mm(at.place, column.before_mm, bottom_mm, cover, &Fractions::before);
  if (column.state == ColumnState::through) return out;
  const double left_mm = bone.continuous_mm(at.place, column.after_mm, bottom_mm, cover, &Fractions::after);
  out.left_mm = std::max(left_mm + std::min(implant.gap_mm(at), 0.0), 0.0);
  return out;
}

/// The vault behind the back of the implant on its axis: the mean of the columns around it, which lies between four.
std::optional<double> axis_depth(const BoneView& bone, const SeatedImplant& implant, const ImplantShape& shape,
                                 const MetricSettings& settings) {
  const ColumnPlace first = (-implant.map.corner_mm / implant.map.pitch_mm).array().floor().cast<int>();
  const double back_mm = shape.back_mm(Vec2::Zero()).value_or(0);
  ColumnBone lengths(bone, implant.map, settings.dense_g_cm3);
  double sum_mm = 0;
  int columns = 0;
  for (const ColumnPlace& step : {ColumnPlace(0, 0), ColumnPlace(1, 0), ColumnPlace(0, 1), ColumnPlace(1, 1)}) {
    const FootprintColumn column{.place = first + step, .back_mm = back_mm};
    if (!implant.map.contains(column.place) || implant.map.at(column.place).state == ColumnState::air) continue;
    sum_mm += vault_column(lengths, implant, column, settings.implant->vault_depth_mm).left_mm;
    ++columns;
  }
  return columns > 0 ? std::optional(sum_mm / columns) : std::nullopt;
}

Vault measure_vault(const BoneView& bone, const SeatedImplant& implant, const ImplantShape& shape,
                    const MetricSettings& settings) {
  const double depth_mm = settings.implant->vault_depth_mm;
  std::vector<VaultColumn> columns(implant.footprint.size());
  constexpr std::size_t kColumnsAtOnce = 512;
  parallel_ranges(columns.size(), kColumnsAtOnce, [&](std::size_t begin, std::size_t end) {
    ColumnBone lengths(bone, implant.map, settings.dense_g_cm3);
    for (std::size_t i = begin; i < end; ++i) {
      columns[i] = vault_column(lengths, implant, implant.footprint[i], depth_mm);
    }
  });
  Vault out;
  double area_mm2 = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double column_mm2 = implant.footprint[i].weight * implant.column_mm2();
    out.before_mm3 += column_mm2 * columns[i].before_mm;
    out.left_mm3 += column_mm2 * columns[i].left_mm;
    area_mm2 += column_mm2;
  }
  out.mean_depth_mm = out.left_mm3 / area_mm2;
  out.axis_depth_mm = axis_depth(bone, implant, shape, settings);
  return out;
}

}  // namespace

std::optional<Planning> measure_planning(const BoneView& bone, const Rigid& bone_from_tool, const JointLine& line,
                                         const BoneAxes& axes, const MetricSettings& settings,
                                         const TriangleMesh* implant_mesh) {
  const auto pose = implant_pose(*settings.implant, bone_from_tool, axes);
  if (!pose) return std::nullopt;
  const ImplantShape shape(*settings.implant, implant_mesh);
  const auto implant = place_implant(bone, *pose, shape, *settings.implant);
  if (!implant) return std::nullopt;
  Planning out;
  out.bone_from_implant = implant->bone_from_implant;
  set_angles(out, pose->linear().col(2), line, axes);
  out.medialization_mm = medialization(out.bone_from_implant, *settings.implant, line, axes);
  out.seating = measure_seating(bone, *implant, *settings.implant, settings.dense_g_cm3);
  out.vault = measure_vault(bone, *implant, shape, settings);
  BoneAround around(bone, *implant, shape);
  for (const PegSurface& peg : surfaces_of_pegs(*settings.implant, shape, implant_mesh, around.voxel_mm())) {
    out.pegs.push_back(measure_peg(around, peg));
    out.peg_axes_mm.push_back(peg.axis_mm);
  }
  return out;
}

}  // namespace reamsim
