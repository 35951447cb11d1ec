// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/distance_grid.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>

#include "sim/base/error.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
constexpr int kSide = DistanceGrid::kSide, kRow = DistanceGrid::kRow;
static_assert(Leaf::DIM == kSide && BrickLattice::kSide == kSide);

/// Half width of the band with distances, voxels: the reach of a voxel's middle (RS_CLIP_REACH in kernels), √3
/// (RS_GRID_STEEPEST) times the half voxel of motion within a window, and an allowance for rounding.
constexpr double kBandVoxels = 0.91 + 0.87 + 0.07;
constexpr double kHalfDiagonalCells = 0.8660254;
constexpr double kFar = std::numeric_limits<double>::infinity();

/// Host memory per sample of the band in OpenVDB: distance, index of the nearest triangle, and copies.
constexpr double kWorkingBytesPerSample = 13;
constexpr double kStoredBytesPerBrick = DistanceGrid::kSamples * sizeof(float);

/// The lattice around the mesh, with an outer layer of bricks that the band does not reach.
DistanceGrid make_lattice(const TriangleMesh& mesh, double voxel_mm) {
  DistanceGrid grid;
  grid.spacing_mm = kGridSpacingVoxels * voxel_mm;
  grid.band_mm = kBandVoxels * voxel_mm;
  const Aabb box = mesh.bounds().expanded(grid.band_mm);
  const double brick_mm = kSide * grid.spacing_mm;
  grid.bricks = ((box.max - box.min).array() / brick_mm).ceil().cast<int>() + 2;
  grid.origin_mm = box.center() - 0.5 * brick_mm * grid.bricks.cast<double>();
  return grid;
}

/// Some distances of OpenVDB refer to a neighbour of the nearest triangle, and are too large. Limits every distance to
/// that of its neighbours along the axes plus the spacing, which the kernels rely on (RS_GRID_STEEPEST).
void limit_gradient(openvdb::FloatTree& distance) {
  openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(distance);
  for (bool lowered = true; lowered;) {
    lowered = false;
    for (auto leaf = distance.beginLeaf(); leaf; ++leaf) {
      for (auto value = leaf->beginValueOn(); value; ++value) {
        const float side = *value < 0 ? -1.0F : 1.0F;
        float least = side * *value;
        for (const Vec3i& step : kFaceSteps) {
          const float neighbour = side * accessor.getValue(value.getCoord() + vdb_coord(step));
          if (neighbour >= 0) least = std::min(least, neighbour + 1);
        }
        if (least >= side * *value) continue;
        value.setValue(side * least);
        lowered = true;
      }
    }
  }
}

/// Reads the samples of a brick, mm. Returns whether any lies within the band.
bool read_samples(const openvdb::FloatTree& distance, const DistanceGrid& grid, const Vec3i& brick, float* samples) {
  openvdb::tree::ValueAccessor<const openvdb::FloatTree> accessor(distance);
  const Vec3i first = kSide * brick;
  const auto spacing = static_cast<float>(grid.spacing_mm), band = static_cast<float>(grid.band_mm);
  bool near = false;
  for (int i = 0; i < static_cast<int>(DistanceGrid::kSamples); ++i) {
    const openvdb::Coord at(first.x() + i % kRow, first.y() + i / kRow % kRow, first.z() + i / (kRow * kRow));
    samples[i] = std::clamp(accessor.getValue(at) * spacing, -band, band);
    near = near || std::abs(samples[i]) < band;
  }
  return near;
}

void store_bricks(const openvdb::FloatTree& distance, DistanceGrid& grid) {
  const auto band = static_cast<float>(grid.band_mm);
  grid.samples.assign(DistanceGrid::kSamples, band);
  grid.samples.insert(grid.samples.end(), DistanceGrid::kSamples, -band);
  std::vector<float> samples(DistanceGrid::kSamples);
  const BrickLattice lattice{grid.bricks};
  for (std::size_t i = 0; i < lattice.count(); ++i) {
    const Vec3i brick = lattice.coord(i);
    const openvdb::Coord first = vdb_coord(kSide * brick);
    std::uint32_t slot = distance.getValue(first) < 0 ? DistanceGrid::kInside : DistanceGrid::kOutside;
    if (distance.probeConstLeaf(first) != nullptr && read_samples(distance, grid, brick, samples.data())) {
      slot = static_cast<std::uint32_t>(grid.stored_bricks());
      grid.samples.insert(grid.samples.end(), samples.begin(), samples.end());
    }
    grid.slot_of_brick.push_back(slot);
  }
}

/// Fraction of a line on which a linear function with values `a` and `b` at its ends is negative.
double negative_fraction(double a, double b) {
  if (a >= 0 && b >= 0) return 0;
  if (a < 0 && b < 0) return 1;
  return a < 0 ? a / (a - b) : b / (b - a);
}

/// Fraction of a cell inside, sampled by lines along x, on which the distance is linear.
double inside_fraction(const float* lowest) {
  constexpr int kLines = 8;
  constexpr int kAcross[4] = {0, kRow, kRow * kRow, kRow * kRow + kRow};
  std::array<float, 8> corners;  // x fastest
  for (std::size_t k = 0; k < 4; ++k) std::copy_n(lowest + kAcross[k], 2, &corners[2 * k]);
  const auto [least, most] = std::ranges::minmax(corners);
  if (least >= 0) return 0;
  if (most < 0) return 1;
  double sum = 0;
  for (int i = 0; i < kLines * kLines; ++i) {
    const int column = i % kLines, row = i / kLines;
    const double y = (column + 0.5) / kLines, z = (row + 0.5) / kLines;
    const double weights[4] = {(1 - y) * (1 - z), y * (1 - z), (1 - y) * z, y * z};
    double begin = 0, end = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      begin += weights[k] * double{corners[2 * k]};
      end += weights[k] * double{corners[2 * k + 1]};
    }
    sum += negative_fraction(begin, end);
  }
  return sum / (kLines * kLines);
}

double inside_volume_mm3(const DistanceGrid& grid) {
  std::vector<double> cells(grid.stored_bricks(), 0);  // inside, of each stored brick
  parallel_items(cells.size(), [&](std::size_t slot) {
    const float* samples = grid.samples.data() + slot * DistanceGrid::kSamples;
    for (int cell = 0; cell < BrickLattice::kVoxels; ++cell) {
      const Vec3i at = BrickLattice::voxel_at(Vec3i::Zero(), cell);
      cells[slot] += inside_fraction(samples + at.x() + std::ptrdiff_t{kRow} * (at.y() + kRow * at.z()));
    }
  });
  double sum = 0;
  for (const std::uint32_t slot : grid.slot_of_brick) sum += cells[slot];
  return sum * std::pow(grid.spacing_mm, 3);
}

/// Whether `axis` separates the triangle (relative to the box's centre) from the box.
bool separates(const Vec3& axis, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& half) {
  const double pa = axis.dot(a), pb = axis.dot(b), pc = axis.dot(c);
  const double reach = half.x() * std::abs(axis.x()) + half.y() * std::abs(axis.y()) + half.z() * std::abs(axis.z());
  return std::min({pa, pb, pc}) > reach || std::max({pa, pb, pc}) < -reach;
}

}  // namespace

DistanceGrid make_distance_grid(const TriangleMesh& mesh, const Profile& envelope, double voxel_mm) {
  DistanceGrid grid = make_lattice(mesh, voxel_mm);
  // One more spacing than the band, so that samples on its edge have a distance in spite of rounding.
  const double band = grid.band_mm / grid.spacing_mm + 1;
  try {
    const auto distance = mesh_distance(mesh, {.first_mm = grid.origin_mm,
                                               .spacing_mm = grid.spacing_mm,
                                               .outer_spacings = band,
                                               .inner_spacings = band,
                                               .exact = true});
    limit_gradient(distance->tree());
    store_bricks(distance->tree(), grid);
  } catch (const std::bad_alloc&) {
    throw InputError("tool.mesh: the distance grid does not fit into memory; increase bone.voxel_mm");
  } catch (const openvdb::Exception&) {
    throw InputError("tool.mesh: the distance grid cannot be computed; give a closed surface");
  }
  // Edges may protrude from the sampled envelope; the trilinear distance may be wrong by half a cell's diagonal.
  double beyond_mm = 0;
  for (const Vec3& v : mesh.vertices) beyond_mm = std::max(beyond_mm, envelope.nearest(rz_of(v)).distance_mm);
  grid.slack_mm = beyond_mm + kOutlineStepMm + kHalfDiagonalCells * grid.spacing_mm;
  grid.mesh_mm3 = mesh.volume_mm3();
  grid.volume_mm3 = inside_volume_mm3(grid);
  return grid;
}

DistanceGridPlan plan_distance_grid(const TriangleMesh& mesh, double voxel_mm) {
  const DistanceGrid lattice = make_lattice(mesh, voxel_mm);
  const double brick_mm = kSide * lattice.spacing_mm;
  // A slab of the band's width overlaps bricks with their middle within half a diagonal; curved ones overlap more.
  constexpr double kDiagonal = 1.7320508, kCurved = 1.3;
  const double lattice_bricks = lattice.bricks.cast<double>().prod();
  const double bricks =
      std::min(lattice_bricks,
               2 + kCurved * mesh.area_mm2() * (2 * lattice.band_mm + kDiagonal * brick_mm) / std::pow(brick_mm, 3));
  const double table = lattice_bricks * sizeof(std::uint32_t);
  const double kept = bricks * kStoredBytesPerBrick + table;
  return {.working_bytes = kept + bricks * BrickLattice::kVoxels * kWorkingBytesPerSample, .kept_bytes = kept};
}

void require_room_for_grid(double need_bytes, double have_bytes, double voxel_mm, const std::string& what) {
  if (need_bytes <= have_bytes) return;
  // The number of bricks in the band is inversely proportional to the square of the spacing.
  const double fitting_mm = 1.05 * voxel_mm * std::sqrt(need_bytes / have_bytes);
  const std::string text = fmt::format("the distance grid needs {:.4g} MB, but {} has {:.4g} MB available",
                                       need_bytes / 1e6, what, have_bytes / 1e6);
  const std::string fit = fmt::format("use voxels of about {:.3g} mm, or tool.spin: envelope", fitting_mm);
  throw InputError({}, "bone.voxel_mm", text, fit);
}

double DistanceTable::at(const Vec2& rz) const {
  const double r = (rz.x() - first.x()) / pitch_mm, z = (rz.y() - first.y()) / pitch_mm;
  if (r < 0 || z < 0 || z >= count_z - 1 || r >= count_r - 1) return kFar;
  const auto column = static_cast<std::size_t>(r), row = static_cast<std::size_t>(z);
  const double u = r - static_cast<double>(column), v = z - static_cast<double>(row);
  const float* corner = mm.data() + row * static_cast<std::size_t>(count_r) + column;
  const double low = (1 - u) * double{corner[0]} + u * double{corner[1]};
  const double high = (1 - u) * double{corner[count_r]} + u * double{corner[count_r + 1]};
  return (1 - v) * low + v * high;
}

double DistanceTable::nearest(const Vec2& rz) const {
  const double r = std::floor((rz.x() - first.x()) / pitch_mm + 0.5),
               z = std::floor((rz.y() - first.y()) / pitch_mm + 0.5);
  if (r < 0 || z < 0 || r >= count_r || z >= count_z) return kFar;
  return double{mm[static_cast<std::size_t>(r) + static_cast<std::size_t>(count_r) * static_cast<std::size_t>(z)]};
}

DistanceTable make_distance_table(const Profile& profile, const Vec2& first, double pitch_mm, int count_r,
                                  int count_z) {
  DistanceTable out{first, pitch_mm, count_r, count_z, {}};
  out.mm.resize(static_cast<std::size_t>(count_r) * static_cast<std::size_t>(count_z));
  parallel_items(static_cast<std::size_t>(count_z), [&](std::size_t row) {
    for (int i = 0; i < count_r; ++i) {
      const Vec2 rz(first.x() + i * pitch_mm, first.y() + static_cast<double>(row) * pitch_mm);
      out.mm[row * static_cast<std::size_t>(count_r) + static_cast<std::size_t>(i)] =
          static_cast<float>(profile.nearest(rz).distance_mm);
    }
  });
  return out;
}

DistanceTable distance_table_around(const Profile& profile, double pitch_mm, double margin_mm) {
  const Aabb box = profile.bounds().expanded(margin_mm);
  return make_distance_table(profile, {0, box.min.z()}, pitch_mm,
                             static_cast<int>(std::ceil(box.max.x() / pitch_mm)) + 2,
                             static_cast<int>(std::ceil((box.max.z() - box.min.z()) / pitch_mm)) + 2);
}

bool triangle_touches_box(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& center, const Vec3& half) {
  const Vec3 p = a - center, q = b - center, r = c - center;
  const std::array<Vec3, 3> edges{q - p, r - q, p - r};
  for (int axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax({p[axis], q[axis], r[axis]});
    if (least > half[axis] || most < -half[axis]) return false;
  }
  if (separates(edges[0].cross(edges[1]), p, q, r, half)) return false;
  for (const Vec3& edge : edges) {
    for (int axis = 0; axis < 3; ++axis) {
      if (separates(Vec3::Unit(axis).cross(edge), p, q, r, half)) return false;
    }
  }
  return true;
}

}  // namespace reamsim
