// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/text.h"
#include "sim/record/results.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The first figures of every summary: one force, one torque, one depth (docs/results.md, "Headline"). All outputs take
/// their names and texts from here.
struct KeyResults {
  bool means = false;  ///< force and torque are means over a voxel of travel; otherwise of single frames
  double peak_axial_force_n = 0;
  double peak_spin_torque_nmm = 0;  ///< magnitude
  double tool_depth_mm = 0;         ///< greatest travel along the tool's axis since first contact

  struct Figure {
    std::string name, number, unit;

    [[nodiscard]] std::string value() const { return number + " " + unit; }
  };
  [[nodiscard]] Figure force() const {
    return {means ? "peak mean axial force" : "peak axial force", fixed_text(peak_axial_force_n, 1), "N"};
  }
  [[nodiscard]] Figure torque() const {
    return {means ? "peak mean spin torque" : "peak spin torque", fixed_text(peak_spin_torque_nmm, 0), "N·mm"};
  }
  [[nodiscard]] Figure depth() const { return {"tool depth", fixed_text(tool_depth_mm, 2), "mm"}; }

  [[nodiscard]] std::string force_definition() const {
    return std::string(
               "maximum component of the force along the tool axis, and largest magnitude of the torque about it, ") +
           (means ? "of the means over one voxel of travel" : "of a single frame");
  }
  static constexpr const char* kDepthDefinition = "maximum travel of the tool along its axis since first contact";
};

/// The tool travel over which displayed forces are averaged, mm: a voxel where whole voxels are removed, otherwise 0.
inline double averaged_travel_mm(const CuttingSettings& cutting, double voxel_mm) {
  return cutting.erosion == ErosionMode::exact ? 0 : voxel_mm;
}

/// Running means of axial force and spin torque over the last voxel of the tool's travel, of at most a million frames.
/// Where voxels are removed whole, single frames are spikes; only a mean over one layer of voxels compares with a
/// measurement (docs/erosion.md).
class LayerMean {
 public:
  explicit LayerMean(double voxel_mm) : voxel_mm_(voxel_mm) {}

  struct Means {
    double axial_force_n = 0;
    double spin_torque_nmm = 0;
    std::size_t frames = 0;  ///< number of frames in the means
  };

  /// Adds a frame (position in B). Returns the means over the last voxel of travel, zero until there is one. While the
  /// tool stands still the number of frames stays constant.
  Means add(const Vec3& position_mm, double axial_force_n, double spin_torque_nmm);

 private:
  struct Frame {
    double path_mm;  ///< length of the path at its end
    double axial_force_n;
    double spin_torque_nmm;
  };

  void drop_oldest();

  double voxel_mm_;
  Vec3 last_mm_ = Vec3::Zero();
  std::deque<Frame> frames_;  ///< of the last voxel of travel
  double axial_force_sum_n_ = 0;
  double spin_torque_sum_nmm_ = 0;
  bool full_ = false;
};

/// What happens in a push (docs/columns.md, events.csv).
struct PushEvent {
  std::int64_t frame = 0;
  double time_s = 0;
  double depth_mm = 0;
  std::string event;  ///< contact, stall, breakthrough, end
  double value = 0;   ///< see docs/columns.md
};

/// Sums, extremes and events of a push, row by row.
class PushTotals {
 public:
  void add(const FrameResult& row);

  /// The time after a breakthrough over which its overshoot counts, s.
  static constexpr double kOvershoot_s = 0.2;

  /// The events so far; the last one is the end.
  [[nodiscard]] std::vector<PushEvent> events() const;
  double hand_mj = 0;
  double spindle_work_mj = 0;
  double peak_feed_mm_s = 0;  ///< in contact
  double peak_hand_power_w = 0;
  double peak_drill_power_w = 0;
  /// Mean feed from first contact on; 0 without contact.
  [[nodiscard]] double mean_feed_mm_s() const;
  /// Travel within kOvershoot_s after a breakthrough, the largest; nullopt without one.
  [[nodiscard]] std::optional<double> overshoot_mm() const;

 private:
  struct Breakthrough {
    PushEvent event;
    bool open = true;  ///< its overshoot may grow
  };

  void add_events(const FrameResult& row);

  std::vector<PushEvent> events_;  ///< besides breakthroughs and the end
  std::vector<Breakthrough> breakthroughs_;
  std::optional<FrameResult> first_contact_, last_;
  double still_s_ = 0;
  bool stalled_ = false;  ///< since it last moved
  bool held_ = false;     ///< by bone, since contact or the last breakthrough
  double mean_force_n_ = 0;
};

/// Writes DIR/events.csv. Throws RunError.
void write_push_events(const std::string& dir, const PushTotals& push);

/// Sums and extremes over one pass of a run, or all.
struct PassTotals {
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::int64_t first_contact_frame = -1;
  double removed_mm3 = 0;
  double energy_mj = 0;
  double max_depth_mm = 0;        ///< since first contact of the pass
  double peak_axial_force_n = 0;  ///< of single frames, like the magnitude of the torque
  double peak_spin_torque_nmm = 0;

  void add(const FrameResult& row);
};

/// Deflections of a tool on springs, T.
struct DeflectionTotals {
  double peak_mm = 0;               ///< length
  double peak_time_s = 0;           ///< first row with it
  double peak_lateral_mm = 0;       ///< of the part across the spin axis
  Vec3 at_depth_mm = Vec3::Zero();  ///< at deepest_pose
  Vec3 at_end_mm = Vec3::Zero();

  void add(const FrameResult& row, bool deepest);
};

/// Sums and extremes over a run, for summary.json.
class RunTotals : public PassTotals {
 public:
  /// `voxel_mm`: the travel of the layer means.
  explicit RunTotals(double voxel_mm) : layer_(voxel_mm) {}

  std::int64_t frames = 0;          ///< rows, the first (frame 0) included
  std::int64_t contact_frames = 0;  ///< rows with contact
  std::int64_t last_contact_frame = -1;
  double simulated_s = 0;
  ToolPose deepest_pose;  ///< at the first row with the greatest depth of the last pass with contact
  std::vector<PassTotals> passes;
  double floor_energy_mj = 0;
  double balance = 0;
  double peak_layer_axial_force_n = 0;    ///< of the means over a voxel of travel
  double peak_layer_spin_torque_nmm = 0;  ///< likewise, of its magnitude
  double peak_force_n = 0;                ///< of single frames, like that below
  double peak_torque_nmm = 0;
  double peak_advance_mm = 0;                  ///< of the tool in the frame with peak_axial_force_n
  std::optional<PushTotals> push;              ///< of a tool that a hand pushes
  std::optional<DeflectionTotals> deflection;  ///< of a tool on springs
  FrameTimes times;

  void add(const FrameResult& row);
  /// Root mean square over the frames in contact; 0 without contact.
  [[nodiscard]] double rms_force_n() const { return root_mean(force_squares_); }
  [[nodiscard]] double rms_torque_nmm() const { return root_mean(torque_squares_); }

  /// Rows from the first to the last with contact, with all between: contact of one frame depends on rounding to
  /// voxels.
  [[nodiscard]] std::int64_t reaming_frames() const {
    return first_contact_frame < 0 ? 0 : last_contact_frame - first_contact_frame + 1;
  }
  /// Means over the reaming time; 0 without contact.
  struct Means {
    double force_n = 0;  ///< of the magnitude; likewise the torque
    double torque_nmm = 0;
    double axial_force_n = 0;
    double spin_torque_nmm = 0;
  };
  [[nodiscard]] Means means() const;
  [[nodiscard]] KeyResults headline(bool means) const;
  /// Work of the drive and feed on the bone, −Σ(T·ω + F·v)·Δt, from the energy balance.
  [[nodiscard]] double work_mj() const { return energy_mj * (1 + balance) - floor_energy_mj; }

 private:
  [[nodiscard]] double root_mean(double squares) const;

  double force_squares_ = 0;
  double torque_squares_ = 0;
  Means sums_;                            // rows without contact have no force, so these are sums over the reaming time
  Vec3 last_position_mm_ = Vec3::Zero();  // of the row before
  LayerMean layer_;
};

}  // namespace reamsim
