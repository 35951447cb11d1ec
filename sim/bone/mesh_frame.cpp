// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_frame.h"

#include <algorithm>
#include <optional>

namespace reamsim {

namespace {

/// Of the header; nullopt: another one.
std::optional<MeshFrame> stated_frame(const std::string& space) {
  if (space.empty()) return MeshFrame::file;
  if (space == "LPS" || space == "LEFT-POSTERIOR-SUPERIOR") return MeshFrame::lps;
  if (space == "RAS" || space == "RIGHT-ANTERIOR-SUPERIOR") return MeshFrame::ras;
  return std::nullopt;
}

std::string capitals_of(MeshFrame frame) {
  return frame == MeshFrame::ras ? "RAS" : "LPS";
}

std::string reason_of(MeshFrame asked, const std::string& space, const std::string& key) {
  if (asked != MeshFrame::file) return "by " + key;
  return "as its header says (SPACE=" + space + ")";
}

}  // namespace

void bring_into_lps(MeshContents& contents, MeshFrame asked, const std::string& path, const std::string& key,
                    Diagnostics& report) {
  const auto stated = stated_frame(contents.space);
  if (asked == MeshFrame::file && !stated) {
    throw InputError({path, 0, 0}, key, "the header of the mesh says SPACE=" + contents.space,
                     key.empty() ? "expected LPS or RAS" : "expected LPS or RAS: set lps or ras");
  }
  const MeshFrame frame = asked == MeshFrame::file ? *stated : asked;
  if (frame == MeshFrame::file) {
    return report.note("frame of the mesh: its header states none; the coordinates are taken as they stand, as LPS" +
                       (key.empty() ? "" : " (if they are RAS, set " + key + ": ras)"));
  }
  if (asked != MeshFrame::file && !contents.space.empty() && stated != asked) {
    report.warn(key + " is " + name_of(asked) + ", but the header of the mesh says SPACE=" + contents.space +
                "; the key counts");
  }
  report.note("frame of the mesh: " + capitals_of(frame) + ", " + reason_of(asked, contents.space, key) +
              (frame == MeshFrame::ras ? "; x and y were negated, because the bone frame is LPS" : ""));
  if (frame != MeshFrame::ras) return;
  for (Vec3& vertex : contents.mesh.vertices) vertex.head<2>() *= -1;
}

Aabb half_turned(const Aabb& box) {
  return {Vec3(-box.max.x(), -box.max.y(), box.min.z()), Vec3(-box.min.x(), -box.min.y(), box.max.z())};
}

namespace {

bool meet(const Aabb& a, const Aabb& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

}  // namespace

bool meet_after_half_turn_only(const Aabb& a, const Aabb& b) {
  return !meet(a, b) && meet(half_turned(a), b);
}

void warn_of_half_turn(const std::vector<Vec3>& points_mm, const std::string& key, const Aabb& mesh_mm,
                       Diagnostics& report) {
  constexpr double kRoom_mm = 10;  // a point on the face need not lie in the bone
  const Aabb here = mesh_mm.expanded(kRoom_mm), turned = half_turned(here);
  const auto all_in = [&](const Aabb& box) {
    return std::ranges::all_of(points_mm, [&](const Vec3& p) { return meet(box, {p, p}); });
  };
  const bool any_here = std::ranges::any_of(points_mm, [&](const Vec3& p) { return meet(here, {p, p}); });
  if (points_mm.empty() || any_here || !all_in(turned)) return;
  report.warn(
      "the points of " + key +
      " lie outside the mesh, and would lie in its box after a half turn about z: either they or the mesh are in "
      "RAS; set bone.mesh.frame, or change the sign of x and y of the points");
}

}  // namespace reamsim
