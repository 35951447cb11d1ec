// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/record/results.h"
#include "sim/study/force_model.h"
#include "sim/study/measured_forces.h"

namespace reamsim {

/// Which specific energy a fit looks for.
enum class FitModel {
  classes,  ///< one u for each class of density
  law,      ///< u₀ and p of u₀·(ρ/ρ_ref)^p
};

struct FitOptions {
  FitModel model = FitModel::law;
  /// FitModel::classes: densities between classes, ascending, g/cm³; none: classes are grades without a gap of more
  /// than kClassGap_g_cm3.
  std::vector<double> class_edges_g_cm3;
  bool fit_normal_ratio = true;  ///< false: k_n is that of the run
  double noise_floor = 0;        ///< least standard deviation of a channel's noise, relative to its RMS
};
inline constexpr double kClassGap_g_cm3 = 0.05;

/// The pose of a frame, and its time.
struct FrameTime {
  double time_s = 0;
  std::int64_t frame = 0;
  Vec3 tool_z = Vec3::UnitZ();  ///< B
};

/// A fitted constant.
struct FittedConstant {
  std::string name;
  double value = 0;
  double standard_error = 0;  ///< NaN: it was not fitted
  bool fitted = true;         ///< false: its value is that of the run
  bool at_bound = false;      ///< 0, because a negative value would fit better
};

/// The part of a measured column that the fit does not explain.
struct ChannelResidual {
  ForceChannel channel{};
  std::size_t samples = 0;
  double rms_measured = 0;
  double rms = 0;
  double r_squared = 0;  ///< fraction of the variance explained
};

/// A class of density.
struct DensityClass {
  double least_g_cm3 = 0, most_g_cm3 = 0;
  double mean_g_cm3 = 0;  ///< by removed volume
  double volume_mm3 = 0;
  std::vector<int> grades;
};

struct ForceFit {
  std::vector<FittedConstant> constants;
  Eigen::MatrixXd
      covariance;  ///< of the fitted ones that are not at a bound, in their order; σ² of the residuals included
  std::vector<DensityClass> classes;
  std::vector<ChannelResidual> residuals;
  std::vector<std::string> statements;  ///< on identifiability, in words
  std::vector<std::string> warnings;    ///< fit_warnings()
  ForceConstants force;                 ///< for ForceBasis::forces()

  /// Throws std::out_of_range.
  [[nodiscard]] const FittedConstant& of(const std::string& name) const;
};

/// The constants that best explain a measured history: least squares, weighted by the noise of each column, which is
/// estimated from the residuals. `frames`: of the run, ascending. Throws InputError where no measured time lies in the
/// run's contact, and where no positive constant explains what was measured.
ForceFit fit_forces(const ForceBasis& basis, const std::vector<FrameTime>& frames, const CuttingSettings& cutting,
                    const MeasuredForces& measured, const FitOptions& options);

/// The value of a channel in a frame.
double channel_value(ForceChannel channel, const Vec3& force, const Vec3& torque, const Vec3& tool_z);

}  // namespace reamsim
