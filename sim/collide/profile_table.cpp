#include "sim/collide/profile_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "sim/base/error.h"

namespace reamsim {

// Host and device lay the structs out alike.
static_assert(sizeof(ProfileEdge) == 64);
static_assert(sizeof(EdgeList) == 8);
static_assert(sizeof(ProfileGrid) == 24);

namespace {

/// Half the diagonal between the corner voxels' centres of a block, in voxels.
const double kBlockReach = 1.5 * std::sqrt(3.0);
constexpr double kGridVoxels = 4;
/// Touched voxels lie within a few voxels of the surface; teeth, resolved, may lie deeper, and use the full list.
constexpr double kBandVoxels = 8;
constexpr int kMostCells = 1 << 18;
/// Slack for the rounding of distances, relative.
constexpr double kSlack = 1e-9;

ProfileEdge make_edge(const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.norm();
  // The inside lies to the left of a → b, so the outward normal points to the right.
  return {a.x(), a.y(), along.x(), along.y(), 1 / (length * length), along.y() / length, -along.x() / length, 0};
}

double distance(const ProfileEdge& e, double r, double z) {
  const double vr = r - e.r0, vz = z - e.z0;
  const double t = std::clamp((vr * e.along_r + vz * e.along_z) * e.inverse_length2, 0.0, 1.0);
  return std::hypot(vr - t * e.along_r, vz - t * e.along_z);
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
  return {low_z - margin, 1 / cell_mm, static_cast<rs_i32>(std::ceil(width / cell_mm)),
          static_cast<rs_i32>(std::ceil(height / cell_mm))};
}

/// The edges that can be nearest to a point within `reach_mm` of (r, z); empty where the surface is out of the band.
void append_list(ProfileTable& table, std::vector<double>& distances, double r, double z, double reach_mm,
                 double band_mm) {
  for (std::size_t i = 0; i < table.edges.size(); ++i) distances[i] = distance(table.edges[i], r, z);
  const double nearest = *std::min_element(distances.begin(), distances.end());
  if (nearest > band_mm + reach_mm) {
    table.lists.push_back(table.lists.front());
    return;
  }
  EdgeList list{static_cast<rs_u32>(table.numbers.size()), 0};
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (distances[i] > (nearest + 2 * reach_mm) * (1 + kSlack)) continue;
    table.numbers.push_back(static_cast<rs_u16>(i));
    ++list.count;
  }
  table.lists.push_back(list);
}

}  // namespace

ProfileTable full_profile_table(const Profile& profile) {
  ProfileTable table;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 a = profile.points[i], b = profile.points[(i + 1) % profile.points.size()];
    const bool on_axis = a.x() == 0 && b.x() == 0;
    if (a == b || on_axis) continue;
    table.numbers.push_back(static_cast<rs_u16>(table.edges.size()));
    table.edges.push_back(make_edge(a, b));
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
  const double cell_mm = 1 / table.grid.per_mm;
  const double reach_mm = kBlockReach * voxel_mm + std::sqrt(0.5) * cell_mm;
  std::vector<double> distances(table.edges.size());
  for (int z = 0; z < table.grid.count_z; ++z) {
    for (int r = 0; r < table.grid.count_r; ++r) {
      append_list(table, distances, (r + 0.5) * cell_mm, table.grid.z0 + (z + 0.5) * cell_mm, reach_mm,
                  kBandVoxels * voxel_mm);
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
