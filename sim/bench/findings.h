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

/// What was measured where. `voxmap` and `shell`: cells along an edge. `implicit` has no shell; its rows stand where
/// the largest shell does.
struct Place {
  Label who;
  int voxmap = 0;
  int shell = 0;
  std::string contact;  ///< severe | light | none | plunge
};

/// A case's frames, each enqueued alone (plunge: in the batches that the program uses by default).
struct CaseRow {
  Place at;
  std::optional<double> contacts = {};  ///< points that touch, mean over the poses; plunge and implicit: voxels a frame
  Spread ms = {};                       ///< whole frame, host wall time
  double kernel_ms = 0;                 ///< median, device time
  std::optional<double> ratio_to_direct = {};  ///< published direct's median over this one
};

/// What could not be measured, and why.
struct Skipped {
  Place at;
  std::string reason;
};

struct MemoryRow {
  std::string engine;
  int voxmap = 0, shell = 0;
  double voxmap_mb = 0, shell_mb = 0;  ///< 10⁶ bytes
};

/// Medians over a severe case's frames, µs, as in the paper's Table 2. `read`: what the other phases leave of the
/// whole: launches, waiting and the results' way back.
struct PhaseRow {
  Place at;
  double obb = 0, voi = 0, upload = 0, kernel = 0, read = 0, total = 0;
};

/// A depth at which the VOI takes `fraction` of the tool's box.
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

/// How much a racing program's results differ from one repetition of a severe frame to the next.
struct ScatterRow {
  Place at;
  int repetitions = 0;
  double points = 0;                  ///< that touch: what it would count if every point found its voxel still there
  std::optional<double> voxels = {};  ///< that they lie in: what it would count if only the first point did
  Spread contacts = {};               ///< that it counted
  double force_spread = 0;            ///< standard deviation of the force's magnitude over its mean
  double component_spread = 0;        ///< largest standard deviation of a component over the mean magnitude
  double contacts_spread = 0;         ///< standard deviation over mean
};

/// The plunged sphere of a verification: time per frame at 0.2 mm/s and 1 kHz, and the volume's error.
struct SphereRow {
  std::string engine;
  ErosionMode erosion = {};
  double voxel_mm = 0;
  Spread ms = {};
  double removed_mm3 = 0;
  double volume_error = 0;  ///< removed over the cap's volume, less 1
};

/// Points that touch at a pose at the largest voxmap and shell.
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
  double seconds = 0;

  /// The row of a case, or nullptr.
  [[nodiscard]] const CaseRow* find(const Label& who, int voxmap, int shell, const std::string& contact) const;
};

/// The findings as text tables with the paper's figures beside them.
std::string text_of(const Findings& findings);
/// As JSON; docs/formats.md describes it.
std::string json_of(const Findings& findings);

}  // namespace reamsim::bench
