#include "sim/engine/common/profile_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/engine/common/nearest_lists.h"

namespace reamsim {

// The struct has the same layout on host and device.
static_assert(sizeof(ProfileEdge) == 36);

namespace {

/// The edge between two vertices, which the kernels store in single precision.
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
          .normal_z = f(-along.x() / length)};
}

double distance(const ProfileEdge& e, const Vec2& rz) {
  const Vec2 v = rz - Vec2(double{e.r0}, double{e.z0}), along(double{e.along_r}, double{e.along_z});
  return (v - std::clamp(v.dot(along) * double{e.inverse_length2}, 0.0, 1.0) * along).norm();
}

}  // namespace

ProfileTable full_profile_table(const Profile& profile) {
  ProfileTable table;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 a = profile.points[i], b = profile.points[(i + 1) % profile.points.size()];
    const bool on_axis = a.x() == 0 && b.x() == 0;
    if (a.cast<float>() == b.cast<float>() || on_axis) continue;
    table.near.numbers.push_back(static_cast<rs_u16>(table.pieces.size()));
    table.pieces.push_back(make_edge(a, b));
  }
  if (table.pieces.size() > std::numeric_limits<rs_u16>::max()) {
    throw InputError({}, "tool.mesh", "a profile of " + std::to_string(table.pieces.size()) + " edges",
                     "at most 65535 are possible");
  }
  table.near.lists.push_back({0, static_cast<rs_u32>(table.pieces.size())});
  return table;
}

ProfileTable make_profile_table(const Profile& profile, double voxel_mm) {
  ProfileTable table = full_profile_table(profile);
  if (table.pieces.empty()) return table;
  table.near = make_nearest_lists(
      profile, table.pieces.size(), [&](std::size_t i, const Vec2& rz) { return distance(table.pieces[i], rz); },
      voxel_mm);
  return table;
}

}  // namespace reamsim
