// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// An isotropic, axis-aligned voxel lattice in the bone frame B. Voxel (0,0,0) has its lower corner at `origin_mm`;
/// voxel (i,j,k) has the index i + nx·(j + ny·k).
struct VoxelGrid {
  Vec3i dims = Vec3i::Zero();
  double voxel_mm = 0;
  Vec3 origin_mm = Vec3::Zero();

  [[nodiscard]] std::int64_t size() const { return std::int64_t{1} * dims.x() * dims.y() * dims.z(); }
  [[nodiscard]] std::int64_t index(const Vec3i& v) const { return static_cast<std::int64_t>(index_in(dims, v)); }
  [[nodiscard]] Vec3i coord(std::int64_t index) const { return cell_at(dims, static_cast<std::size_t>(index)); }
  [[nodiscard]] Vec3 center_mm(const Vec3i& v) const {
    return origin_mm + voxel_mm * (v.cast<double>() + Vec3::Constant(0.5));
  }
  [[nodiscard]] Vec3 brick_center_mm(const Vec3i& brick) const {
    return origin_mm + voxel_mm * BrickLattice::kSide * (brick.cast<double>() + Vec3::Constant(0.5));
  }
  [[nodiscard]] bool contains(const Vec3i& v) const { return contains_cell(dims, v); }
  /// The voxel that contains a point of B; it may lie outside the grid.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm) / voxel_mm).array().floor().cast<int>();
  }
  [[nodiscard]] Aabb bounds_mm() const { return {origin_mm, origin_mm + voxel_mm * dims.cast<double>()}; }
  [[nodiscard]] double voxel_mm3() const { return voxel_mm * voxel_mm * voxel_mm; }

  bool operator==(const VoxelGrid&) const = default;
  static auto fields(auto& self) { return std::tie(self.dims, self.voxel_mm, self.origin_mm); }
};

/// From a voxel to those beside its six faces.
inline const std::array<Vec3i, 6> kFaceSteps{Vec3i(1, 0, 0),  Vec3i(-1, 0, 0), Vec3i(0, 1, 0),
                                             Vec3i(0, -1, 0), Vec3i(0, 0, 1),  Vec3i(0, 0, -1)};

/// Calls visit(voxel) for the voxels from `first` to `last`, both included; x varies fastest.
template <class Visit>
void for_each_voxel(const Vec3i& first, const Vec3i& last, const Visit& visit) {
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) visit(Vec3i(x, y, z));
    }
  }
}
template <class Visit>
void for_each_voxel(const Vec3i& dims, const Visit& visit) {
  for_each_voxel(Vec3i::Zero(), dims - Vec3i::Ones(), visit);
}

/// Calls visit(step, weight) for the eight voxels of a trilinear interpolation whose weight is not 0. `step` is 0 or 1
/// along each axis; `fraction` is the position between the lower and the upper voxel.
template <class Visit>
void for_each_trilinear_weight(const Vec3& fraction, const Visit& visit) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i step(corner & 1, corner >> 1 & 1, corner >> 2);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] != 0 ? fraction[axis] : 1 - fraction[axis];
    if (weight != 0) visit(step, weight);
  }
}

/// Air around a bone. Pictures and the grid `surface` smooth the surface and need it.
inline constexpr int kMarginVoxels = 4;

/// Measured memory per voxel while a mesh is voxelized: grades, distance field, and temporary copies.
inline constexpr double kMeshBytesPerVoxel = 13;

/// Which part of a lattice needs memory while the bone is built.
struct LatticeLoad {
  double bone_fraction = 1;    ///< upper bound of the fraction of the lattice in bricks with bone, 0…1
  double bytes_per_voxel = 1;  ///< in these bricks: one byte of grade, and what the source of the bone needs
};

double machine_memory_bytes();

/// Throws InputError, with the voxel size that would fit, unless a lattice of `dims` voxels (doubles, against overflow)
/// can be indexed and its load fits into half of `memory_bytes`. The message begins with `what`.
void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load = {},
                   double memory_bytes = machine_memory_bytes());

/// The lattice of `voxel_mm` around `box_mm` with a margin of `margin_voxels`. Its planes lie at multiples of the voxel
/// size from the origin of B; its dimensions are multiples of 8 (whole bricks). Throws as check_lattice().
VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load = {});

/// Radiodensity to apparent density to grade (docs/density.md, 1). The defaults of DensitySettings are of a femur at
/// 120 kVp (PMC5234499, Table 1), not a scapular calibration.
struct DensityMapping : DensitySettings {
  static constexpr double kGradeStep_g_cm3 = 0.008;
  static constexpr double kMaxDensity_g_cm3 = 2.0;
  static constexpr int kMaxGrade = 250;

  [[nodiscard]] double density_from_hu(double hu) const {
    const double density = (ash_slope_g_cm3_per_hu * hu + ash_offset_g_cm3) / ash_fraction;
    return std::clamp(density, 0.0, kMaxDensity_g_cm3);
  }
  [[nodiscard]] double hu_from_density(double density_g_cm3) const {
    return (density_g_cm3 * ash_fraction - ash_offset_g_cm3) / ash_slope_g_cm3_per_hu;
  }
  /// The radiodensity of the densest bone that a grade holds.
  [[nodiscard]] double limit_hu() const { return hu_from_density(kMaxDensity_g_cm3); }
  [[nodiscard]] static std::uint8_t grade_from_density(double density_g_cm3) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(density_g_cm3 / kGradeStep_g_cm3), 1L, long{kMaxGrade}));
  }
  [[nodiscard]] std::uint8_t grade_from_hu(double hu) const { return grade_from_density(density_from_hu(hu)); }
  [[nodiscard]] static double density_from_grade(std::uint8_t grade) { return grade * kGradeStep_g_cm3; }
};

/// Measures how much bone of a scan is denser than a grade can hold.
class DensityLimit {
 public:
  explicit DensityLimit(const DensityMapping& mapping) : limit_hu_(mapping.limit_hu()) {}

  void add(double hu, double mm3);
  /// Warns where more bone than noise explains is denser, and asks about metal where its radiodensity suggests it.
  void warn(const std::string& path, Diagnostics& report) const;

 private:
  double limit_hu_;
  double bone_mm3_ = 0;
  double denser_mm3_ = 0;
  double metal_mm3_ = 0;
};

/// Warns if the radiodensity `hu` of a scenario, given by `key`, is denser than a grade can hold.
void warn_of_density_limit(const DensityMapping& mapping, const std::string& key, double hu, Diagnostics& report);

/// The two layers of a mesh bone: cortical down to a depth below its surface, trabecular below. Pictures draw their
/// boundary without voxel steps.
struct BoneLayers {
  double cortical_mm;
  double cortical_g_cm3;
  double trabecular_g_cm3;
};

/// The bone before reaming, as voxels (paper §3.2: the voxmap). Immutable once it is built.
struct Voxmap {
  VoxelGrid grid;
  GradeBricks grade;  ///< density of each voxel; 0 = air
  DensityMapping mapping;
  std::string frame = "LPS";  ///< the bone frame B: "LPS" for CT, "mesh" for a mesh, "phantom"
  std::optional<BoneLayers> layers;

  Voxmap() = default;
  /// All air.
  explicit Voxmap(const VoxelGrid& lattice) : grid(lattice), grade(lattice.dims) {}

  /// False outside the lattice.
  [[nodiscard]] bool is_bone(const Vec3i& voxel) const { return grid.contains(voxel) && grade.get(voxel) != 0; }
};

/// A bone for reading: its voxmap, and the fill of each voxel. All must outlive the view.
struct BoneView {
  const Voxmap& voxmap;
  const FillBricks& fill;         ///< current
  const FillBricks& fill_before;  ///< before the run

  BoneView(const Voxmap& voxels, const FillBricks& current) : BoneView(voxels, current, current) {}
  BoneView(const Voxmap& voxels, const FillBricks& current, const FillBricks& before)
      : voxmap(voxels), fill(current), fill_before(before) {}

  /// Voxels with remaining bone: grade ≠ 0 and fill ≠ 0.
  [[nodiscard]] std::int64_t count_bone() const;
  /// Remaining bone, mm³: Σ fill/65535 · voxel volume over voxels with grade ≠ 0.
  [[nodiscard]] double bone_mm3() const;
};

/// Removed voxels and the frames of their removal: (voxel index, frame), unordered.
using RemovedFrames = std::vector<std::pair<std::int64_t, std::int32_t>>;

/// A voxmap and the fill of its voxels, while a bone is built or read from a file.
struct FilledVoxmap : Voxmap {
  FillBricks fill;  ///< undefined where the grade is 0

  FilledVoxmap() = default;
  /// All voxels are air and whole.
  explicit FilledVoxmap(const VoxelGrid& lattice) : Voxmap(lattice), fill(lattice.dims) {}

  operator BoneView() const { return {*this, fill}; }  // not explicit on purpose
  [[nodiscard]] std::int64_t count_bone() const { return BoneView(*this, fill).count_bone(); }
  [[nodiscard]] double bone_mm3() const { return BoneView(*this, fill).bone_mm3(); }
};

/// Calls visit(voxel, grade, fill) for the voxels with grade ≠ 0 of a stored brick.
template <class Visit>
void for_each_bone_voxel_in(const BoneView& bone, const Vec3i& coord, const Visit& visit) {
  const GradeBricks::Brick& grades = *bone.voxmap.grade.brick(coord);
  const FillBricks::Brick* fill = bone.fill.brick(coord);
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const auto at = static_cast<std::size_t>(offset);
    if (grades[at] == 0) continue;
    visit(BrickLattice::voxel_at(coord, offset), grades[at], fill == nullptr ? FillBricks::kWhole : (*fill)[at]);
  }
}
/// The same for all bricks.
template <class Visit>
void for_each_bone_voxel(const BoneView& bone, const Visit& visit) {
  bone.voxmap.grade.for_each_brick(
      [&](const Vec3i& coord, const GradeBricks::Brick&) { for_each_bone_voxel_in(bone, coord, visit); });
}

/// The first and the last voxel of a box, both included; first > last in an empty box.
struct VoxelBox {
  Vec3i first;
  Vec3i last;

  [[nodiscard]] bool empty() const { return (first.array() > last.array()).any(); }
  /// Voxels along each axis; 0, 0, 0 for an empty box.
  [[nodiscard]] Vec3i size() const { return empty() ? Vec3i(Vec3i::Zero()) : Vec3i(last - first + Vec3i::Ones()); }
  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    return (voxel.array() >= first.array()).all() && (voxel.array() <= last.array()).all();
  }
};

/// The box of the voxels with grade ≠ 0.
VoxelBox bone_extent(const Voxmap& voxmap);

/// The bricks that contain bone and their 26 neighbours, x fastest. They may lie one brick outside the lattice.
std::vector<Vec3i> bricks_near_bone(const GradeBricks& grades);

/// Whether some voxel is partly filled: neither whole nor removed.
bool partly_filled(const FillBricks& fill);

/// Copies the fractions of bone in the box of side³ voxels at `lower`, 0…1, to `out`, x fastest; 0 outside the lattice.
void gather_fractions(const BoneView& bone, const Vec3i& lower, int side, float* out);

/// The grade of each voxel with remaining bone, 0 elsewhere; grid.size() entries, for engines with dense storage.
std::vector<std::uint8_t> dense_remaining_grades(const BoneView& bone);
/// The fill of each voxel, air included; grid.size() entries.
std::vector<std::uint16_t> dense_fill(const BoneView& bone);

/// The stages in which a bone is loaded, and written by `reamsim import`. A CT has all but `distances`, a mesh `read`,
/// `distances`, `voxels` and `anatomy`, a VDB `read` and `anatomy`, a phantom `voxels` and `anatomy`.
enum class BoneStage { read, filter, segment, correct_density, distances, voxels, anatomy, write };

/// Called when a stage begins. May be empty.
using StageSink = std::function<void(BoneStage)>;

inline void begin_stage(const StageSink& sink, BoneStage stage) {
  if (sink) sink(stage);
}

}  // namespace reamsim
