// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/study/study_plan.h"

namespace reamsim {

/// What became of a run of a study.
enum class RunState { missing, interrupted, failed, done };

/// The folder of a study:
///
///     study.json       marks the folder, and names the study
///     runs/ID/         a finished run (run_id()); runs/ID.partial while it is simulated, or interrupted
///     failed/ID.json   why a run failed
///
/// Several processes may work on one study at a time; runs reserve their own folders.
class StudyFolder {
 public:
  /// Creates the folder where it does not exist. Throws InputError where it holds something that is no study.
  StudyFolder(const Study& study, const std::string& dir);
  /// An existing folder, which is only read. Throws InputError if it does not exist.
  static StudyFolder open(const Study& study, const std::string& dir);

  [[nodiscard]] const std::string& path() const { return dir_; }
  [[nodiscard]] std::string run_dir(const std::string& id) const { return dir_ + "/runs/" + id; }
  /// A run is done where it has all files that the study keeps.
  [[nodiscard]] RunState state(const std::string& id) const;
  /// The message of a run that failed; "" where it did not.
  [[nodiscard]] std::string failure(const std::string& id) const;
  void note_failure(const std::string& id, const std::string& message) const;
  void forget_failure(const std::string& id) const;
  /// Waits until all results are on the disk.
  void sync() const;

 private:
  StudyFolder(std::string dir, const KeptFiles& keep) : dir_(std::move(dir)), keep_(keep) {}
  void mark(const Study& study) const;

  std::string dir_;
  KeptFiles keep_;
};

/// SHA-256 of files by path, each computed once.
using Checksums = std::map<std::string, std::string>;

/// The name of a run's folder in a study: 16 hex digits of the SHA-256 of the version of the program and the resolved
/// scenario, in which the checksums of input files stand for their paths. The name of the scenario does not count; of
/// the output section only force_basis does, and the render section only where pictures are kept. Throws InputError
/// when an input cannot be read.
std::string run_id(const Scenario& scenario, const KeptFiles& keep, Checksums& checksums);

/// A line for the user where the folder has finished runs that are none of this plan; else "". Names at most three
/// differences from the most similar run of the plan: "bone.voxel_mm is 1 there and 0.5 in this plan".
std::string text_of_other_runs(const Study& study, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                               const StudyFolder& folder);

}  // namespace reamsim
