// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/revolve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace reamsim {

namespace {

/// The vertices of one profile point; a single one on the axis.
struct Ring {
  std::int32_t first = 0;
  std::int32_t count = 0;

  [[nodiscard]] std::int32_t at(std::int32_t s) const { return first + s % count; }
};

Ring add_ring(TriangleMesh& mesh, const Vec2& rz, int segments) {
  Ring ring{static_cast<std::int32_t>(mesh.vertices.size()), Profile::on_axis(rz) ? 1 : segments};
  for (std::int32_t s = 0; s < ring.count; ++s) {
    const double angle = 2 * std::numbers::pi * s / segments;
    mesh.vertices.emplace_back(rz.x() * std::cos(angle), rz.x() * std::sin(angle), rz.y());
  }
  return ring;
}

}  // namespace

TriangleMesh revolve(const Profile& profile, int segments) {
  TriangleMesh mesh;
  std::vector<Ring> rings;
  for (const Vec2& rz : profile.points) rings.push_back(add_ring(mesh, rz, segments));
  for (std::size_t p = 0; p < rings.size(); ++p) {
    const Ring& a = rings[p];
    const Ring& b = rings[(p + 1) % rings.size()];
    for (std::int32_t s = 0; s < segments; ++s) {
      if (a.count > 1) mesh.triangles.push_back({a.at(s), a.at(s + 1), b.at(s + 1)});
      if (b.count > 1) mesh.triangles.push_back({a.at(s), b.at(s + 1), b.at(s)});
    }
  }
  return mesh;
}

int segments_for_sagitta(double radius_mm, double sagitta_mm) {
  constexpr int kLeast = 32;
  if (sagitta_mm >= radius_mm) return kLeast;
  const double half_angle = std::acos(1 - sagitta_mm / radius_mm);
  const int quarter = static_cast<int>(std::ceil(std::numbers::pi / half_angle / 4));
  return std::max(kLeast, 4 * quarter);
}

}  // namespace reamsim
