// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/bench/program.h"

namespace reamsim::bench {

/// Median with its spread over all poses and repetitions, in the unit of the owner.
struct Spread {
  double median = 0;
  double min = 0;
  double max = 0;
  int samples = 0;
};
Spread spread_of(std::vector<double> values);

/// Program, sizes and case of a measurement. `voxmap` and `shell`: cells along an edge. `implicit` has no shell; its
/// rows have the largest.
struct Place {
  Label who;
  int voxmap = 0;
  int shell = 0;
  std::string contact;  ///< severe | light | none | plunge
};

/// A case's frames, each enqueued alone (plunge: in the batches that the program uses by default).
struct CaseRow {
  Place at;
  std::optional<double> contacts = {};  ///< touching points, mean over the poses; plunge and implicit: voxels per frame
  Spread ms = {};                       ///< whole frame, host wall time
  double kernel_ms = 0;                 ///< median, device time
  std::optional<double> ratio_to_direct = {};  ///< published direct's median over this one
};

/// A measurement that was skipped, and why.
struct Skipped {
  Place at;
  std::string reason;
};

struct MemoryRow {
  std::string engine;
  int voxmap = 0, shell = 0;
  double voxmap_mb = 0, shell_mb = 0;  ///< 10⁶ bytes
};

/// Medians over the frames of a severe case, µs, as in the paper's Table 2. `read`: the rest of the total: launches,
/// waiting and reading of results.
struct PhaseRow {
  Place at;
  double obb = 0, voi = 0, upload = 0, kernel = 0, read = 0, total = 0;
};

/// A depth at which the VOI is `fraction` of the tool's box.
struct VoiRow {
  Label who;
  double fraction = 0;
  double contacts = 0;  ///< points
  Spread with_ms, without_ms;
};

/// Frames enqueued `batch` at a time; time per frame.
struct BatchRow {
  Place at;
  int batch = 1;
  Spread ms = {};
};

/// Variation of a racing program's results over repetitions of a severe frame.
struct ScatterRow {
  Place at;
  int repetitions = 0;
  double points = 0;                  ///< touching points: the count if every point found its voxel unchanged
  std::optional<double> voxels = {};  ///< their voxels: the count if only the first point of a voxel did
  Spread contacts = {};               ///< counted
  double force_spread = 0;            ///< standard deviation of the force's magnitude over its mean
  double component_spread = 0;        ///< largest standard deviation of a component over the mean magnitude
  double contacts_spread = 0;         ///< standard deviation over mean
};

/// More of the plunged sphere with `exact`.
struct ExactFrames {
  double kernel_ms = 0;  ///< of a frame, median
  double voxels = 0;     ///< that lose bone in a frame, mean
  std::optional<Spread> one_core_ms =
      {};  ///< on one compute unit of a processor with several, if its driver can divide it
  std::optional<double> one_core_kernel_ms = {};
};

/// The plunged sphere of a verification: time per frame at 0.2 mm/s and 1 kHz, and the volume's error. `exact`: whole
/// frames with the rows of forces.csv, by window of 64; others: from the pose to the sums, by depth.
struct SphereRow {
  std::string engine;
  ErosionMode erosion = {};
  double voxel_mm = 0;
  Spread ms = {};
  double removed_mm3 = 0;
  double volume_error = 0;  ///< removed over the cap's volume, less 1
  std::optional<ExactFrames> exact = {};

  /// Simulated over wall time at 1 kHz.
  [[nodiscard]] double times_real_time() const { return 1 / ms.median; }
};

/// What a device does at most: 10⁹ operations a second in single precision, a fused multiply-add as two; 10⁹ bytes a
/// second, read and written.
struct MachinePeaks {
  double gops = 0;
  double gb_s = 0;
};

/// Touching points at a pose, with the largest voxmap and shell.
struct PoseCount {
  std::string contact;
  int pose = 0;
  std::int64_t points = 0;
  double wanted = 0;
};

struct Findings {
  std::string device;
  std::string driver;
  unsigned compute_units = 0;
  int repetitions = 0;
  std::vector<std::pair<int, std::size_t>> shell_points;  ///< (cells along an edge, points)
  std::vector<PoseCount> poses;
  std::vector<CaseRow> cases;
  std::vector<Skipped> skipped;
  std::vector<MemoryRow> memory;
  std::vector<PhaseRow> phases;
  std::vector<VoiRow> voi;
  std::vector<BatchRow> batches;
  std::vector<ScatterRow> scatter;
  std::vector<SphereRow> spheres;
  std::optional<MachinePeaks> peaks;
  double seconds = 0;

  /// The row of a case, or nullptr.
  [[nodiscard]] const CaseRow* find(const Label& who, int voxmap, int shell, const std::string& contact) const;
};

/// The findings as text tables, with the paper's figures.
std::string text_of(const Findings& findings);
/// The findings as JSON (docs/columns.md).
std::string json_of(const Findings& findings);

}  // namespace reamsim::bench
