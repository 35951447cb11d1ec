// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim/anatomy/run_metrics.h"
#include "sim/base/stopwatch.h"
#include "sim/record/recorder.h"
#include "sim/scene/clearance.h"
#include "sim/scene/scene.h"

namespace reamsim {

struct InputSum {
  std::string role;
  std::string path;
  std::string sha256;

  static auto fields(auto& self) { return std::tie(self.role, self.path, self.sha256); }
};

/// Checksums of every input of the scenario, the scenario file first. Throws InputError when one cannot be read.
std::vector<InputSum> input_sums(const Scenario& scenario);

struct RunFacts {
  std::string device;
  std::size_t device_bytes = 0;
  double bone_before_mm3 = 0;
  double load_s = 0;
  double simulate_s = 0;
  double checkpoints_s = 0;  ///< within and after simulate_s
  double measure_s = 0;
  double write_s = 0;
  double render_s = 0;
  Stopwatch since_start;
  std::string render_context;  ///< what rendered the pictures; empty without pictures
  std::vector<InputSum> inputs;
  std::vector<std::string> warnings;
  std::optional<HolderClearance> clearance;
  BoneMetrics metrics;
  ColumnMap depth_map;
};

/// Writes the tools of all passes into `dir` (tool_path()). Throws RunError.
void write_tools(const std::string& dir, const SimulationInput& scene);

/// Writes scenario.yaml, resolved, with checksums and the first contact of a plunge in its head. Throws RunError.
void write_scenario(const std::string& dir, const SimulationInput& scene, const RunFacts& facts);

/// Whether the scenario.yaml in `dir` is that of this scenario, with the same inputs. Throws InputError.
bool is_result_of(const std::string& dir, const Scenario& scenario);

/// Writes reamed.vdb, reamed.vti, reamed.seg.nrrd, depth_map.csv and planning.mrk.json into `dir`. Throws RunError
/// when the disk is full.
void write_results(const std::string& dir, const SimulationInput& scene, const Recorder& recorder,
                   const RunFacts& facts);

/// The markups of a run for 3D Slicer, in LPS, mm (its schema 1.0.3): the plane of the face before and after reaming,
/// the axis of the reamer, entry and deepest point, pegs, landmarks and rim, as far as the run has them. `deepest`: the
/// pose of the tool at the greatest depth, in B.
std::string planning_markups(const SimulationInput& scene, const BoneMetrics& metrics, const ToolPose& deepest);

/// The object `metrics` of summary.json; missing values are null.
nlohmann::ordered_json metrics_json(const BoneMetrics& metrics);
/// Its object `clearance`.
nlohmann::ordered_json clearance_json(const HolderClearance& clearance, const SimulationInput& scene);

/// Writes depth_map.csv: a row for each column that meets bone. Throws RunError when it cannot be written.
void write_depth_map(const std::string& path, const ColumnMap& map);

/// Writes clearance.csv. Throws RunError when the disk is full.
void write_clearance(const std::string& path, const HolderClearance& clearance, double frame_s);

/// Writes density × fill (g/cm³, float32) at the voxel centres as a VTK ImageData file, zlib-compressed, for readers
/// without OpenVDB (ParaView, PyVista). Throws RunError.
void write_vti(const std::string& path, const BoneView& bone);

/// Writes a segmentation for 3D Slicer, which reads no VTI: an NRRD of labels in LPS, 1 where more than half of a voxel
/// remains, 2 where it did before the run, else 0. Throws RunError.
void write_segmentation(const std::string& path, const BoneView& bone);

/// Writes summary.json into `dir`. `finished` false: of the frames so far, without metrics and times.
void write_summary(const std::string& dir, const SimulationInput& scene, const RunTotals& totals, const RunFacts& facts,
                   bool finished = true);

/// The summary.json of the run in `dir` with the forces of other constants. Throws InputError where it is damaged.
std::string reforced_summary(const std::string& dir, const CuttingSettings& cutting, const RunTotals& totals);

}  // namespace reamsim
