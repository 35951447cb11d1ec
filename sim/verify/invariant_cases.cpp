// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Invariants: no load without a cut, and the same loads under symmetries.
#include <algorithm>
#include <numbers>

#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

using std::numbers::pi;

constexpr double kInvariantRate_hz = 1000, kInvariantVoxel_mm = 0.25, kDensity = 1.8;
constexpr SteadyPlunge kHead{12, 5, 1, 250, 0.2, kDensity};
constexpr double kHead_mm = 6;

Tool head() {
  return make_tool(convex_profile(*kHead.radius_mm, kHead.outer_mm, kHead.bore_mm, kHead_mm, 0.05));
}

Quat oblique(double degrees) {
  return rotation({1, 0.4, 0}, degrees);
}

/// Largest loads and removed volume over rows.
struct Most {
  double force_n = 0;
  double torque_nmm = 0;
  double removed_mm3 = 0;
};

Most most_of(std::span<const FrameResult> rows) {
  Most out;
  for (const FrameResult& row : rows) {
    out.force_n = std::max(out.force_n, row.force_n.norm());
    out.torque_nmm = std::max(out.torque_nmm, row.torque_nmm.norm());
    out.removed_mm3 += row.removed_mm3;
  }
  return out;
}

void add_nothing(std::span<const FrameResult> rows, double cut_mm3, Report& out) {
  const Most most = most_of(rows);
  const std::string reason = "exact zero: the fill is compared as an integer";
  out.absolute("largest force", "N", 0, most.force_n, 0, reason);
  out.absolute("largest torque", "N·mm", 0, most.torque_nmm, 0, reason);
  out.absolute("volume removed", "mm³", 0, most.removed_mm3, 0, reason);
  out.at_least("volume removed before", "mm³", 10, cut_mm3, "the test needs removed bone");
}

/// The block reamed by the head along a path.
Reamed reamed_along(const std::vector<Leg>& legs, const Setting& setting) {
  const Motion motion = path(kInvariantRate_hz, {0.03, 0.05, 2.5}, legs);
  return ream(scene_of(block({20, 20, 8}, kInvariantVoxel_mm, kDensity), head(), motion), setting);
}

constexpr int kDown = 100;

Leg down_leg() {
  const Quat turned = oblique(12);
  return {Vec3(0.03, 0.05, 2.5) - turned * Vec3(0, 0, 4.5), kDown, 250, turned};
}

/// A rotation or reflection with a translation: p → turn·p + shift. `turn` is orthogonal.
struct Change {
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();

  [[nodiscard]] double handedness() const { return turn.determinant(); }
};

/// The transformed path. The tool is a surface of revolution, so its mirror image is itself, rotated.
Motion changed(const Motion& motion, const Change& change) {
  const Mat3 flip = change.handedness() < 0 ? Mat3(Vec3(-1, 1, 1).asDiagonal()) : Mat3(Mat3::Identity());
  std::vector<ToolPose> poses = motion.poses.all();
  for (ToolPose& pose : poses) {
    pose.position_mm = change.turn * pose.position_mm + change.shift;
    pose.orientation = Quat(Mat3(change.turn * pose.orientation.toRotationMatrix() * flip));
    pose.spin_angle_rad *= change.handedness();
    pose.spin_rpm *= change.handedness();
  }
  return {motion.frame_rate_hz, std::move(poses)};
}

/// A density without symmetry, g/cm³.
double uneven_density(const Vec3& p) {
  return 1.0 + 0.5 * std::sin(1.3 * p.x() + 0.4) * std::cos(0.9 * p.y() - 0.2) +
         0.3 * std::sin(2.1 * p.z() + 0.3 * p.x());
}

constexpr double kChangedBlock_mm = 20;

/// The transformed block, for a `turn` that permutes the axes of the lattice.
FilledVoxmap changed_block(const Change& change) {
  const Mat3 back = change.turn.transpose();
  FilledVoxmap bone = block({kChangedBlock_mm, kChangedBlock_mm, 8}, kInvariantVoxel_mm,
                            [&](const Vec3& p) { return uneven_density(back * p); });
  bone.grid.origin_mm += change.shift;
  return bone;
}

/// Compares the transformed loads of a scene with the loads of the transformed scene: the largest differences over the
/// frames, as fractions of the largest loads.
void compare(const Change& change, const Setting& setting, double tolerance, const std::string& reason, Report& out) {
  const Quat turned = oblique(12);
  const Leg down = down_leg(), side{down.to_mm + Vec3(1.5, 0.7, 0), 60, 250, turned};
  const Motion motion = path(kInvariantRate_hz, {0.03, 0.05, 2.5}, {down, side});
  const Reamed plain = ream(scene_of(changed_block({}), head(), motion), setting);
  const Reamed other = ream(scene_of(changed_block(change), head(), changed(motion, change)), setting);
  double force = 0, torque = 0;
  for (std::size_t k = 0; k < plain.rows.size(); ++k) {
    const FrameResult &a = plain.rows[k], &b = other.rows[k];
    force = std::max(force, (b.force_n - change.turn * a.force_n).norm());
    // An axial vector.
    torque = std::max(torque, (b.torque_nmm - change.handedness() * (change.turn * a.torque_nmm)).norm());
  }
  const Most most = most_of(plain.rows);
  out.absolute("force, maximum difference over maximum force", "", 0, force / most.force_n, tolerance, reason);
  out.absolute("torque, likewise", "", 0, torque / most.torque_nmm, tolerance, reason);
  out.relative("removed volume", "mm³", plain.removed_mm3(), other.removed_mm3(), 1e-5, reason);
}

}  // namespace

void zero_feed_case(const Setting& setting, Report& out) {
  out.title = "Zero feed";
  out.scene = "cannulated convex head plunged along an axis tilted by 12°, then rotated at zero feed for 100 frames";
  out.form = "no force, no torque, nothing removed";
  Leg stay = down_leg();
  stay.frames = 100;
  const Reamed reamed = reamed_along({down_leg(), stay}, setting);
  add_nothing(reamed.after(kDown), reamed.removed_mm3(), out);
}

void retraction_case(const Setting& setting, Report& out) {
  out.title = "Retraction";
  out.scene =
      "cannulated convex head plunged 1.5 mm along an axis tilted by 12° in steps of 2.5 µm, then retracted along the "
      "axis four times as fast";
  out.form = "no force, no torque, nothing removed";
  const Quat turned = oblique(12);
  const Vec3 axis = turned * Vec3(0, 0, 1), entry(0.03, 0.05, 0);
  // The lowest point of the rim touches the face first.
  const double touch = kHead.outer_mm * std::tan(12 * pi / 180);
  const Vec3 above = entry + (touch + 0.05) * axis, low = above - 1.5 * axis;
  const Leg slow{low, 600, 250, turned}, back{above, 150, 250, turned};
  const Reamed reamed = ream(
      scene_of(block({20, 20, 8}, kInvariantVoxel_mm, kDensity), head(), path(kInvariantRate_hz, above, {slow, back})),
      setting);
  add_nothing(reamed.after(600), reamed.removed_mm3(), out);
  // In such a fast plunge the corner of the rim does not pass each voxel at its deepest position.
  Leg fast = down_leg(), fast_back = fast;
  fast_back.to_mm = {0.03, 0.05, 2.5};
  fast_back.frames = 3 * kDown;
  const Reamed coarse = reamed_along({fast, fast_back}, setting);
  out.at_most("removed after a plunge in steps of 45 µm, fraction of the plunge volume", "", 1e-4,
              most_of(coarse.after(kDown)).removed_mm3 / coarse.removed_mm3(),
              "on retraction the rim, a corner, passes the voxels of the wall at other positions");
}

void second_pass_case(const Setting& setting, Report& out) {
  out.title = "Second pass along the same path";
  out.scene = "a tilted plunge and a sideways sweep through bone, then the whole path once more in the reamed bone";
  out.form = "no force, no torque, nothing removed";
  const Quat turned = oblique(12);
  const Leg down = down_leg(), side{down.to_mm + Vec3(2, 1, 0), 60, 250, turned};
  SimulationInput scene = scene_of(block({24, 24, 8}, kInvariantVoxel_mm, kDensity), head(),
                                   path(kInvariantRate_hz, {0.03, 0.05, 2.5}, {down, side}));
  const Reamed first = ream(scene, setting);
  scene.bone = first.bone;
  const Reamed second = ream(std::move(scene), setting);
  add_nothing(second.after(0), first.removed_mm3(), out);
}

void mirrored_case(const Setting& setting, Report& out) {
  out.title = "Mirrored scene";
  out.scene = "tilted plunge and sweep through uneven bone, and the same in the mirror x → −x, the spin reversed";
  out.form = "F' = M·F, T' = −M·T in every frame";
  const Change mirror{.turn = Vec3(-1, 1, 1).asDiagonal()};
  compare(mirror, setting, 1e-4, "positions are rounded: a voxel may lose 1/65535 one frame earlier", out);
}

void moved_case(const Setting& setting, Report& out) {
  out.title = "Translated and rotated scene";
  out.scene = "the same scene, with its lattice, translated by (13.7, −41.3, 8.9) mm and rotated by 90° about z";
  out.form = "F' = R·F, T' = R·T in every frame";
  Change change;
  change.turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  change.shift = {13.7, -41.3, 8.9};
  compare(change, setting, 1e-4, "positions are rounded: a voxel may lose 1/65535 one frame earlier", out);
}

void rotated_case(const Setting& setting, Report& out) {
  out.title = "Scene rotated against the lattice";
  out.scene =
      "cannulated convex head (R 12, a 5, r₀ 1 mm) in full contact in uniform bone, fed along a lattice axis and along "
      "axes rotated by 15, 30 and 40°; means over two voxels of feed";
  out.form = "F' = R·F, T' = R·T";
  constexpr int kFrames = 100;
  const Tool tool = make_tool(convex_profile(*kHead.radius_mm, kHead.outer_mm, kHead.bore_mm, 14, 0.05));
  const auto loads = [&](const Quat& turned, const Vec3& offset) {
    const Vec3 axis = turned * Vec3(0, 0, 1);
    // Deep enough for full contact.
    const double begin = 8, end = begin + 2 * kInvariantVoxel_mm;
    const Motion motion =
        path(kHead.feed_mm_s * kFrames / (2 * kInvariantVoxel_mm), offset + 5 * axis,
             {{offset - begin * axis, 130, 250, turned}, {offset - end * axis, kFrames, 250, turned}});
    const Reamed reamed = ream(scene_of(block({34, 34, 14}, kInvariantVoxel_mm, kDensity), tool, motion), setting);
    return mean_loads(reamed.after(130));
  };
  const MeanLoads plain = loads(Quat::Identity(), {0.03, 0.05, 0});
  for (const double degrees : {15.0, 30.0, 40.0}) {
    const Quat turned = oblique(degrees);
    const MeanLoads other = loads(turned, {0.07, -0.04, 0});
    const std::string at = ", " + std::to_string(static_cast<int>(degrees)) + "°";
    const std::string reason = "the rim meets the lattice differently; limit of a steady plunge";
    out.absolute("force" + at, "", 0, (other.force_n - turned * plain.force_n).norm() / plain.force_n.norm(), 5e-3,
                 reason);
    out.absolute("torque" + at, "", 0, (other.torque_nmm - turned * plain.torque_nmm).norm() / plain.torque_nmm.norm(),
                 5e-3, reason);
  }
}

}  // namespace reamsim::verify
