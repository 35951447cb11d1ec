// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/scene.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "sim/base/error.h"
#include "sim/bone/phantom.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/tool/profile.h"

namespace reamsim::bench {

namespace {

/// The face is oriented towards +x; behind it the cube extends into the neck.
const Vec3 kBoxCornerMm(-30, -20, -20);

VoxelGrid grid_of(int side) {
  return {Vec3i::Constant(side), kBoxMm / side, kBoxCornerMm};
}

/// Calls visit(coord) for begin ≤ coord < end, x fastest.
template <class Visit>
void for_each_coord(const Vec3i& begin, const Vec3i& end, const Visit& visit) {
  for (int z = begin.z(); z < end.z(); ++z) {
    for (int y = begin.y(); y < end.y(); ++y) {
      for (int x = begin.x(); x < end.x(); ++x) visit(Vec3i(x, y, z));
    }
  }
}

FilledVoxmap sample(int side) {
  BoneSettings settings;
  settings.source = BoneSource::phantom;
  settings.side = BodySide::left;
  return sample_glenoid(settings, grid_of(side));
}

Aabb tight_box(const Voxmap& voxmap) {
  Vec3i low = voxmap.grid.dims, high = Vec3i::Constant(-1);
  for_each_coord(Vec3i::Zero(), voxmap.grid.dims, [&](const Vec3i& voxel) {
    if (voxmap.grade.get(voxel) == 0) return;
    low = low.cwiseMin(voxel);
    high = high.cwiseMax(voxel);
  });
  const VoxelGrid& grid = voxmap.grid;
  return {grid.origin_mm + grid.voxel_mm * low.cast<double>(),
          grid.origin_mm + grid.voxel_mm * (high + Vec3i::Ones()).cast<double>()};
}

/// The two coarse voxels about the centre of a fine one, with integer weights whose sum is 2·factor.
struct Between {
  int low, high;
  int weight_low, weight_high;

  Between(int fine, int factor, int coarse_side) {
    const int position = 2 * fine + 1 - factor;  // in units of 1/(2·factor) coarse voxel from the first centre
    const int unit = 2 * factor;
    const int floor = position >= 0 ? position / unit : -1;
    weight_high = position - floor * unit;
    weight_low = unit - weight_high;
    low = std::clamp(floor, 0, coarse_side - 1);
    high = std::clamp(floor + 1, 0, coarse_side - 1);
  }
};

/// Bricks of the finer voxmap: a voxel is bone where the interpolated fraction of bone is at least half, with the mean
/// grade of the bone about it.
class Refinement {
 public:
  Refinement(const Voxmap& coarse, int factor) : coarse_(coarse), factor_(factor), side_(coarse.grid.dims.x()) {}

  /// False where the brick is all air.
  bool brick(const Vec3i& coord, GradeBricks::Brick& out) const {
    const Vec3i first = kSide * coord;
    if (all_air_about(first)) return false;
    bool any = false;
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) any |= row(first, y, z, &out[static_cast<std::size_t>(kSide * (y + kSide * z))]);
    }
    return any;
  }

 private:
  static constexpr int kSide = GradeBricks::kSide;
  /// Weight of bone and weighted grade along a line of coarse voxels.
  struct Line {
    std::array<int, kSide + 2> bone{}, grade{};
  };

  [[nodiscard]] bool all_air_about(const Vec3i& first) const {
    const auto clamped = [&](const Vec3i& voxel) -> Vec3i {
      return voxel.cwiseMax(0).cwiseMin(Vec3i::Constant(side_ - 1));
    };
    const Vec3i low = BrickLattice::brick_of(clamped(first / factor_ - Vec3i::Ones()));
    const Vec3i high = BrickLattice::brick_of(clamped((first + Vec3i::Constant(kSide)) / factor_ + Vec3i::Ones()));
    bool all_air = true;
    for_each_coord(low, high + Vec3i::Ones(),
                   [&](const Vec3i& brick) { all_air = all_air && coarse_.grade.brick(brick) == nullptr; });
    return all_air;
  }

  bool row(const Vec3i& first, int y, int z, std::uint8_t* out) const {
    const Between by(first.y() + y, factor_, side_), bz(first.z() + z, factor_, side_);
    const int x_low = Between(first.x(), factor_, side_).low;
    const int x_high = Between(first.x() + kSide - 1, factor_, side_).high;
    Line line;
    add(by.low, bz.low, by.weight_low * bz.weight_low, x_low, x_high, line);
    add(by.high, bz.low, by.weight_high * bz.weight_low, x_low, x_high, line);
    add(by.low, bz.high, by.weight_low * bz.weight_high, x_low, x_high, line);
    add(by.high, bz.high, by.weight_high * bz.weight_high, x_low, x_high, line);
    const int whole = 8 * factor_ * factor_ * factor_;
    bool any = false;
    for (int x = 0; x < kSide; ++x) {
      const Between bx(first.x() + x, factor_, side_);
      const auto l = static_cast<std::size_t>(bx.low - x_low), h = static_cast<std::size_t>(bx.high - x_low);
      const int bone = bx.weight_low * line.bone[l] + bx.weight_high * line.bone[h];
      const int grade = bx.weight_low * line.grade[l] + bx.weight_high * line.grade[h];
      if (2 * bone < whole) continue;
      out[x] = static_cast<std::uint8_t>(grade / bone);
      any = true;
    }
    return any;
  }

  void add(int y, int z, int weight, int x_low, int x_high, Line& line) const {
    for (int x = x_low; x <= x_high; ++x) {
      const int grade = coarse_.grade.get({x, y, z});
      if (grade == 0) continue;
      line.bone[static_cast<std::size_t>(x - x_low)] += weight;
      line.grade[static_cast<std::size_t>(x - x_low)] += weight * grade;
    }
  }

  const Voxmap& coarse_;
  int factor_;
  int side_;
};

FilledVoxmap refine(const Voxmap& coarse, int side) {
  FilledVoxmap fine(grid_of(side));
  const Refinement refinement(coarse, side / coarse.grid.dims.x());
  fine.grade = sample_bricks(
      fine.grid.dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) { return refinement.brick(coord, brick); });
  return fine;
}

/// Mean grade of the bone among factor³ voxels, air where less than half of them are bone.
std::uint8_t merged(const Voxmap& fine, const Vec3i& first, int factor) {
  int bone = 0, grade = 0;
  for_each_coord(Vec3i::Zero(), Vec3i::Constant(factor), [&](const Vec3i& offset) {
    const int g = fine.grade.get(first + offset);
    bone += g != 0;
    grade += g;
  });
  return static_cast<std::uint8_t>(2 * bone >= factor * factor * factor ? grade / bone : 0);
}

FilledVoxmap merge(const Voxmap& fine, int side) {
  FilledVoxmap coarse(grid_of(side));
  const int factor = fine.grid.dims.x() / side;
  for_each_coord(Vec3i::Zero(), coarse.grid.dims, [&](const Vec3i& voxel) {
    if (const std::uint8_t grade = merged(fine, factor * voxel, factor); grade != 0) coarse.grade.set(voxel, grade);
  });
  return coarse;
}

/// A hemisphere with its lowest point at the origin, closed by a lid that the shell does not have.
Profile hemisphere() {
  constexpr int kSteps = 96;
  Profile profile;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = std::numbers::pi / 2 * i / kSteps;
    profile.points.emplace_back(i == 0 ? 0 : kReamerMm * std::sin(angle), kReamerMm * (1 - std::cos(angle)));
  }
  profile.points.back() = {kReamerMm, kReamerMm};
  profile.points.emplace_back(0, kReamerMm);
  return profile;
}

}  // namespace

BoneSeries::BoneSeries(int sampled) : sampled_(sample(sampled)), box_mm_(tight_box(sampled_)) {}

FilledVoxmap BoneSeries::at(int side) const {
  const int sampled = sampled_.grid.dims.x();
  FilledVoxmap out = side == sampled ? sampled_ : side > sampled ? refine(sampled_, side) : merge(sampled_, side);
  out.mapping = sampled_.mapping;
  out.frame = sampled_.frame;
  return out;
}

Aabb BoneSeries::box(int side) const {
  const VoxelGrid grid = grid_of(side);
  if (side >= sampled_.grid.dims.x()) return box_mm_;
  const Vec3 low = ((box_mm_.min - grid.origin_mm) / grid.voxel_mm).array().floor();
  const Vec3 high = ((box_mm_.max - grid.origin_mm) / grid.voxel_mm).array().ceil();
  return {grid.origin_mm + grid.voxel_mm * low, grid.origin_mm + grid.voxel_mm * high};
}

Tool cap_tool(int resolution) {
  constexpr double kFacetCells = 0.02;
  const int cells = std::max(2, static_cast<int>(std::lround(kCapFraction * resolution)));
  Tool tool;
  tool.profile = hemisphere();
  const double cell_mm = 2 * kReamerMm / (cells - 1);
  tool.mesh = revolve(tool.profile, segments_for_sagitta(kReamerMm, kFacetCells * cell_mm));
  tool.bounds = tool.mesh.bounds();
  TriangleMesh cap = tool.mesh;
  std::erase_if(cap.triangles, [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](std::int32_t vertex) {
      return cap.vertices[static_cast<std::size_t>(vertex)].z() == kReamerMm;
    });
  });
  tool.shell = voxelize_surface(cap, cells);
  tool.shell.resolution = resolution;  // the codes fill a corner of the larger grid
  tool.reach_mm = std::numbers::sqrt2 * kReamerMm + cell_mm;
  return tool;
}

Aabb shell_box(const Tool& tool) {
  const Vec3 margin = Vec3::Constant(0.5 * tool.shell.cell_mm);
  return {tool.bounds.min - margin, tool.bounds.max + margin};
}

CuttingSettings bench_cutting() {
  CuttingSettings cutting;
  cutting.erosion = ErosionMode::remove;
  return cutting;
}

}  // namespace reamsim::bench
