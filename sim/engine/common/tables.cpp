// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/tables.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <string>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

namespace {

/// Half the diagonal between the centres of a brick's corner voxels plus the motion within a window, voxels.
const double kBrickReach = 0.5 * (RS_BRICK_SIDE - 1) * std::sqrt(3.0) + kWindowShiftVoxels;
constexpr double kGridVoxels = 4;
/// Width of the band around the profile with lists of its own, voxels: touched voxels lie within a few voxels of the
/// surface. Resolved cutting edges may lie deeper, where the full list is used.
constexpr double kBandVoxels = 8;
constexpr int kMaxCells = 1 << 16;
/// Subdivisions of a cell's surroundings along each side in the search for the nearest parts.
constexpr int kParts = 8;
/// Allowance for the single precision of the kernels, mm.
constexpr double kSlack_mm = 1e-3;

/// The grid over the profile and its band. Its cells grow where there would be more than kMaxCells.
OutlineGrid make_grid(const Profile& profile, double voxel_mm) {
  const Aabb box = profile.bounds();
  const double margin = kBandVoxels * voxel_mm;
  const double width = box.max.x() + margin, height = box.max.z() - box.min.z() + 2 * margin;
  const double cell_mm = std::max(kGridVoxels * voxel_mm, std::sqrt(width * height / kMaxCells));
  return {static_cast<float>(box.min.z() - margin), static_cast<float>(1 / cell_mm),
          static_cast<rs_i32>(std::ceil(width / cell_mm)), static_cast<rs_i32>(std::ceil(height / cell_mm))};
}

using Arcs = std::vector<OutlineArc>;

/// The arcs of `among` that can be nearest to a point within `reach_mm` of `center`, because a distance changes by
/// at most the motion of the point.
std::vector<rs_u16> nearest_within(const Arcs& arcs, const std::vector<rs_u16>& among, const Vec2& center,
                                   double reach_mm) {
  std::vector<double> distances;
  for (const rs_u16 i : among) distances.push_back(arcs[i].distance(center));
  const double limit = std::ranges::min(distances) + 2 * reach_mm + kSlack_mm;
  std::vector<rs_u16> out;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (distances[i] <= limit) out.push_back(among[i]);
  }
  return out;
}

/// The same with a tighter bound: the union over the parts of the square around `center`.
std::vector<rs_u16> nearest_by_parts(const Arcs& arcs, const std::vector<rs_u16>& among, const Vec2& center,
                                     double reach_mm) {
  const std::vector<rs_u16> coarse = nearest_within(arcs, among, center, reach_mm);
  const double part = 2 * reach_mm / kParts;
  std::vector<rs_u16> out;
  for (int i = 0; i < kParts * kParts && out.size() < coarse.size(); ++i) {
    const int column = i % kParts, row = i / kParts;
    const Vec2 at = center + part * Vec2(column + 0.5, row + 0.5) - Vec2::Constant(reach_mm);
    for (const rs_u16 edge : nearest_within(arcs, coarse, at, std::sqrt(0.5) * part)) out.push_back(edge);
    std::ranges::sort(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
  }
  return out;
}

/// Adds lists for voxels of `voxel_mm`, each valid for all voxels of a brick whose centre lies in its cell.
void add_nearest_lists(const Profile& profile, const Arcs& arcs, double voxel_mm, OutlineTable& out) {
  const std::vector<rs_u16> all = out.numbers;
  out.grid = make_grid(profile, voxel_mm);
  const double cell_mm = 1 / double{out.grid.per_mm};
  const double reach_mm = kBrickReach * voxel_mm + std::sqrt(0.5) * cell_mm + kSlack_mm;
  for (int z = 0; z < out.grid.count_z; ++z) {
    for (int r = 0; r < out.grid.count_r; ++r) {
      const Vec2 center((r + 0.5) * cell_mm, double{out.grid.z0} + (z + 0.5) * cell_mm);
      double nearest = std::numeric_limits<double>::infinity();
      for (const OutlineArc& arc : arcs) nearest = std::min(nearest, arc.distance(center));
      if (nearest > kBandVoxels * voxel_mm + reach_mm) {
        out.lists.push_back(out.lists.front());
        continue;
      }
      const std::vector<rs_u16> list = nearest_by_parts(arcs, all, center, reach_mm);
      out.lists.push_back({static_cast<rs_u32>(out.numbers.size()), static_cast<rs_u32>(list.size())});
      out.numbers.insert(out.numbers.end(), list.begin(), list.end());
    }
  }
}

OutlinePiece make_piece(const OutlineArc& arc) {
  const auto f = [](double value) { return static_cast<float>(value); };
  return {.r0 = f(arc.begin.x()),
          .z0 = f(arc.begin.y()),
          .r1 = f(arc.end.x()),
          .z1 = f(arc.end.y()),
          .along_r0 = f(arc.along_begin.x()),
          .along_z0 = f(arc.along_begin.y()),
          .along_r1 = f(arc.along_end.x()),
          .along_z1 = f(arc.along_end.y()),
          .middle_r = f(arc.middle.x()),
          .middle_z = f(arc.middle.y()),
          .normal_r = f(arc.normal.x()),
          .normal_z = f(arc.normal.y()),
          .curvature = f(arc.curvature),
          .before = -1,
          .after = -1};
}

/// Whether `b` follows `a` with a sharp turn; the table has no edges on the axis between them.
bool sharp(const OutlineArc& a, const OutlineArc& b) {
  return a.end == b.begin && std::abs(angle_between(a.along_end, b.along_begin)) > kSharpTurn;
}

/// Length of the smooth section from arc `i` forwards (`step` 1) or backwards (-1), mm.
double smooth_length(const std::vector<OutlineArc>& arcs, std::size_t i, int step) {
  double length = 0;
  for (std::size_t k = 0; k < arcs.size(); ++k) {
    length += arcs[i].length();
    const std::size_t next = (i + arcs.size() + static_cast<std::size_t>(step)) % arcs.size();
    const OutlineArc &a = arcs[step > 0 ? i : next], &b = arcs[step > 0 ? next : i];
    if (a.end != b.begin || sharp(a, b)) break;
    i = next;
  }
  return length;
}

/// Marks the sharp corners, but for those next to a section shorter than a voxel, which a third plane would cut.
void mark_corners(const std::vector<OutlineArc>& arcs, double voxel_mm, std::vector<OutlinePiece>& pieces) {
  for (std::size_t i = 0; i < arcs.size(); ++i) {
    const std::size_t next = (i + 1) % arcs.size();
    if (next == i || !sharp(arcs[i], arcs[next])) continue;
    if (std::min(smooth_length(arcs, i, -1), smooth_length(arcs, next, 1)) < voxel_mm) continue;
    pieces[i].after = static_cast<rs_i32>(next);
    pieces[next].before = static_cast<rs_i32>(i);
  }
}

OutlineTable table_of(const Outline& outline, double voxel_mm) {
  OutlineTable table;
  const std::size_t count = outline.arcs.size();
  if (count > std::numeric_limits<rs_u16>::max()) {
    throw InputError({}, "tool.mesh", "a profile of " + std::to_string(count) + " lines and arcs",
                     "at most 65535 are possible");
  }
  std::transform(outline.arcs.begin(), outline.arcs.end(), std::back_inserter(table.pieces), make_piece);
  mark_corners(outline.arcs, voxel_mm, table.pieces);
  table.numbers.resize(count);
  std::iota(table.numbers.begin(), table.numbers.end(), rs_u16{0});
  table.lists.push_back({0, static_cast<rs_u32>(count)});
  table.bulge_mm = outline.bulge_mm;
  return table;
}

constexpr int kLargestSide = 1 << RS_CELL_BITS;
constexpr std::size_t kLanes = 16;
/// The window less three voxels for the rounding of its corner, one for the voxel of the last point, and a slack for
/// the rounding of fixed-point steps.
constexpr double kWindowVoxels = 32 - 4 - 0.01;

ShellCell bounds_of(const std::vector<Vec3i>& points) {
  Vec3i low = points.front(), high = points.front();
  for (const Vec3i& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3i span = high - low;
  return {{low.x(), low.y(), low.z()}, {span.x(), span.y(), span.z()}, 0, 0};
}

std::uint16_t offset_of(const Vec3i& point, const ShellCell& cell) {
  return static_cast<std::uint16_t>((point.x() - cell.first[0]) | (point.y() - cell.first[1]) << RS_CELL_BITS |
                                    (point.z() - cell.first[2]) << (2 * RS_CELL_BITS));
}

/// The bounds of a run are those of its cells' corners.
void append_runs(ShellCells& out) {
  for (std::size_t begin = 0; begin < out.cells.size(); begin += kRunCells) {
    const std::size_t end = std::min(out.cells.size(), begin + kRunCells);
    std::vector<Vec3i> corners;
    for (std::size_t c = begin; c < end; ++c) {
      const Vec3i first(out.cells[c].first);
      corners.push_back(first);
      corners.push_back(first + Vec3i(out.cells[c].span));
    }
    ShellCell run = bounds_of(corners);
    run.begin = static_cast<rs_u32>(begin);
    run.count = static_cast<rs_u32>(end - begin);
    out.runs.push_back(run);
  }
}

double interpolated(const std::vector<SpecificEnergySettings>& table, double density_g_cm3) {
  const auto above = std::ranges::upper_bound(table, density_g_cm3, {}, &SpecificEnergySettings::density_g_cm3);
  if (above == table.begin()) return table.front().energy_j_mm3;
  if (above == table.end()) return table.back().energy_j_mm3;
  const SpecificEnergySettings& below = *(above - 1);
  const double t = (density_g_cm3 - below.density_g_cm3) / (above->density_g_cm3 - below.density_g_cm3);
  return below.energy_j_mm3 + t * (above->energy_j_mm3 - below.energy_j_mm3);
}

}  // namespace

OutlineTable full_outline_table(const Profile& profile, double voxel_mm) {
  return table_of(fit_outline(profile), voxel_mm);
}

OutlineTable make_outline_table(const Profile& profile, double voxel_mm) {
  const Outline outline = fit_outline(profile);
  OutlineTable table = table_of(outline, voxel_mm);
  add_nearest_lists(profile, outline.arcs, voxel_mm, table);
  return table;
}

DeviceOutline upload_outline(const cl::Device& device, const OutlineTable& table) {
  constexpr const char* kWhat = "the tool's surface";
  return {cl::upload(device, table.pieces, kWhat), cl::upload(device, table.numbers, kWhat),
          cl::upload(device, table.lists, kWhat), cl::upload(device, std::array{table.grid}, kWhat)};
}

static_assert(DistanceGrid::kSide == RS_GRID_SIDE && DistanceGrid::kRow == RS_GRID_ROW);
static_assert(DistanceGrid::kSamples == RS_GRID_SAMPLES);

DistanceLattice distance_lattice(const DistanceGrid& grid) {
  DistanceLattice out{};
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = static_cast<float>(grid.origin_mm[i]);
    out.last[i] = static_cast<float>(RS_GRID_SIDE * grid.bricks[i]) - 0.5F;
    out.bricks[i] = grid.bricks[i];
  }
  out.per_mm = static_cast<float>(1 / grid.spacing_mm);
  out.slack_mm = static_cast<float>(grid.slack_mm);
  return out;
}

DeviceTeeth upload_teeth(const cl::Device& device, const DistanceGrid& grid, double voxel_mm, double bulge_mm,
                         std::size_t bone_bytes) {
  constexpr const char* kWhat = "the teeth's distance grid";
  const cl::DeviceInfo& info = device.info();
  const std::size_t free_bytes = info.global_memory_bytes - std::min(info.global_memory_bytes, bone_bytes);
  require_room_for_grid(static_cast<double>(grid.bytes()),
                        static_cast<double>(std::min(free_bytes, info.max_allocation_bytes)), voxel_mm, info.name);
  DistanceLattice lattice = distance_lattice(grid);
  lattice.slack_mm += static_cast<float>(bulge_mm);
  return {cl::upload(device, std::array{lattice}, kWhat), cl::upload(device, grid.slot_of_brick, kWhat),
          cl::upload(device, grid.samples, kWhat)};
}

int shell_cell_side(double shell_cell_voxels) {
  int side = kLargestSide;
  // The largest extent along an axis is the block's diagonal.
  while (side > 1 && (side - 1) * shell_cell_voxels * std::sqrt(3.0) > kWindowVoxels) side /= 2;
  return side;
}

ShellCells make_shell_cells(const PointShell& shell, int side) {
  ShellCells out;
  const int shift = 3 * std::countr_zero(static_cast<unsigned>(side));
  std::vector<Vec3i> points;
  for (std::size_t i = 0; i < shell.codes.size(); ++i) {
    points.push_back(morton_decode(shell.codes[i]));
    const bool last = i + 1 == shell.codes.size() || shell.codes[i + 1] >> shift != shell.codes[i] >> shift;
    if (!last) continue;
    ShellCell cell = bounds_of(points);
    cell.begin = static_cast<rs_u32>(out.offsets.size());
    cell.count = static_cast<rs_u32>(points.size());
    for (const Vec3i& p : points) out.offsets.push_back(offset_of(p, cell));
    while (out.offsets.size() % kLanes != 0) out.offsets.push_back(out.offsets.back());
    out.cells.push_back(cell);
    points.clear();
  }
  append_runs(out);
  return out;
}

double cutting_energy_mj(const CuttingSettings& cutting, double density_g_cm3, double voxel_mm) {
  constexpr double kMillijoulePerJoule = 1000;
  const auto& table = cutting.specific_energy_table;
  const double energy_j_mm3 = table.empty() ? cutting.specific_energy_j_mm3 : interpolated(table, density_g_cm3);
  const double whole = kMillijoulePerJoule * energy_j_mm3 * voxel_mm * voxel_mm * voxel_mm;
  if (!table.empty()) return whole;
  return whole * std::pow(density_g_cm3 / cutting.reference_density_g_cm3, cutting.density_exponent);
}

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm) {
  EnergyTable table;
  for (std::size_t grade = 1; grade < table.energy_mj.size(); ++grade) {
    const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    table.density[grade] = static_cast<rs_i32>(std::lround(density * RS_DENSITY_SCALE));
    table.energy_mj[grade] = cutting_energy_mj(cutting, density, voxel_mm);
    table.units[grade] = std::llround(table.energy_mj[grade] * RS_ENERGY_SCALE);
  }
  return table;
}

}  // namespace reamsim
