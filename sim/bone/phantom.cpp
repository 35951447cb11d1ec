// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/phantom.h"

#include <fmt/core.h>
#include <cmath>
#include <numbers>

#include "sim/bone/implicit.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

// Verification blocks have closed-form surfaces. Lattice planes lie at multiples of the voxel size, so that a top face
// at z = 0 lies between two layers of voxels. The glenoid frame is at the centre of the top face, +z up.

/// None where the surface has no partial voxels.
PartialField if_partial(const BoneSettings& settings, const PartialField& partial) {
  return settings.surface_voxels == SurfaceVoxels::partial ? partial : PartialField();
}

/// A block centred on the z axis. `carved`: a solid that is removed from it, negative inside.
Bone make_block(const BoneSettings& settings, const DensityField& density_in_block,
                const std::function<double(const Vec3&)>& carved = {}) {
  const Vec3& size = settings.phantom.size_mm;
  const Aabb box{{-size.x() / 2, -size.y() / 2, -size.z()}, {size.x() / 2, size.y() / 2, 0}};
  const VoxelGrid grid = lattice_around("bone.phantom.size_mm", box, settings.voxel_mm, kMarginVoxels);
  const auto density = [&](const Vec3& point) {
    return box.contains(point) && !(carved && carved(point) < 0) ? density_in_block(point) : kAir;
  };
  const PartialField partial = [&](const Vec3& center, bool) -> PartialVoxel {
    const double fraction = carved ? 1 - fraction_inside(carved, center, grid.voxel_mm) : 1;
    return {fraction * fraction_in_box(box, center, grid.voxel_mm),
            density_in_block(center.cwiseMax(box.min).cwiseMin(box.max))};
  };
  return Bone(sample_phantom(grid, settings.density, density, if_partial(settings, partial)), GlenoidFrame{});
}

/// The block with a spherical cup of `radius_mm`, `cup_depth_mm` deep, in the middle of its top face.
Bone cup_phantom(const BoneSettings& settings, const DensityField& density) {
  const PhantomSettings& phantom = settings.phantom;
  const Vec3 center(0, 0, phantom.radius_mm - phantom.cup_depth_mm);
  const double radius2 = phantom.radius_mm * phantom.radius_mm;
  Bone bone =
      make_block(settings, density, [=](const Vec3& point) { return (point - center).squaredNorm() - radius2; });
  const double opening_mm = std::sqrt(std::max(radius2 - center.z() * center.z(), 0.0));
  constexpr int kRimPoints = 120;
  for (int i = 0; i < kRimPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRimPoints;
    bone.rim_mm.emplace_back(opening_mm * std::cos(angle), opening_mm * std::sin(angle), 0);
  }
  return bone;
}

/// A sphere about the origin; the glenoid frame is at its pole (0, 0, radius).
Bone sphere_phantom(const BoneSettings& settings) {
  const double radius = settings.phantom.radius_mm;
  const Aabb box{Vec3::Constant(-radius), Vec3::Constant(radius)};
  const VoxelGrid grid = lattice_around("bone.phantom.radius_mm", box, settings.voxel_mm, kMarginVoxels);
  const double density = settings.phantom.density_g_cm3;
  const auto field = [=](const Vec3& point) { return point.squaredNorm() <= radius * radius ? density : kAir; };
  const PartialField partial = [=](const Vec3& voxel, bool) -> PartialVoxel {
    const auto distance = [radius](const Vec3& point) { return point.norm() - radius; };
    return {fraction_inside(distance, voxel, grid.voxel_mm), density};
  };
  return Bone(sample_phantom(grid, settings.density, field, if_partial(settings, partial)),
              GlenoidFrame{Rigid(Eigen::Translation3d(0, 0, radius))});
}

std::uint64_t mixed(std::uint64_t bits) {  // finalizer of splitmix64
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
  return bits ^ (bits >> 31);
}

/// The noise at a lattice point: 53 bits mapped to −1…1.
double noise_at(const Vec3i& c, std::uint32_t seed) {
  std::uint64_t bits = mixed(seed + 0x9E3779B97F4A7C15ULL);
  for (int axis = 0; axis < 3; ++axis) bits = mixed(bits ^ static_cast<std::uint32_t>(c[axis]));
  return static_cast<double>(bits >> 11) * 0x1p-52 - 1;
}

constexpr double kWallVariation = 0.1;  // relative variation of the thickness of plate and wall
constexpr double kWallPatch_mm = 7;     // length of this variation
constexpr double kTransition_mm = 0.5;  // from cortical to trabecular density
constexpr double kTexture_mm = 1.1;     // trabecular spacing of the order of 1 mm, stretched along the load
constexpr double kTextureStretch = 2.0;
constexpr double kPlateReach_mm = 7;  // depth below the plate in which trabecular bone is denser
constexpr double kGradientStep_mm = 0.05;
constexpr double kScapulaHeight_mm = 35;  // height of the face of a scapula with the landmarks below
const Vec3 kTrigonum_mm(-105, 0, 0);
const Vec3 kInferiorAngle_mm(-80, -110, 0);

/// Density in anatomical coordinates.
class GlenoidDensity {
 public:
  explicit GlenoidDensity(const PhantomSettings& settings)
      : settings_(settings), shape_(settings), seed_(static_cast<std::uint32_t>(settings.seed)) {}

  [[nodiscard]] const GlenoidShape& shape() const { return shape_; }

  [[nodiscard]] double at(const Vec3& point) const {
    if (point.x() < shape_.medial_end_mm()) return kAir;
    const double solid = shape_.solid(point);
    if (solid > 0) return kAir;
    const double below_face_mm = shape_.face().below_mm(point);
    const double depth_mm = depth(point, solid);
    const double wall_mm = wall_thickness(point, below_face_mm);
    const double cortical_fraction =
        1 - implicit::smoothstep(wall_mm - kTransition_mm / 2, wall_mm + kTransition_mm / 2, depth_mm);
    const double soft = trabecular(point, below_face_mm, depth_mm - wall_mm);
    return soft + cortical_fraction * (dense(below_face_mm) - soft);
  }

  /// The fraction of bone in a voxel, and the density at the surface below its centre if that is air.
  [[nodiscard]] PartialVoxel partial(const Vec3& center, double voxel_mm, bool center_is_bone) const {
    const double solid = shape_.solid(center);
    const double reach_mm = GlenoidShape::kMaxSlope * RS_CLIP_REACH * voxel_mm;
    const double before_end = std::clamp((center.x() - shape_.medial_end_mm()) / voxel_mm + 0.5, 0.0, 1.0);
    PartialVoxel out{solid < 0 ? before_end : 0.0, settings_.cortical_density_g_cm3};
    if (std::abs(solid) > reach_mm) return out;
    const auto field = [this](const Vec3& point) { return shape_.solid(point); };
    out.fraction = before_end * fraction_inside(field, center, voxel_mm);
    if (out.fraction > 0 && !center_is_bone) out.density_g_cm3 = density_below(center, solid);
    return out;
  }

 private:
  /// Density at the surface below a point outside the bone.
  [[nodiscard]] double density_below(Vec3 point, double solid) const {
    constexpr double kBelow_mm = 0.01;
    constexpr int kSteps = 4;
    if (point.x() < shape_.medial_end_mm()) {
      point.x() = shape_.medial_end_mm();
      solid = shape_.solid(point);  // the end may be air
    }
    for (int step = 0; step < kSteps && solid > 0; ++step) {
      const Vec3 slope = slope_at(point, solid);
      point -= (solid / slope.squaredNorm() + kBelow_mm / slope.norm()) * slope;
      point.x() = std::max(point.x(), shape_.medial_end_mm());
      solid = shape_.solid(point);
    }
    return solid > 0 ? dense(shape_.face().below_mm(point)) : at(point);
  }

  [[nodiscard]] Vec3 slope_at(const Vec3& point, double solid) const {
    Vec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
      slope[axis] = (shape_.solid(point + kGradientStep_mm * Vec3::Unit(axis)) - solid) / kGradientStep_mm;
    }
    return slope;
  }

  /// Distance below the surface: the value of the solid over its slope, which is not 1 where shapes are blended.
  [[nodiscard]] double depth(const Vec3& point, double solid) const {
    const double thickest_mm = 1.5 * std::max(settings_.subchondral_mm, settings_.shell_mm) + kTransition_mm;
    if (-solid > 2 * thickest_mm) return -solid;
    return -solid / std::max(slope_at(point, solid).norm(), 0.5);
  }

  /// 1 in the plate and the rim around it, 0 in the wall of the vault.
  [[nodiscard]] double plate_fraction(double below_face_mm) const {
    return 1 - implicit::smoothstep(settings_.subchondral_mm + 1.0, settings_.subchondral_mm + 3.0, below_face_mm);
  }

  [[nodiscard]] double dense(double below_face_mm) const {
    const double wall = settings_.cortical_density_g_cm3;
    return wall + plate_fraction(below_face_mm) * (settings_.subchondral_density_g_cm3 - wall);
  }

  [[nodiscard]] double wall_thickness(const Vec3& point, double below_face_mm) const {
    const double mean_mm =
        settings_.shell_mm + plate_fraction(below_face_mm) * (settings_.subchondral_mm - settings_.shell_mm);
    return mean_mm * (1 + kWallVariation * value_noise(point / kWallPatch_mm, seed_));
  }

  [[nodiscard]] double trabecular(const Vec3& point, double below_face_mm, double below_wall_mm) const {
    const double below_plate_mm = std::max(below_face_mm - settings_.subchondral_mm, 0.0);
    const double denser =
        std::exp(-below_plate_mm / kPlateReach_mm) + 0.3 * std::exp(-std::max(below_wall_mm, 0.0) / 1.5) - 0.3;
    const double gradient = 1 + settings_.trabecular_gradient * denser;
    const Vec3 cell = Vec3(point.x() / kTextureStretch, point.y(), point.z()) / kTexture_mm;
    const double texture = 0.65 * value_noise(cell, seed_ + 1) + 0.35 * value_noise(2.1 * cell, seed_ + 2);
    // Value noise is rarely close to ±1. With this factor `texture` is about twice the relative standard deviation.
    return settings_.trabecular_density_g_cm3 * gradient * std::max(1 + 1.6 * settings_.texture * texture, 0.05);
  }

  PhantomSettings settings_;
  GlenoidShape shape_;
  std::uint32_t seed_;
};

void check(const PhantomSettings& phantom) {
  const auto require = [&](const char* key, double found_mm, double fraction) {
    const double least_mm = fraction * phantom.height_mm;
    if (found_mm >= least_mm) return;
    fail_phantom(key, found_mm, fmt::format("expected at least {:g} of the height: {:.4g} mm", fraction, least_mm));
  };
  require("width_mm", phantom.width_mm, 0.4);
  require("face_radius_mm", phantom.face_radius_mm, 0.55);
}

/// Conversion between anatomical coordinates (lateral, superior, anterior) and B (x left, y posterior, z superior).
struct Sides {
  double lateral_sign;

  explicit Sides(BodySide side) : lateral_sign(side == BodySide::left ? 1 : -1) {}
  [[nodiscard]] Vec3 anatomy_from_bone(const Vec3& p) const { return {lateral_sign * p.x(), p.z(), -p.y()}; }
  [[nodiscard]] Vec3 bone_from_anatomy(const Vec3& p) const { return {lateral_sign * p.x(), -p.z(), p.y()}; }
};

void note_part(Diagnostics& report, const char* part, double radius_mm, const Vec3& normal) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  report.note(fmt::format("{}: radius {:.4g} mm, retroversion {:.2f} degrees, superior inclination {:.2f} degrees",
                          part, radius_mm, kDegrees * version_of(normal), kDegrees * inclination_of(normal)));
}

void describe(const GlenoidFace& face, const PhantomSettings& phantom, Diagnostics& report) {
  if (phantom.walch != Walch::none) report.note("Walch " + name_of(phantom.walch));
  const auto& both = face.biconcavity;
  if (!both) return note_part(report, "face", face.balls.back().radius_mm, face.normal);
  note_part(report, "paleoglenoid", face.balls[0].radius_mm, face.native_normal());
  note_part(report, "neoglenoid", face.balls[1].radius_mm, both->neo_normal);
  report.note(fmt::format("rim to rim: retroversion {:.2f} degrees, biconcavity {:.2f} degrees",
                          180 / std::numbers::pi * version_of(face.normal), 180 / std::numbers::pi * both->angle));
}

/// The parametric glenoid: subchondral plate, cortical wall, and trabecular bone whose density decreases with the
/// distance from the plate, with seeded texture. The glenoid frame is at the centre of the face, +z along its normal.
Bone glenoid_phantom(const BoneSettings& settings, Diagnostics& report) {
  check(settings.phantom);
  const GlenoidShape shape(settings.phantom);
  const Sides sides(settings.side);
  const Vec3 corner = sides.bone_from_anatomy(shape.bounds_mm().min);
  const Vec3 opposite = sides.bone_from_anatomy(shape.bounds_mm().max);
  const VoxelGrid grid = lattice_around("bone.phantom", {corner.cwiseMin(opposite), corner.cwiseMax(opposite)},
                                        settings.voxel_mm, kMarginVoxels);
  Bone bone;
  bone.set_voxels(sample_glenoid(settings, grid));
  GlenoidSettings directions;
  directions.center_mm = sides.bone_from_anatomy(shape.face().center_mm);
  directions.normal = sides.bone_from_anatomy(shape.face().normal);
  directions.superior = Vec3::UnitZ();
  bone.glenoid = glenoid_frame(directions, settings.side);
  // The Friedman axis is lateral and the scapular plane contains lateral and superior, so that version and inclination
  // of the native face are those of the scenario. Trigonum and inferior angle lie beyond the modelled bone.
  const double scale = settings.phantom.height_mm / kScapulaHeight_mm;
  bone.landmarks = LandmarkSettings{.glenoid_center_mm = *directions.center_mm,
                                    .trigonum_spinae_mm = sides.bone_from_anatomy(scale * kTrigonum_mm),
                                    .inferior_angle_mm = sides.bone_from_anatomy(scale * kInferiorAngle_mm)};
  for (const Vec3& point : shape.rim_mm()) bone.rim_mm.push_back(sides.bone_from_anatomy(point));
  describe(shape.face(), settings.phantom, report);
  return bone;
}

}  // namespace

double value_noise(const Vec3& point, std::uint32_t seed) {
  const auto between = [](double a, double b, double t) { return a + t * (b - a); };
  const Vec3 below = point.array().floor();
  const Vec3i cell = below.cast<int>();
  const Vec3 t = (point - below).unaryExpr([](double s) { return s * s * s * (s * (6 * s - 15) + 10); });
  double planes[2];
  for (int k = 0; k < 2; ++k) {
    double rows[2];
    for (int j = 0; j < 2; ++j) {
      rows[j] = between(noise_at(cell + Vec3i(0, j, k), seed), noise_at(cell + Vec3i(1, j, k), seed), t.x());
    }
    planes[k] = between(rows[0], rows[1], t.y());
  }
  return between(planes[0], planes[1], t.z());
}

FilledVoxmap sample_glenoid(const BoneSettings& settings, const VoxelGrid& grid) {
  check(settings.phantom);
  const GlenoidDensity density(settings.phantom);
  const Sides sides(settings.side);
  const PartialField partial = [&](const Vec3& center, bool is_bone) {
    return density.partial(sides.anatomy_from_bone(center), grid.voxel_mm, is_bone);
  };
  return sample_phantom(
      grid, settings.density, [&](const Vec3& point) { return density.at(sides.anatomy_from_bone(point)); },
      if_partial(settings, partial),
      [&](const Vec3& center, double radius_mm) {
        return density.shape().solid(sides.anatomy_from_bone(center)) > GlenoidShape::kMaxSlope * radius_mm;
      });
}

FilledVoxmap sample_phantom(const VoxelGrid& grid, const DensitySettings& density, const DensityField& field,
                            const PartialField& partial, const AirTest& all_air) {
  FilledVoxmap voxmap(grid);
  voxmap.mapping = {density};
  voxmap.frame = "phantom";
  const double radius_mm = 0.5 * GradeBricks::kSide * grid.voxel_mm * std::numbers::sqrt3;
  voxmap.grade = sample_bricks(grid.dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) {
    if (all_air(grid.brick_center_mm(coord), radius_mm)) return;
    const Vec3i first = GradeBricks::kSide * coord;
    const Vec3i last = (first + Vec3i::Constant(GradeBricks::kSide)).cwiseMin(grid.dims);
    for_each_voxel(first, last - Vec3i::Ones(), [&](const Vec3i& voxel) {
      const double at_center = field(grid.center_mm(voxel));
      if (at_center < 0) return;
      brick[static_cast<std::size_t>(BrickLattice::offset_of(voxel))] = DensityMapping::grade_from_density(at_center);
    });
  });
  if (!partial) return voxmap;
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const PartialVoxel found = partial(grid.center_mm(voxel), grade != 0);
    return {found.fraction, grade != 0 ? grade : DensityMapping::grade_from_density(found.density_g_cm3)};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
}

void fail_phantom(const std::string& key, double found_mm, const std::string& expected) {
  throw InputError({}, "bone.phantom." + key, fmt::format("{:.4g} mm", found_mm), expected);
}

Bone bone_from_phantom(const BoneSettings& settings, Diagnostics& report) {
  const PhantomShape shape = settings.phantom.shape;
  report.note("phantom: " + name_of(shape));
  const auto uniform = [density = settings.phantom.density_g_cm3](const Vec3&) { return density; };
  if (shape == PhantomShape::half_space) return make_block(settings, uniform);
  if (shape == PhantomShape::cup) return cup_phantom(settings, uniform);
  if (shape == PhantomShape::sphere) return sphere_phantom(settings);
  if (shape == PhantomShape::layered) {
    return make_block(settings, [phantom = settings.phantom](const Vec3& point) {
      return point.z() > -phantom.cortical_mm ? phantom.cortical_density_g_cm3 : phantom.trabecular_density_g_cm3;
    });
  }
  return glenoid_phantom(settings, report);
}

}  // namespace reamsim
