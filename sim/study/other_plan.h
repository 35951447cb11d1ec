// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/identify.h"
#include "sim/study/study_folder.h"

namespace reamsim {

/// Finished runs in the folder of a study that are none of this plan.
struct OtherRuns {
  int count = 0;
  std::vector<std::string> differences;  ///< "bone.voxel_mm is 1 there and 0.5 in this plan", at most three
};

/// Finds them, and compares one with the run of the plan that is most like it. Of what identifies
/// a run, version, contents of input files, and the sections output and render are not compared.
OtherRuns find_other_runs(const Study& study, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                          const StudyFolder& folder);

/// A line for the user; "" where there are none.
std::string sentence_of(const OtherRuns& others, const std::string& dir);

}  // namespace reamsim
