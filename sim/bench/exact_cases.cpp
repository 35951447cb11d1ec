// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "sim/bench/measure.h"
#include "sim/bench/whole_frames.h"

namespace reamsim::bench {

namespace {

constexpr int kWindowsOfCase = 3;     // the first of them untimed
constexpr int kWindowsOfPlunge = 16;  // 1024 frames
constexpr double kCaseFeedMmS = 1;    // as the other engines' substeps (poses.h)

CaseRow row_of(const Place& at, const WholeFrames& frames) {
  CaseRow row{.at = at};
  row.contacts = frames.voxels;
  row.ms = spread_of(frames.ms);
  row.kernel_ms = spread_of(frames.kernel_ms).median;
  return row;
}

/// The motions of a case: to the depth of each approach; `plunge`: as measure_plunge().
std::vector<Motion> motions_of(const std::string& contact, double voxel_mm) {
  std::vector<Motion> out;
  if (contact == "plunge") {
    const double step_mm = 0.25 * voxel_mm, rate_hz = 1000;
    const double depth_mm = kApproaches[0].depth_mm[1] + step_mm * 64 * kWindowsOfPlunge;
    return {straight_motion(pose_at(kApproaches[0], depth_mm), step_mm * rate_hz, kWindowsOfPlunge)};
  }
  for (const Contact each : kContacts) {
    if (contact != name_of(each)) continue;
    for (const Approach& approach : kApproaches) {
      const double depth_mm = approach.depth_mm[static_cast<std::size_t>(each)];
      out.push_back(straight_motion(pose_at(approach, depth_mm), kCaseFeedMmS, kWindowsOfCase));
    }
  }
  return out;
}

}  // namespace

void measure_exact_case(const Plan& plan, const BenchSetup& setup, const SizePair& size, const std::string& contact,
                        const BenchControl& control, Findings& findings) {
  if (std::ranges::count(plan.engines, "exact") == 0) return;
  const Place at{{"exact", "deterministic"}, size.voxmap, size.shell, contact};
  const ExactRuns runs{.bone = setup.voxmap,
                       .tool = setup.tool,
                       .motions = motions_of(contact, setup.voxmap->grid.voxel_mm),
                       .device = plan.device};
  measure_or_skip(at, findings.skipped, [&] {
    const WholeFrames frames = time_whole_frames(runs, control);
    CaseRow row = row_of(at, frames);
    const CaseRow* direct = findings.find({"direct", "published"}, size.voxmap, size.shell, contact);
    if (direct != nullptr && row.ms.median > 0) row.ratio_to_direct = direct->ms.median / row.ms.median;
    findings.cases.push_back(row);
    if (contact != name_of(Contact::severe)) return;
    findings.memory.push_back({"exact", size.voxmap, size.shell, static_cast<double>(frames.bytes.voxmap) / 1e6, 0});
  });
}

}  // namespace reamsim::bench
