// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <openvdb/openvdb.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "sim/base/parallel.h"
#include "sim/bone/bone.h"
#include "sim/bone/mesh_fractions.h"
#include "sim/bone/mesh_source.h"
#include "sim/bone/phantom.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/winding.h"

namespace reamsim {

namespace {

/// Where the columns of voxels along z lie inside a mesh: where its winding number is more than 0. Overlaps, doubled
/// faces and surfaces within the solid change nothing. The edges of the mesh must cancel (holes_of()).
class InsideColumns {
 public:
  InsideColumns(const TriangleMesh& mesh, const VoxelGrid& grid)
      : grid_(grid), parts_(static_cast<std::size_t>(grid.dims.x()) * static_cast<std::size_t>(grid.dims.y())) {
    const LineCrossings lines(mesh, 2);
    const auto rows = static_cast<std::size_t>(grid.dims.y());
    std::vector<char> row_is_simple(rows, 1);
    parallel_items(rows, [&](std::size_t row) {
      std::vector<LineCrossings::Crossing> crossings;
      for (Vec3i voxel(0, static_cast<int>(row), 0); voxel.x() < grid.dims.x(); ++voxel.x()) {
        const Vec3 start = grid.center_mm(voxel);
        lines.along(start.x(), start.y(), crossings);
        std::vector<Part>& parts = parts_[column_of(voxel)];
        int winding = 0;
        for (const auto& crossing : crossings) {
          const int next = winding - crossing.leaving;
          if (winding <= 0 && next > 0) parts.push_back({crossing.at_mm, crossing.at_mm});
          if (winding > 0 && next <= 0) parts.back().end_mm = crossing.at_mm;
          winding = next;
          if (winding < 0 || winding > 1) row_is_simple[row] = 0;
        }
      }
    });
    for (const auto& parts : parts_) {
      for (const Part& part : parts) volume_mm3_ += (part.end_mm - part.begin_mm) * grid.voxel_mm * grid.voxel_mm;
    }
    simple_ = std::ranges::all_of(row_is_simple, [](char simple) { return simple != 0; });
  }

  /// Whether the centre of a voxel is inside; it may lie outside the grid.
  [[nodiscard]] bool contains(const Vec3i& voxel) const {
    if (!grid_.contains(voxel)) return false;
    const double z_mm = grid_.center_mm(voxel).z();
    return std::ranges::any_of(parts_[column_of(voxel)],
                               [&](const Part& part) { return z_mm >= part.begin_mm && z_mm < part.end_mm; });
  }
  /// Of the columns, mm³.
  [[nodiscard]] double volume_mm3() const { return volume_mm3_; }
  /// Whether the winding number is nowhere other than 0 or 1: no surface overlaps another.
  [[nodiscard]] bool is_simple() const { return simple_; }

 private:
  struct Part {
    double begin_mm, end_mm;
  };

  [[nodiscard]] std::size_t column_of(const Vec3i& v) const { return index_in(grid_.dims, {v.x(), v.y(), 0}); }

  VoxelGrid grid_;
  std::vector<std::vector<Part>> parts_;  ///< of each column
  double volume_mm3_ = 0;
  bool simple_ = true;
};

using Corners = std::array<Vec3, 3>;

/// Divides at the middles of the edges until they are short enough.
void divide(const Corners& t, double edge_mm, std::vector<Corners>& out) {
  const double longest_mm = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  if (longest_mm <= edge_mm) return out.push_back(t);
  const Vec3 ab = 0.5 * (t[0] + t[1]), bc = 0.5 * (t[1] + t[2]), ca = 0.5 * (t[2] + t[0]);
  for (const Corners& part :
       {Corners{t[0], ab, ca}, Corners{ab, t[1], bc}, Corners{ca, bc, t[2]}, Corners{ab, bc, ca}}) {
    divide(part, edge_mm, out);
  }
}

/// Whether one side of a part of a surface is inside and the other is not, at its middle or near a corner.
bool is_boundary(const LineCrossings& lines, const Corners& t, double beside_mm) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  if (normal.norm() == 0) return false;
  const Vec3 step = beside_mm * normal.normalized(), middle = (t[0] + t[1] + t[2]) / 3;
  const auto differs_at = [&](const Vec3& p) { return (lines.winding(p + step) > 0) != (lines.winding(p - step) > 0); };
  return differs_at(middle) ||
         std::ranges::any_of(t, [&](const Vec3& corner) { return differs_at(0.3 * middle + 0.7 * corner); });
}

/// The triangles at the boundary of the inside: without walls inside the solid and flaps outside. Triangles are divided
/// to edges of at most `edge_mm`, so that they end where surfaces cross. For distances only: it has cracks.
TriangleMesh boundary_of_inside(const TriangleMesh& mesh, double edge_mm) {
  constexpr double kBeside = 1e-7;  // of the size of the mesh
  const LineCrossings lines(mesh, 2);
  const double beside_mm = kBeside * (mesh.bounds().max - mesh.bounds().min).maxCoeff();
  std::vector<std::vector<Corners>> kept(mesh.triangles.size());
  parallel_items(mesh.triangles.size(), [&](std::size_t i) {
    divide(mesh.corners(mesh.triangles[i]), edge_mm, kept[i]);
    std::erase_if(kept[i], [&](const Corners& part) { return !is_boundary(lines, part, beside_mm); });
  });
  TriangleMesh out;
  for (const auto& parts : kept) {
    for (const Corners& part : parts) {
      const auto first = static_cast<std::int32_t>(out.vertices.size());
      out.vertices.insert(out.vertices.end(), part.begin(), part.end());
      out.triangles.push_back({first, first + 1, first + 2});
    }
  }
  return out;
}

/// A distance interpolated between its samples: at `fraction` spacings beyond the sample `lower`.
template <class Samples>
double value_between(const Samples& distance, const Vec3i& lower, const Vec3& fraction) {
  double sum = 0;
  for_each_trilinear_weight(fraction, [&](const Vec3i& step, double weight) {
    sum += weight * double{distance.getValue(vdb_coord(lower + step))};
  });
  return sum;
}

/// The same at the coordinates of samples.
double distance_between(const openvdb::FloatTree& distance, const Vec3& index) {
  const Vec3 base = index.array().floor();
  return value_between(distance, base.cast<int>(), index - base);
}

constexpr double kSamplesInLayer = 5;  // the least number of samples across a layer
/// Every voxel is sampled down to this depth, voxels, where the samples below are further apart.
constexpr double kNearVoxels = 3;
constexpr double kBeyond = 2;  // sampled beyond the layer, so that its end lies between samples

/// Signed distance of voxel centres from a closed mesh, voxels, negative inside. Near the surface it is sampled at
/// every voxel. Where a layer is many voxels thick, the distance below that is interpolated linearly between samples
/// some voxels apart: a band of all voxels down to 1.5 mm takes most of the time and the memory of loading a fine bone.
class MeshDepth {
 public:
  /// `layer_voxels`: the depth of the distances. `inside`: for a mesh that is not clean. Throws InputError.
  MeshDepth(const std::string& path, const TriangleMesh& mesh, const VoxelGrid& grid, double layer_voxels,
            const InsideColumns* inside = nullptr)
      : ratio_(std::max(1, static_cast<int>(layer_voxels / kSamplesInLayer))) {
    const DistanceSampling near{.first_mm = grid.center_mm({0, 0, 0}),
                                .spacing_mm = grid.voxel_mm,
                                .outer_spacings = kMarginVoxels - 1,
                                .inner_spacings = ratio_ == 1 ? layer_voxels + kBeyond : kNearVoxels};
    DistanceSampling deep = near;
    deep.spacing_mm = ratio_ * grid.voxel_mm;
    deep.inner_spacings = layer_voxels / ratio_ + kBeyond;
    try {
      if (inside == nullptr) {
        near_ = mesh_distance(mesh, near);
        deep_ = ratio_ == 1 ? near_ : mesh_distance(mesh, deep);
        return;
      }
      constexpr double kEdgeVoxels = 2;
      const TriangleMesh boundary = inside->is_simple() ? mesh : boundary_of_inside(mesh, kEdgeVoxels * grid.voxel_mm);
      const auto contains = [&](int ratio) {
        return [inside, ratio](const Vec3i& sample) { return inside->contains(ratio * sample); };
      };
      near_ = mesh_distance(boundary, near, grid.dims, contains(1));
      deep_ = ratio_ == 1 ? near_ : mesh_distance(boundary, deep, grid.dims / ratio_, contains(ratio_));
    } catch (const std::bad_alloc&) {
      refuse_file(path, "the distance field of the mesh does not fit into memory", "increase bone.voxel_mm");
    } catch (const openvdb::Exception&) {
      refuse_file(path, "the mesh cannot be voxelized", "give a closed surface");
    }
  }

  /// Distances near the surface, by voxel; constant outside and below.
  [[nodiscard]] const openvdb::FloatTree& near_surface() const { return near_->tree(); }
  [[nodiscard]] bool interpolated() const { return ratio_ > 1; }
  /// The interpolated distance at voxel coordinates, below the surface.
  [[nodiscard]] double below(const Vec3& voxel) const {
    return ratio_ * distance_between(deep_->tree(), voxel / ratio_);
  }

  using Distances = std::array<float, BrickLattice::kVoxels>;
  /// The distances of a brick's voxels, by BrickLattice::offset_of().
  void of_brick(const Vec3i& brick, Distances& out) const {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    static_assert(Leaf::DIM == BrickLattice::kSide);
    const Vec3i first = BrickLattice::kSide * brick;
    const openvdb::Coord corner = vdb_coord(first);
    const Leaf* leaf = near_->tree().probeConstLeaf(corner);
    const float all = leaf == nullptr ? near_->tree().getValue(corner) : 0;
    const openvdb::tree::ValueAccessor<const openvdb::FloatTree, false> deep(deep_->tree());
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const Vec3i v = BrickLattice::voxel_at(Vec3i::Zero(), offset);
      float& distance = out[static_cast<std::size_t>(offset)];
      distance = leaf == nullptr ? all : leaf->getValue(Leaf::coordToOffset(vdb_coord(v)));
      if (!interpolated() || distance > -kNearVoxels) continue;
      const Vec3i voxel = first + v, lower = voxel / ratio_;
      const Vec3 fraction = (voxel - ratio_ * lower).cast<double>() / ratio_;
      distance = static_cast<float>(ratio_ * value_between(deep, lower, fraction));
    }
  }

 private:
  openvdb::FloatGrid::Ptr near_;
  openvdb::FloatGrid::Ptr deep_;  ///< distances in spacings of `ratio_` voxels, from the first voxel on
  int ratio_ = 1;
};

/// Largest relative deviation of the voxelized volume from that of the mesh without a warning.
constexpr double kMaxVolumeError = 0.1;
/// Beyond this it is found out whether a closed mesh overlaps itself.
constexpr double kMaxVolumeErrorOfSimple = 0.01;

/// Grades by depth below the surface, voxels: cortical down to `cortical_voxels`, trabecular below.
struct GradesByDepth {
  double cortical_voxels;
  std::uint8_t cortical;
  std::uint8_t trabecular;

  [[nodiscard]] std::uint8_t grade(double distance) const {
    const double depth = -distance;
    if (depth <= 0) return 0;
    return depth <= cortical_voxels ? cortical : trabecular;
  }
};

void grade_brick(const MeshDepth& depth, const GradesByDepth& by_depth, const Vec3i& brick_coord,
                 GradeBricks::Brick& out) {
  // The interpolated distance changes by at most one for each voxel along each axis.
  constexpr double kFromCentre = 3 * (GradeBricks::kSide - 1) / 2.0;
  const Vec3i first = GradeBricks::kSide * brick_coord;
  const openvdb::Coord corner = vdb_coord(first);
  if (depth.near_surface().probeConstLeaf(corner) == nullptr) {
    double all = depth.near_surface().getValue(corner);
    if (all > 0) return;
    bool uniform = !depth.interpolated();
    if (!uniform) {
      all = depth.below(first.cast<double>() + Vec3::Constant((GradeBricks::kSide - 1) / 2.0));
      uniform = std::abs(-all - by_depth.cortical_voxels) > kFromCentre;
    }
    if (uniform) return out.fill(by_depth.grade(all));
  }
  MeshDepth::Distances distances;
  depth.of_brick(brick_coord, distances);
  std::ranges::transform(distances, out.begin(), [&](float distance) { return by_depth.grade(distance); });
}

/// Sets the fill: of a mesh without overlaps exactly, else by the distance of the surface. Grades depend on the depth
/// only: there is no partial volume.
void set_fill_at_surface(const openvdb::FloatTree& distance, const TriangleMesh* simple, const GradesByDepth& by_depth,
                         FilledVoxmap& voxmap) {
  std::optional<MeshFractions> fractions;
  if (simple != nullptr) fractions.emplace(*simple, voxmap.grid);
  if (fractions && fractions->overlap()) fractions.reset();
  const auto between = [&](const Vec3& index) { return distance_between(distance, index); };
  const std::uint8_t outermost = by_depth.grade(-std::numeric_limits<float>::min());
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const double away = double{distance.getValue(vdb_coord(voxel))};
    const std::uint8_t bone = grade != 0 ? grade : outermost;
    if (fractions) return {fractions->at(voxel).value_or(away < 0 ? 1 : 0), bone};
    if (std::abs(away) > RS_CLIP_REACH) return {away < 0 ? 1.0 : 0.0, bone};
    return {fraction_inside(between, voxel.cast<double>(), 1), bone};
  };
  set_partial_fill(sample, voxmap);
}

/// Upper bound of the fraction of the mesh's box in bricks with bone: the volume, and the bricks at the surface. A
/// surface of area A intersects about √3·A/b² bricks of side b.
double bone_fraction(const BoneMesh& bone, double voxel_mm) {
  constexpr double kPassed = 2;
  const double box_mm3 = bone.mesh.bounds().half().prod() * 8;
  return std::min(1.0, (bone.outer_mm3 + kPassed * bone.mesh.area_mm2() * GradeBricks::kSide * voxel_mm) / box_mm3);
}

double relative_difference(double voxels_mm3, double mesh_mm3) {
  return std::abs(voxels_mm3 - mesh_mm3) / mesh_mm3;
}

/// Compares the volume of the voxels with that of the mesh, to detect leaks.
void check_volume(double mesh_mm3, bool by_winding, double voxels_mm3, Diagnostics& report) {
  report.note(fmt::format("bone volume: {:.0f} mm3 in voxels, {:.0f} mm3 in the mesh{}", voxels_mm3, mesh_mm3,
                          by_winding ? " by winding numbers, which count what surfaces enclose twice once" : ""));
  if (relative_difference(voxels_mm3, mesh_mm3) <= kMaxVolumeError) return;
  report.warn(
      fmt::format("the bone has {:.0f} mm3 in voxels but {:.0f} mm3 in the mesh: the mesh is thinner than a "
                  "voxel, or has the wrong scale (bone.mesh.scale)",
                  voxels_mm3, mesh_mm3));
}

/// `simple`: the outer surface of a mesh that overlaps itself little if at all, or null.
FilledVoxmap voxmap_of(const MeshDepth& depth, const TriangleMesh* simple, const BoneSettings& settings,
                       const VoxelGrid& grid, const GradesByDepth& by_depth) {
  FilledVoxmap out(grid);
  out.grade = sample_bricks(grid.dims, [&](const Vec3i& brick_coord, GradeBricks::Brick& brick) {
    grade_brick(depth, by_depth, brick_coord, brick);
  });
  if (out.count_bone() == 0) {
    throw InputError({settings.mesh.path, 0, 0}, "bone.voxel_mm", "the mesh contains no voxel centre",
                     "use smaller voxels, a larger bone.mesh.scale, or a closed mesh");
  }
  if (settings.surface_voxels == SurfaceVoxels::partial)
    set_fill_at_surface(depth.near_surface(), simple, by_depth, out);
  return out;
}

/// A clean surface is filled from outside; one that is not, or that overlaps itself, by winding numbers.
FilledVoxmap filled_voxmap(const BoneSettings& settings, const BoneMesh& source, const VoxelGrid& grid,
                           const GradesByDepth& by_depth, const StageSink& stages, Diagnostics& report) {
  if (source.was_clean) {
    const MeshDepth depth(settings.mesh.path, source.mesh, grid, by_depth.cortical_voxels);
    begin_stage(stages, BoneStage::voxels);
    const TriangleMesh outer = source.nested ? outer_surface(source.mesh) : TriangleMesh{};
    FilledVoxmap out = voxmap_of(depth, source.nested ? &outer : &source.mesh, settings, grid, by_depth);
    const bool fits = relative_difference(out.bone_mm3(), source.outer_mm3) <= kMaxVolumeErrorOfSimple;
    if (fits || InsideColumns(source.mesh, grid).is_simple()) {
      check_volume(source.outer_mm3, false, out.bone_mm3(), report);
      return out;
    }
    report.warn("the mesh overlaps itself; what is inside is decided by winding numbers");
  }
  TriangleMesh mesh = source.mesh;
  turn_outwards(mesh, true);  // a surface inside another creates no cavity
  const InsideColumns inside(mesh, grid);
  const MeshDepth depth(settings.mesh.path, mesh, grid, by_depth.cortical_voxels, &inside);
  begin_stage(stages, BoneStage::voxels);
  FilledVoxmap out = voxmap_of(depth, inside.is_simple() ? &mesh : nullptr, settings, grid, by_depth);
  check_volume(inside.volume_mm3(), true, out.bone_mm3(), report);
  return out;
}

}  // namespace

FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Diagnostics& report, const StageSink& stages) {
  const MeshBoneSettings& bone = settings.mesh;
  begin_stage(stages, BoneStage::read);
  const BoneMesh source = read_bone_mesh(settings, report);
  const VoxelGrid grid = lattice_around(bone.path, source.mesh.bounds(), settings.voxel_mm, kMarginVoxels,
                                        {bone_fraction(source, settings.voxel_mm), kMeshBytesPerVoxel});
  begin_stage(stages, BoneStage::distances);
  const DensityMapping mapping{settings.density};
  warn_of_density_limit(mapping, "bone.mesh.cortical_hu", bone.cortical_hu, report);
  warn_of_density_limit(mapping, "bone.mesh.trabecular_hu", bone.trabecular_hu, report);
  const GradesByDepth by_depth{bone.cortical_mm / settings.voxel_mm, mapping.grade_from_hu(bone.cortical_hu),
                               mapping.grade_from_hu(bone.trabecular_hu)};
  FilledVoxmap voxmap = filled_voxmap(settings, source, grid, by_depth, stages, report);
  voxmap.mapping = mapping;
  voxmap.layers = BoneLayers{bone.cortical_mm, DensityMapping::density_from_grade(by_depth.cortical),
                             DensityMapping::density_from_grade(by_depth.trabecular)};
  voxmap.frame = "mesh";
  return voxmap;
}

}  // namespace reamsim
