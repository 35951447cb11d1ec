// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A recorded path from the log of a tracker: the same motion as keyframes removes the same bone.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "sim/base/geometry.h"
#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

struct Key {
  double time_s;
  Vec3 position_mm;
  Quat orientation;
};

/// Down, dwell, tilted sideways, dwell, out.
const std::array<Key, 6> kKeys{{{0, {0, 0, 1}, Quat::Identity()},
                                {1, {0, 0, -1}, Quat::Identity()},
                                {1.2, {0, 0, -1}, Quat::Identity()},
                                {2.2, {3, 1, -1.5}, Quat(std::cos(0.04), 0, std::sin(0.04), 0)},
                                {2.4, {3, 1, -1.5}, Quat(std::cos(0.04), 0, std::sin(0.04), 0)},
                                {2.8, {3, 1, 3}, Quat(std::cos(0.04), 0, std::sin(0.04), 0)}}};

class RecordedPath : public CliTest {
 protected:
  static std::string scenario(const std::string& motion) {
    std::string yaml = with(kSmall, "[10, 10, 6]", "[60, 60, 8]");
    yaml = with(yaml, "  voxel_mm: 0.5\n", "  voxel_mm: 1\n");
    const std::size_t begin = yaml.find("  plunge:"), end = yaml.find("render:");
    return yaml.substr(0, begin) + motion + yaml.substr(end);
  }
  double removed(const std::string& motion) const {
    expect_done(run(scenario(motion), {"--overwrite"}));
    return number_after(read("out/summary.json"), "\"removed_mm3\": ");
  }
};

TEST_F(RecordedPath, ATumTrajectoryRemovesWhatTheKeyframesRemove) {
  std::string keyframes = "  keyframes:\n";
  for (const Key& key : kKeys) {
    keyframes +=
        fmt::format("    - {{time_s: {}, position_mm: [{}, {}, {}], quaternion: [{}, {}, {}, {}], spin_rpm: 250}}\n",
                    key.time_s, key.position_mm.x(), key.position_mm.y(), key.position_mm.z(), key.orientation.w(),
                    key.orientation.x(), key.orientation.y(), key.orientation.z());
  }
  const double typed_mm3 = removed(keyframes);
  EXPECT_GT(typed_mm3, 500);

  // An optical tracker: some 30 Hz with jitter, epoch time, metres, its own frame, a marker beside the tool.
  Rigid tracker_from_bone = Rigid::Identity(), tool_from_marker = Rigid::Identity();
  tracker_from_bone.linear() = Quat(0.5, 0.5, -0.5, 0.5).toRotationMatrix();
  tracker_from_bone.translation() = Vec3(120, -45, 900);
  tool_from_marker.translation() = Vec3(10, 20, 80);
  tool_from_marker.linear() = Quat(0.6, 0, 0.8, 0).toRotationMatrix();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(0.02, 0.045);
  std::string plain = "# timestamp tx ty tz qx qy qz qw\n", tracked = plain;
  std::size_t at = 0;
  for (double t = 0; at + 1 < kKeys.size(); t += step(random)) {
    while (at + 2 < kKeys.size() && t >= kKeys[at + 1].time_s) ++at;
    const Key &a = kKeys[at], &b = kKeys[at + 1];
    const double fraction = std::min((t - a.time_s) / (b.time_s - a.time_s), 1.0);
    Rigid bone_from_tool = Rigid::Identity();
    bone_from_tool.linear() = a.orientation.slerp(fraction, b.orientation).toRotationMatrix();
    bone_from_tool.translation() = a.position_mm + fraction * (b.position_mm - a.position_mm);
    const auto row = [&](const Rigid& pose) {
      const Quat q(pose.linear());
      const Vec3 p = pose.translation() / 1000;
      return fmt::format("{:.6f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", 1700000000.156 + t, p.x(), p.y(),
                         p.z(), q.x(), q.y(), q.z(), q.w());
    };
    plain += row(bone_from_tool);
    tracked += row(tracker_from_bone * bone_from_tool * tool_from_marker);
    if (fraction >= 1) break;
  }
  write("path.txt", plain);
  EXPECT_NEAR(removed("  csv: {path: path.txt, format: tum}\n"), typed_mm3, 1e-3 * typed_mm3);

  write("tracked.txt", tracked);
  const auto section = [](const Rigid& transform) {
    const Mat3 r = transform.linear();
    const Vec3 t = transform.translation();
    return fmt::format("{{translation_mm: [{}, {}, {}], rotation: [[{}, {}, {}], [{}, {}, {}], [{}, {}, {}]]}}", t.x(),
                       t.y(), t.z(), r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2));
  };
  const std::string described =
      "  csv:\n    path: tracked.txt\n    format: tum\n    max_gap_s: 0.05\n    bone_from_tracker: " +
      section(tracker_from_bone.inverse()) + "\n    marker_from_tool: " + section(tool_from_marker.inverse()) + "\n";
  EXPECT_NEAR(removed(described), typed_mm3, 1e-3 * typed_mm3);

  std::filesystem::remove_all(path("out"));
  expect_refused(run(scenario(described), {"--set", "motion.csv.max_gap_s=0.03"}), 2,
                 {"tracked.txt:", "no pose for 0.0", "motion.csv.max_gap_s"});
}

}  // namespace
}  // namespace reamsim::test
