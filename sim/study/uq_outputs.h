// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/reforce.h"
#include "sim/study/uq_design.h"

namespace reamsim {

/// Force and torque over time, as means over equal intervals.
struct ForceHistory {
  std::vector<double> axial_force_n;
  std::vector<double> spin_torque_nmm;
};

/// The results of an uncertainty analysis.
struct UqResults {
  std::vector<std::string> inputs;
  std::vector<std::string> outputs;
  Eigen::MatrixXd samples;                    ///< of the two independent samples: rows points, columns outputs
  std::vector<Eigen::VectorXd> first, total;  ///< Sobol indices by output, over the inputs
  std::vector<Eigen::VectorXd> first_error, total_error;  ///< half their 95 % intervals
  std::vector<std::string> dominant;                      ///< in words, by output
  std::vector<Eigen::VectorXd> low, high;  ///< means of an output in the lowest and highest fifth of each input
  std::vector<double> time_s;              ///< ends of the intervals of the histories
  std::vector<ForceHistory> histories;     ///< of the same points as `samples`
};

/// Whether a result of a study's table, such as "forces.peak_force_n", follows from the constants of the force law.
bool depends_on_law(const std::string& name);

/// Evaluates all points of a design. `run_dirs`: finished runs, in the order of the design, with a force basis where it
/// needs one. Outputs
/// are the peaks of axial force and spin torque and the cutting energy, for the constants of each point, and every
/// number of summary.json that differs between the runs and does not depend on the force law. Throws InputError.
UqResults evaluate_uq(const UqDesign& design, const std::vector<std::string>& run_dirs);

}  // namespace reamsim
