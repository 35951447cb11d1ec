#include <algorithm>

#include "sim/base/error.h"
#include "sim/bench/measure.h"
#include "sim/bench/whole_frames.h"

namespace reamsim::bench {

namespace {

constexpr int kWindowsOfCase = 3;     // the first of them untimed
constexpr int kWindowsOfPlunge = 16;  // 1024 frames
constexpr double kCaseFeedMmS = 1;    // as the other engines' substeps (poses.h)

/// Adds the frames of one run to those of its case.
void append_frames(const WholeFrames& part, WholeFrames& to) {
  to.ms.insert(to.ms.end(), part.ms.begin(), part.ms.end());
  to.kernel_ms.insert(to.kernel_ms.end(), part.kernel_ms.begin(), part.kernel_ms.end());
  to.voxels += part.voxels;
  to.bytes = part.bytes;
}

CaseRow row_of(const Place& at, const WholeFrames& frames, double runs) {
  CaseRow row{.at = at};
  row.contacts = frames.voxels / runs;
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
  const std::vector<Motion> motions = motions_of(contact, setup.voxmap->grid.voxel_mm);
  WholeFrames all;
  try {
    for (const Motion& motion : motions) {
      const ExactRun run{.bone = setup.voxmap, .tool = setup.tool, .motion = motion, .device = plan.device};
      append_frames(time_whole_frames(run, control), all);
    }
  } catch (const RunError& error) {
    findings.skipped.push_back({at, error.what()});
    return;
  }
  CaseRow row = row_of(at, all, static_cast<double>(motions.size()));
  const CaseRow* direct = findings.find({"direct", "published"}, size.voxmap, size.shell, contact);
  if (direct != nullptr && row.ms.median > 0) row.ratio_to_direct = direct->ms.median / row.ms.median;
  findings.cases.push_back(row);
  if (contact != name_of(Contact::severe)) return;
  findings.memory.push_back({"exact", size.voxmap, size.shell, static_cast<double>(all.bytes.voxmap) / 1e6, 0});
}

}  // namespace reamsim::bench
