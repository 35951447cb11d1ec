// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/mesh_unit.h"
#include "sim/bone/phantom.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/density.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/bone/voxmap/voxel_grid.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"
#include "sim/mesh/mesh_repair.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

namespace {

/// Signed distance of voxel centres from a closed mesh, voxels, negative inside. Near the surface it is sampled at
/// every voxel. Where a layer is many voxels thick, the distance below that is interpolated linearly between samples
/// some voxels apart: a band of all voxels down to 1.5 mm takes most of the time and the memory of loading a fine bone.
class MeshDepth {
 public:
  /// `layer_voxels`: depth to which distances are needed. Throws InputError where the mesh cannot be sampled.
  MeshDepth(const std::string& path, const TriangleMesh& mesh, const VoxelGrid& grid, double layer_voxels);

  /// Distances near the surface, by voxel; constant outside and below.
  [[nodiscard]] const openvdb::FloatTree& near_surface() const { return near_->tree(); }
  /// Whether distances below are interpolated.
  [[nodiscard]] bool interpolated() const { return ratio_ > 1; }
  /// The interpolated distance at voxel coordinates, below the surface.
  [[nodiscard]] float below(const Vec3& voxel) const;

  using Distances = std::array<float, BrickLattice::kVoxels>;
  /// The distances of a brick's voxels, by BrickLattice::offset_of().
  void of_brick(const Vec3i& brick, Distances& out) const;

 private:
  openvdb::FloatGrid::Ptr near_;
  openvdb::FloatGrid::Ptr deep_;  ///< distances in spacings of `ratio_` voxels, from the first voxel on
  int ratio_ = 1;
};

/// The least number of samples across a layer.
constexpr double kSamplesInLayer = 5;
/// Every voxel is sampled down to this depth, voxels, where the samples below are further apart.
constexpr double kNearVoxels = 3;
/// Sampled beyond the layer, so that its end lies between samples.
constexpr double kBeyond = 2;

/// The samples around a brick, for linear interpolation at its voxels.
class SamplesAround {
 public:
  SamplesAround(const openvdb::FloatTree& samples, const Vec3i& first_voxel, int ratio)
      : ratio_(ratio), first_(first_voxel / ratio) {
    for_each_voxel(Vec3i::Constant(kSide), [&](const Vec3i& v) {
      const Vec3i at = first_ + v;
      values_[place(v)] = samples.getValue({at.x(), at.y(), at.z()});
    });
  }

  /// The distance at a voxel of the brick, voxels.
  [[nodiscard]] float at(const Vec3i& voxel) const {
    const Vec3i lower = voxel / ratio_;
    const Vec3 fraction = (voxel - ratio_ * lower).cast<double>() / ratio_;
    double sum = 0;
    for_each_trilinear_weight(fraction, [&](const Vec3i& step, double weight) {
      sum += weight * double{values_[place(lower - first_ + step)]};
    });
    return static_cast<float>(ratio_ * sum);
  }

 private:
  static constexpr int kSide = BrickLattice::kSide / 2 + 1;  // samples are at least two voxels apart

  static std::size_t place(const Vec3i& v) { return static_cast<std::size_t>(v.x() + kSide * (v.y() + kSide * v.z())); }

  int ratio_;
  Vec3i first_;
  std::array<float, std::size_t{kSide} * kSide * kSide> values_{};
};

MeshDepth::MeshDepth(const std::string& path, const TriangleMesh& mesh, const VoxelGrid& grid, double layer_voxels)
    : ratio_(std::max(1, static_cast<int>(layer_voxels / kSamplesInLayer))) {
  const DistanceSampling near{.first_mm = grid.center_mm({0, 0, 0}),
                              .spacing_mm = grid.voxel_mm,
                              .outer_spacings = kMarginVoxels - 1,
                              .inner_spacings = ratio_ == 1 ? layer_voxels + kBeyond : kNearVoxels};
  DistanceSampling deep = near;
  deep.spacing_mm = ratio_ * grid.voxel_mm;
  deep.inner_spacings = layer_voxels / ratio_ + kBeyond;
  try {
    near_ = mesh_distance(mesh, near);
    deep_ = ratio_ == 1 ? near_ : mesh_distance(mesh, deep);
  } catch (const std::bad_alloc&) {
    throw InputError({path, 0, 0}, "", "the distance field of the mesh does not fit into memory",
                     "increase bone.voxel_mm");
  } catch (const openvdb::Exception&) {
    throw InputError({path, 0, 0}, "", "the mesh cannot be voxelized", "give a closed surface");
  }
}

float MeshDepth::below(const Vec3& voxel) const {
  const Vec3 sample = voxel / ratio_;
  return static_cast<float>(ratio_) *
         openvdb::tools::BoxSampler::sample(deep_->tree(), openvdb::Vec3d(sample.x(), sample.y(), sample.z()));
}

void MeshDepth::of_brick(const Vec3i& brick, Distances& out) const {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  static_assert(Leaf::DIM == BrickLattice::kSide);
  const Vec3i first = BrickLattice::kSide * brick;
  const openvdb::Coord corner(first.x(), first.y(), first.z());
  const Leaf* leaf = near_->tree().probeConstLeaf(corner);
  const float all = leaf == nullptr ? near_->tree().getValue(corner) : 0;
  std::optional<SamplesAround> samples;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    const Vec3i v = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    float& distance = out[static_cast<std::size_t>(offset)];
    distance = leaf == nullptr ? all : leaf->getValue(Leaf::coordToOffset({v.x(), v.y(), v.z()}));
    if (!interpolated() || distance > -kNearVoxels) continue;
    if (!samples) samples.emplace(deep_->tree(), first, ratio_);
    distance = samples->at(first + v);
  }
}

/// Largest relative deviation of the voxelized volume from that of the mesh.
constexpr double kMaxVolumeError = 0.1;

/// Grades by depth below the surface, voxels: cortical down to `cortical_voxels`, trabecular below.
struct GradesByDepth {
  double cortical_voxels;
  std::uint8_t cortical;
  std::uint8_t trabecular;

  [[nodiscard]] std::uint8_t grade(float distance) const {
    const double depth = -double{distance};
    if (depth <= 0) return 0;
    return depth <= cortical_voxels ? cortical : trabecular;
  }
};

bool grade_brick(const MeshDepth& depth, const GradesByDepth& by_depth, const Vec3i& brick_coord,
                 GradeBricks::Brick& out) {
  // The interpolated distance changes by at most one for each voxel along each axis.
  constexpr double kFromCentre = 3 * (GradeBricks::kSide - 1) / 2.0;
  const Vec3i first = GradeBricks::kSide * brick_coord;
  const openvdb::Coord corner(first.x(), first.y(), first.z());
  if (depth.near_surface().probeConstLeaf(corner) == nullptr) {
    float all = depth.near_surface().getValue(corner);
    if (all > 0) return false;
    bool uniform = !depth.interpolated();
    if (!uniform) {
      all = depth.below(first.cast<double>() + Vec3::Constant((GradeBricks::kSide - 1) / 2.0));
      uniform = std::abs(-all - by_depth.cortical_voxels) > kFromCentre;
    }
    if (uniform) {
      out.fill(by_depth.grade(all));
      return true;
    }
  }
  MeshDepth::Distances distances;
  depth.of_brick(brick_coord, distances);
  std::ranges::transform(distances, out.begin(), [&](float distance) { return by_depth.grade(distance); });
  return std::ranges::any_of(out, [](std::uint8_t grade) { return grade != 0; });
}

FilledVoxmap grades_from_depth(const MeshDepth& depth, const VoxelGrid& grid, const GradesByDepth& by_depth) {
  FilledVoxmap voxmap(grid);
  voxmap.grade = sample_bricks(grid.dims, [&](const Vec3i& brick_coord, GradeBricks::Brick& brick) {
    return grade_brick(depth, by_depth, brick_coord, brick);
  });
  return voxmap;
}

/// The distance grid, interpolated between the centres of its voxels.
class DistanceBetween {
 public:
  explicit DistanceBetween(const openvdb::FloatTree& distance) : distance_(distance) {}

  [[nodiscard]] double operator()(const Vec3& index) const {
    const Vec3 base = index.array().floor();
    double sum = 0;
    for_each_trilinear_weight(index - base, [&](const Vec3i& step, double weight) {
      const Vec3i at = base.cast<int>() + step;
      sum += weight * double{distance_.getValue({at.x(), at.y(), at.z()})};
    });
    return sum;
  }

 private:
  const openvdb::FloatTree& distance_;
};

/// Sets the fill by the distance of the surface. Grades depend on the depth only: there is no partial volume.
void set_fill_at_surface(const openvdb::FloatTree& distance, const GradesByDepth& by_depth, FilledVoxmap& voxmap) {
  const DistanceBetween between(distance);
  const std::uint8_t outermost = by_depth.grade(-std::numeric_limits<float>::min());
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const double away = double{distance.getValue({voxel.x(), voxel.y(), voxel.z()})};
    const std::uint8_t bone = grade != 0 ? grade : outermost;
    if (std::abs(away) > RS_CLIP_REACH) return {away < 0 ? 1.0 : 0.0, bone};
    return {fraction_inside(between, voxel.cast<double>(), 1), bone};
  };
  set_partial_fill(sample, voxmap);
}

InputError unrepaired(const std::string& path, const MeshDiagnosis& found) {
  if (found.boundary_edges == 0 && found.nonmanifold_edges == 0) {
    return {{path, 0, 0},
            "",
            "the triangles have no consistent orientation: " + found.text(),
            "set bone.mesh.repair: true, which turns them, or export the mesh with consistent normals"};
  }
  return {{path, 0, 0},
          "",
          "not a closed surface: " + found.text(),
          "give a closed, two-manifold mesh: repair it, or set bone.mesh.repair: true"};
}

/// The mesh of the scenario, and what it needed.
struct CheckedMesh {
  TriangleMesh mesh;
  bool repaired = false;
  double outer_mm3 = 0;  ///< outer_volume_mm3()
};

/// The mesh, repaired if requested. Throws InputError if meshToVolume cannot use it.
CheckedMesh checked_mesh(const MeshBoneSettings& settings, Diagnostics& report) {
  require_mesh_name(settings.path, "bone.mesh.path");
  CheckedMesh out{read_mesh(settings.path, settings.scale)};
  TriangleMesh& mesh = out.mesh;
  const MeshDiagnosis found = diagnose(mesh);
  out.repaired = !found.closed_manifold();
  if (out.repaired && !settings.repair) throw unrepaired(settings.path, found);
  report.note("mesh: " + std::to_string(mesh.triangles.size()) + " triangles, " + found.text());
  if (out.repaired) report.warn("mesh repaired: " + repair(mesh).text());
  const std::vector<MeshPiece> pieces = turn_outwards(mesh);
  out.outer_mm3 = outer_volume_mm3(pieces);
  const double box_mm3 = mesh.bounds().half().prod() * 8;
  if (out.outer_mm3 <= 1e-9 * box_mm3) {
    throw InputError({settings.path, 0, 0}, "", "the mesh encloses no volume", "give the surface of a solid");
  }
  for (const std::string& warning : warnings_of(pieces)) report.warn(warning);
  return out;
}

/// Upper bound of the fraction of the mesh's box in bricks with bone: the volume, and the bricks at the surface. A
/// surface of area A intersects about √3·A/b² bricks of side b.
double bone_fraction(const CheckedMesh& checked, double voxel_mm) {
  constexpr double kPassed = 2;
  const TriangleMesh& mesh = checked.mesh;
  double area_mm2 = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = mesh.corners(triangle);
    area_mm2 += 0.5 * (b - a).cross(c - a).norm();
  }
  const double brick_mm = GradeBricks::kSide * voxel_mm;
  const double box_mm3 = mesh.bounds().half().prod() * 8;
  return std::min(1.0, (checked.outer_mm3 + kPassed * area_mm2 * brick_mm) / box_mm3);
}

/// What to do where the voxels of a repaired mesh differ from it.
std::string remedy_for(const MeshDiagnosis& repaired) {
  if (repaired.inconsistent_edges > 0) {
    return fmt::format(
        "orient the triangles of the mesh alike: {} between triangles with opposite orientation",
        repaired.inconsistent_edges == 1 ? "1 edge lies" : fmt::format("{} edges lie", repaired.inconsistent_edges));
  }
  return "close the holes of the mesh, of which only those smaller than a voxel or with a single rim can be repaired, "
         "and unite surfaces that overlap";
}

/// Compares the volume of the voxels with that of the mesh, to detect leaks and overlaps.
void check_volume(const std::string& path, const CheckedMesh& checked, double voxels_mm3, Diagnostics& report) {
  const double mesh_mm3 = checked.outer_mm3;
  const double error = std::abs(voxels_mm3 - mesh_mm3) / mesh_mm3;
  report.note(fmt::format("bone volume: {:.0f} mm3 in voxels, {:.0f} mm3 in the mesh", voxels_mm3, mesh_mm3));
  if (error <= kMaxVolumeError) return;
  const std::string found =
      fmt::format("the bone has {:.0f} mm3 in voxels but {:.0f} mm3 in the mesh", voxels_mm3, mesh_mm3);
  if (checked.repaired) {
    throw InputError({path, 0, 0}, "", "the repair failed: " + found, remedy_for(diagnose(checked.mesh)));
  }
  report.warn(found + ": the mesh overlaps itself, is thinner than a voxel, or has the wrong scale (bone.mesh.scale)");
}

}  // namespace

FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Diagnostics& report, const StageSink& stages) {
  const MeshBoneSettings& bone = settings.mesh;
  begin_stage(stages, BoneStage::read);
  const CheckedMesh checked = checked_mesh(bone, report);
  const TriangleMesh& mesh = checked.mesh;
  const bool has_glenoid = settings.glenoid.center_mm || settings.glenoid.landmarks || settings.glenoid.near_mm;
  check_mesh_unit(bone.path, mesh.bounds(), bone.scale, has_glenoid, report);
  const VoxelGrid grid = lattice_around(bone.path, mesh.bounds(), settings.voxel_mm, kMarginVoxels,
                                        {bone_fraction(checked, settings.voxel_mm), kMeshBytesPerVoxel});
  begin_stage(stages, BoneStage::distances);
  const double cortical_voxels = bone.cortical_mm / settings.voxel_mm;
  const MeshDepth depth(bone.path, mesh, grid, cortical_voxels);

  begin_stage(stages, BoneStage::voxels);
  const DensityMapping mapping = mapping_from(settings.density);
  const auto grade = [&mapping](double hu) { return DensityMapping::grade_from_density(mapping.density_from_hu(hu)); };
  warn_of_density_limit(mapping, "bone.mesh.cortical_hu", bone.cortical_hu, report);
  warn_of_density_limit(mapping, "bone.mesh.trabecular_hu", bone.trabecular_hu, report);
  const GradesByDepth by_depth{cortical_voxels, grade(bone.cortical_hu), grade(bone.trabecular_hu)};
  FilledVoxmap voxmap = grades_from_depth(depth, grid, by_depth);
  voxmap.mapping = mapping;
  voxmap.layers = BoneLayers{bone.cortical_mm, DensityMapping::density_from_grade(by_depth.cortical),
                             DensityMapping::density_from_grade(by_depth.trabecular)};
  voxmap.frame = "mesh";
  if (voxmap.count_bone() == 0) {
    throw InputError({bone.path, 0, 0}, "bone.voxel_mm", "the mesh contains no voxel centre",
                     "use smaller voxels, a larger bone.mesh.scale, or a closed mesh");
  }
  if (settings.surface_voxels == SurfaceVoxels::partial) set_fill_at_surface(depth.near_surface(), by_depth, voxmap);
  check_volume(bone.path, checked, voxmap.bone_mm3(), report);
  return voxmap;
}

}  // namespace reamsim
