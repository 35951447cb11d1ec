#include "sim/collide/profile_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "kernels/bricks.h"
#include "sim/base/error.h"
#include "sim/collide/visit_plan.h"

namespace reamsim {

// Host and device lay the structs out alike.
static_assert(sizeof(ProfileEdge) == 40);
static_assert(sizeof(EdgeList) == 8);
static_assert(sizeof(ProfileGrid) == 16);

namespace {

/// Half the diagonal between the corner voxels' centres of a brick, in voxels, and as far as it moves within a window
/// of substeps.
const double kBrickReach = 0.5 * (RS_BRICK_SIDE - 1) * std::sqrt(3.0) + kWindowShiftVoxels;
constexpr double kGridVoxels = 4;
/// Touched voxels lie within a few voxels of the surface; teeth, resolved, may lie deeper, and use the full list.
constexpr double kBandVoxels = 8;
constexpr int kMostCells = 1 << 16;
/// Parts along each side into which a cell's surroundings are cut to find the edges that can be nearest.
constexpr int kParts = 8;
/// Room for the rounding of single precision in the kernels, mm.
constexpr double kSlack_mm = 1e-3;

/// The edge between two vertices as the kernels have them, in single precision.
ProfileEdge make_edge(const Vec2& exact_a, const Vec2& exact_b) {
  const Vec2 a = exact_a.cast<float>().cast<double>(), b = exact_b.cast<float>().cast<double>();
  const Vec2 along = b - a;
  const double length = along.norm();
  const auto f = [](double value) { return static_cast<float>(value); };
  // The inside lies to the left of a → b, so the outward normal points to the right.
  return {.r0 = f(a.x()),
          .z0 = f(a.y()),
          .along_r = f(along.x()),
          .along_z = f(along.y()),
          .r1 = f(b.x()),
          .z1 = f(b.y()),
          .inverse_length2 = f(1 / (length * length)),
          .normal_r = f(along.y() / length),
          .normal_z = f(-along.x() / length),
          .curvature = 0};
}

/// Curvature of a line through `corner` whose points before and after it are given, 1/mm; positive where the outline,
/// inside on its left, bulges. Nothing where the line has a corner.
std::optional<double> curvature_at(const Vec2& before, const Vec2& corner, const Vec2& after) {
  constexpr double kCorner = 0.2;  // rad
  const Vec2 a = corner - before, b = after - corner;
  const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  if (std::abs(turn) > kCorner) return std::nullopt;
  return 2 * turn / (a.norm() + b.norm());
}

/// Curvature of the line that the edge after point `i` is part of, as far as its ends are smooth. On the axis the line
/// goes on as its mirror image.
double edge_curvature(const Profile& profile, std::size_t i) {
  const std::vector<Vec2>& points = profile.points;
  const std::size_t n = points.size();
  const auto point = [&](std::size_t k) { return points[k % n]; };
  const auto mirrored = [](const Vec2& rz) { return Vec2(-rz.x(), rz.y()); };
  const Vec2 a = point(i), b = point(i + 1);
  const Vec2 before = Profile::on_axis(a) ? mirrored(b) : point(i + n - 1);
  const Vec2 after = Profile::on_axis(b) ? mirrored(a) : point(i + 2);
  const auto begin = curvature_at(before, a, b), end = curvature_at(a, b, after);
  if (begin && end) return 0.5 * (*begin + *end);
  return begin ? *begin : end.value_or(0);
}

double distance(const ProfileEdge& e, const Vec2& rz) {
  const Vec2 v = rz - Vec2(double{e.r0}, double{e.z0}), along(double{e.along_r}, double{e.along_z});
  return (v - std::clamp(v.dot(along) * double{e.inverse_length2}, 0.0, 1.0) * along).norm();
}

/// Lays the grid over the profile and a band round it; cells grow where there would be too many.
ProfileGrid lay_grid(const Profile& profile, double voxel_mm) {
  double top_r = 0, low_z = std::numeric_limits<double>::infinity(), top_z = -low_z;
  for (const Vec2& p : profile.points) {
    top_r = std::max(top_r, p.x());
    low_z = std::min(low_z, p.y());
    top_z = std::max(top_z, p.y());
  }
  const double margin = kBandVoxels * voxel_mm;
  const double width = top_r + margin, height = top_z - low_z + 2 * margin;
  const double cell_mm = std::max(kGridVoxels * voxel_mm, std::sqrt(width * height / kMostCells));
  return {static_cast<float>(low_z - margin), static_cast<float>(1 / cell_mm),
          static_cast<rs_i32>(std::ceil(width / cell_mm)), static_cast<rs_i32>(std::ceil(height / cell_mm))};
}

/// Of `among`, those that can be nearest to a point within `reach_mm` of `center`: distances change by no more than the
/// way that the point moves.
std::vector<rs_u16> nearest_within(const ProfileTable& table, const std::vector<rs_u16>& among, const Vec2& center,
                                   double reach_mm) {
  std::vector<double> distances;
  for (const rs_u16 i : among) distances.push_back(distance(table.edges[i], center));
  const double limit = *std::min_element(distances.begin(), distances.end()) + 2 * reach_mm + kSlack_mm;
  std::vector<rs_u16> out;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (distances[i] <= limit) out.push_back(among[i]);
  }
  return out;
}

/// The same, tighter: for each part of the square round `center`, and all together.
std::vector<rs_u16> nearest_by_parts(const ProfileTable& table, const std::vector<rs_u16>& among, const Vec2& center,
                                     double reach_mm) {
  const std::vector<rs_u16> coarse = nearest_within(table, among, center, reach_mm);
  const double part = 2 * reach_mm / kParts;
  std::vector<rs_u16> out;
  for (int i = 0; i < kParts * kParts && out.size() < coarse.size(); ++i) {
    const Vec2 at = center + part * Vec2(i % kParts + 0.5, i / kParts + 0.5) - Vec2::Constant(reach_mm);
    for (const rs_u16 edge : nearest_within(table, coarse, at, std::sqrt(0.5) * part)) out.push_back(edge);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
  }
  return out;
}

}  // namespace

ProfileTable full_profile_table(const Profile& profile) {
  ProfileTable table;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 a = profile.points[i], b = profile.points[(i + 1) % profile.points.size()];
    const bool on_axis = a.x() == 0 && b.x() == 0;
    if (a.cast<float>() == b.cast<float>() || on_axis) continue;
    table.numbers.push_back(static_cast<rs_u16>(table.edges.size()));
    table.edges.push_back(make_edge(a, b));
    table.edges.back().curvature = static_cast<float>(edge_curvature(profile, i));
  }
  if (table.edges.size() > std::numeric_limits<rs_u16>::max()) {
    throw InputError({}, "tool.mesh", "a profile of " + std::to_string(table.edges.size()) + " edges",
                     "at most 65535 are possible");
  }
  table.lists.push_back({0, static_cast<rs_u32>(table.edges.size())});
  return table;
}

ProfileTable make_profile_table(const Profile& profile, double voxel_mm) {
  ProfileTable table = full_profile_table(profile);
  if (table.edges.empty()) return table;
  table.grid = lay_grid(profile, voxel_mm);
  const double cell_mm = 1 / double{table.grid.per_mm};
  const double reach_mm = kBrickReach * voxel_mm + std::sqrt(0.5) * cell_mm + kSlack_mm;
  const std::vector<rs_u16> all = table.numbers;
  for (int z = 0; z < table.grid.count_z; ++z) {
    for (int r = 0; r < table.grid.count_r; ++r) {
      const Vec2 center((r + 0.5) * cell_mm, double{table.grid.z0} + (z + 0.5) * cell_mm);
      double nearest = std::numeric_limits<double>::infinity();
      for (const ProfileEdge& edge : table.edges) nearest = std::min(nearest, distance(edge, center));
      if (nearest > kBandVoxels * voxel_mm + reach_mm) {
        table.lists.push_back(table.lists.front());
        continue;
      }
      const std::vector<rs_u16> list = nearest_by_parts(table, all, center, reach_mm);
      table.lists.push_back({static_cast<rs_u32>(table.numbers.size()), static_cast<rs_u32>(list.size())});
      table.numbers.insert(table.numbers.end(), list.begin(), list.end());
    }
  }
  return table;
}

DeviceProfile::DeviceProfile(const cl::Device& device, const ProfileTable& table)
    : edges_(device, std::max<std::size_t>(1, table.edges.size()), "the tool's profile"),
      numbers_(device, std::max<std::size_t>(1, table.numbers.size()), "the tool's profile"),
      lists_(device, table.lists.size(), "the tool's profile"),
      grid_(device, 1, "the tool's profile") {
  if (!table.edges.empty()) edges_.write(device, table.edges.data(), table.edges.size());
  if (!table.numbers.empty()) numbers_.write(device, table.numbers.data(), table.numbers.size());
  lists_.write(device, table.lists.data(), table.lists.size());
  grid_.write(device, &table.grid, 1);
}

void DeviceProfile::set(cl::Kernel& kernel, cl_uint first_argument) const {
  kernel.set(first_argument, edges_);
  kernel.set(first_argument + 1, numbers_);
  kernel.set(first_argument + 2, lists_);
  kernel.set(first_argument + 3, grid_);
}

}  // namespace reamsim
