// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/record/manifest.h"
#include "sim/study/study.h"

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
  /// The names of the folders of runs, whatever plan they belong to, in order; not those of unfinished runs.
  [[nodiscard]] std::vector<std::string> run_names() const;
  /// The message of a run that failed; "" where it did not.
  [[nodiscard]] std::string failure(const std::string& id) const;
  /// Notes that a run failed. Throws RunError.
  void note_failure(const std::string& id, const std::string& message) const;
  /// Removes that note, for a run that begins.
  void forget_failure(const std::string& id) const;
  /// Waits until all results are on the disk. Throws RunError.
  void sync() const;

 private:
  StudyFolder(std::string dir, const KeptFiles& keep) : dir_(std::move(dir)), keep_(keep) {}
  void mark(const Study& study) const;

  std::string dir_;
  KeptFiles keep_;
};

}  // namespace reamsim
