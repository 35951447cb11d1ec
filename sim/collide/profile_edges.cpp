#include <cmath>

#include "sim/collide/dense_state.h"

namespace reamsim {

std::vector<ProfileEdge> profile_edges(const Profile& profile) {
  std::vector<ProfileEdge> edges;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 a = profile.points[i], b = profile.points[(i + 1) % profile.points.size()];
    const double length = (b - a).norm();
    const bool on_axis = a.x() == 0 && b.x() == 0;
    if (length == 0 || on_axis) continue;
    // The inside lies to the left of a → b, so the outward normal points to the right.
    edges.push_back({a.x(), a.y(), b.x(), b.y(), (b - a).y() / length, -(b - a).x() / length});
  }
  return edges;
}

}  // namespace reamsim
