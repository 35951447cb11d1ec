// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/bench/program.h"
#include "sim/run/simulation.h"

namespace reamsim::bench {

/// Median with its spread over all poses and repetitions, in the unit of the owner.
struct Spread {
  double median = 0;
  double min = 0;
  double max = 0;
  int samples = 0;
};
Spread spread_of(const std::vector<double>& values);

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

/// Operations of exact erosion for a voxel that loses bone in a frame of a window, a fused multiply-add as two: 36 for
/// its loss (rs_window_outside() with two pieces and rs_clip_loss()) and 32 for force, torque and energies
/// (kernels/cut_window.h).
inline constexpr double kExactOperations = 68;
/// Memory that it needs, bytes: fill read and written, and grade read, once in a window of 64 frames.
inline constexpr double kExactBytes = 5.0 / 64;

/// Rows as the benchmark's JSON has them (docs/columns.md).
using Json = nlohmann::ordered_json;
/// The keys of a place.
Json row_at(const Place& at);
/// The keys median_ms, min_ms and max_ms.
Json spread_ms(const Spread& ms);

struct Findings {
  std::string device;
  std::string driver;
  unsigned compute_units = 0;
  int repetitions = 0;
  std::vector<std::pair<int, std::size_t>> shell_points;  ///< (cells along an edge, points)
  Json poses = Json::array();  ///< touching points at each pose, with the largest voxmap and shell
  std::vector<CaseRow> cases;
  std::vector<Skipped> skipped;
  Json memory = Json::array();  ///< 10⁶ bytes
  /// Medians over the frames of a severe case, as in the paper's Table 2. `read_us`: the rest of the total: launches,
  /// waiting and reading of results.
  Json phases = Json::array();
  Json voi = Json::array();      ///< by depths at which the VOI is `fraction` of the tool's box
  Json batches = Json::array();  ///< frames enqueued `batch` at a time; time per frame
  /// Variation of a racing program's results over repetitions of a severe frame. `points` touch: the count if every
  /// point found its voxel unchanged; `voxels`: if only the first point of a voxel did. Spreads are standard deviations
  /// over means; `component_spread`: the largest of a force's component over the mean magnitude.
  Json scatter = Json::array();
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

/// Sizes of voxmap and shell, cells along an edge.
struct SizePair {
  int voxmap = 0;
  int shell = 0;
};

/// What to measure.
struct Plan {
  std::string device = "auto";
  std::vector<std::string> engines;
  std::vector<SizePair> sizes;  ///< by ascending voxmap; the last pair gets every part below
  int sampled = 256;            ///< voxels an edge at which the phantom is sampled
  int repetitions = 5;          ///< of each pose, after a warm-up
  bool verify_poses = true;     ///< an error where contacts of the last pair differ by more than 5 %
  bool light = true;            ///< the case `light`, wherever the shell is the last pair's
  bool details = true;          ///< VOI curve, batches, plunge, scatter
  int plunge_frames = 1000;
  std::vector<double> sphere_voxels_mm{0.25, 0.1, 0.04};  ///< of the plunged sphere
};

/// All engines: `exact`, then those of `remove`, fastest first.
const std::vector<std::string>& engine_names();
/// All of the paper's tables; eleven minutes on two cores.
Plan full_plan();
/// `severe` and `none` at 256³ and 1024³ for `exact`, `bricked` and `direct`; a minute.
Plan quick_plan();

/// The plunged sphere with `erosion: exact` alone; half a minute.
Plan sphere_plan();

/// Progress, and the request to stop.
struct BenchControl {
  /// Called at the beginning of a step, with the fraction of the usual time that lies behind.
  std::function<void(double, const std::string&)> part = [](double, const std::string&) {};
  std::function<bool()> stop = [] { return false; };
};

/// Throws InputError where the plan names an engine or a device that does not exist, RunError where there is no OpenCL.
void check_plan(const Plan& plan);
/// Runs the plan. Throws InputError (no such engine or device), RunError (no OpenCL; wrong number of touching points),
/// Interrupted. Programs that the device cannot hold are in Findings::skipped.
Findings run_bench(const Plan& plan, const BenchControl& control);

/// Depths of the approaches for a voxmap and a shell, as text for scene.cpp.
std::string find_depths(int voxmap, int shell);

/// The first frames in contact are left out: caches and clocks of the processor are not as they will be.
inline constexpr std::size_t kWarmUpFrames = 20;

/// Wall time of a frame alone: pose in, force out, nothing batched and no windows, as a haptic device needs it.
struct Latency {
  std::int64_t frames = 0;  ///< in contact, that were timed
  double median_ms = 0;
  double p99_ms = 0;
  double p999_ms = 0;
  double most_ms = 0;
};

/// Moves the tool of the scene along its motion frame by frame, and times those in contact but the first 20, in which
/// memory of the device grows. Ends after `most` of them. Throws Interrupted, RunError.
Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop);

}  // namespace reamsim::bench
