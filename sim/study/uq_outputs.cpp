// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/uq_outputs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "sim/base/csv.h"
#include "sim/record/force_log.h"
#include "sim/study/sensitivity.h"
#include "sim/study/summary_numbers.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostIntervals = 400;
constexpr std::size_t kForceOutputs = 3;
const std::vector<std::string> kForceNames{"peak_axial_force_n", "peak_spin_torque_nmm", "energy_mj"};

/// A row of forces.csv.
struct LoggedFrame {
  std::int64_t frame = 0;
  double time_s = 0;
  Vec3 tool_z = Vec3::UnitZ();  ///< axis of the tool, B
  double axial_force_n = 0;
  double spin_torque_nmm = 0;
  double energy_mj = 0;
};

std::vector<LoggedFrame> read_frames(const std::string& dir) {
  const std::vector<std::string_view> columns = csv_cells(kForceColumns);
  CsvReader log(dir + "/forces.csv", columns, "the log of a run");
  std::vector<LoggedFrame> out;
  std::vector<double> row;
  while (log.next(row)) {
    const FrameResult result = result_of(row, log.where());
    out.push_back({result.frame, result.time_s, result.pose.orientation * Vec3::UnitZ(), result.axial_force_n,
                   result.spin_torque_nmm, result.energy_mj});
  }
  return out;
}

/// Equal intervals of time, from 0 to the end of the longest run; none is shorter than a frame of that run.
struct Intervals {
  double length_s = 1;
  std::size_t count = 1;

  explicit Intervals(const std::vector<std::string>& run_dirs) {
    double last_s = 0;
    std::size_t frames = 1;
    for (const std::string& dir : run_dirs) {
      const auto frames_of_run = read_frames(dir);
      if (frames_of_run.empty() || frames_of_run.back().time_s <= last_s) continue;
      last_s = frames_of_run.back().time_s;
      frames = frames_of_run.size() - 1;
    }
    count = std::clamp<std::size_t>(frames, 1, kMostIntervals);
    if (last_s > 0) length_s = last_s / static_cast<double>(count);
  }
  /// The interval (begin, end] of a time.
  [[nodiscard]] std::size_t of(double time_s) const {
    const double at = std::ceil(time_s / length_s - 1e-6) - 1;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  }
};

/// The numbers that differ between runs; a run that lacks one has NaN.
class RunNumbers {
 public:
  explicit RunNumbers(const std::vector<std::string>& dirs) {
    std::map<std::string, std::vector<double>> all;
    std::vector<std::string> order;
    for (std::size_t run = 0; run < dirs.size(); ++run) {
      for (const auto& [name, value] : summary_numbers(dirs[run])) {
        if (depends_on_law(name)) continue;
        auto [at, fresh] = all.try_emplace(name, dirs.size(), std::nan(""));
        if (fresh) order.push_back(name);
        at->second[run] = value;
      }
    }
    for (const std::string& name : order) {
      const std::vector<double>& values = all[name];
      const bool complete = std::ranges::none_of(values, [](double value) { return std::isnan(value); });
      if (complete && std::ranges::any_of(values, [&](double value) { return value != values[0]; })) {
        names_.push_back(name);
        values_.push_back(values);
      }
    }
  }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] double value(std::size_t number, std::size_t run) const { return values_[number][run]; }

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;
};

/// One run, evaluated for constants.
class EvaluatedRun {
 public:
  EvaluatedRun(const std::string& dir, bool by_basis) : frames_(read_frames(dir)) {
    if (by_basis) run_ = open_basis_run(dir);
  }

  /// Peaks of axial force and spin torque, and the cutting energy. `history`, where it is given, gets the means over
  /// the intervals. Without the basis there are no constants.
  std::array<double, kForceOutputs> outputs(const std::vector<std::string>& constants, const Intervals& intervals,
                                            ForceHistory* history) const {
    std::array<double, kForceOutputs> out{};
    std::vector<int> counts(intervals.count);
    if (history != nullptr) {
      *history = {std::vector<double>(intervals.count), std::vector<double>(intervals.count)};
    }
    for (const LoggedFrame& frame : run_ ? frames_for(constants) : frames_) {
      out[0] = std::max(out[0], frame.axial_force_n);
      out[1] = std::max(out[1], std::abs(frame.spin_torque_nmm));
      out[2] += frame.energy_mj;
      if (history == nullptr) continue;
      const std::size_t at = intervals.of(frame.time_s);
      ++counts[at];
      history->axial_force_n[at] += (frame.axial_force_n - history->axial_force_n[at]) / counts[at];
      history->spin_torque_nmm[at] += (frame.spin_torque_nmm - history->spin_torque_nmm[at]) / counts[at];
    }
    if (history != nullptr) fill_gaps(counts, intervals, *history);
    return out;
  }

 private:
  /// With the forces of other constants.
  [[nodiscard]] std::vector<LoggedFrame> frames_for(const std::vector<std::string>& constants) const {
    const LawSettings law = changed_law(*run_, constants);
    const ForceConstants values = force_constants(law.cutting, recalibration(*run_, law));
    std::vector<LoggedFrame> out = frames_;
    for (LoggedFrame& frame : out) {
      const FrameForces forces = run_->basis.forces(frame.frame, values);
      frame.axial_force_n = forces.force_n.dot(frame.tool_z);
      frame.spin_torque_nmm = forces.torque_nmm.dot(frame.tool_z);
      frame.energy_mj = forces.energy_mj;
    }
    return out;
  }

  /// An interval without a frame has the force of the one before.
  void fill_gaps(const std::vector<int>& counts, const Intervals& intervals, ForceHistory& history) const {
    const double last_s = frames_.empty() ? 0 : frames_.back().time_s;
    for (std::size_t i = 1; i <= intervals.of(last_s); ++i) {
      if (counts[i] > 0) continue;
      history.axial_force_n[i] = history.axial_force_n[i - 1];
      history.spin_torque_nmm[i] = history.spin_torque_nmm[i - 1];
    }
  }

  std::optional<BasisRun> run_;
  std::vector<LoggedFrame> frames_;
};

std::vector<double> key_of(const Eigen::VectorXd& point) {
  return {point.begin(), point.end()};
}

/// Means of every output where an input is in its lowest and highest fifth.
void add_ends(const UqDesign& design, UqResults& out) {
  constexpr double kPart = 0.2;
  Eigen::MatrixXd inputs(design.a().rows() + design.b().rows(), design.a().cols());
  inputs << design.a(), design.b();
  const auto mean = [&](Eigen::Index output, Eigen::Index input, bool high) {
    double sum = 0;
    int count = 0;
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      if (high ? inputs(i, input) <= 1 - kPart : inputs(i, input) >= kPart) continue;
      sum += out.samples(i, output);
      ++count;
    }
    return count > 0 ? sum / count : std::nan("");
  };
  for (Eigen::Index output = 0; output < out.samples.cols(); ++output) {
    out.low.emplace_back(inputs.cols());
    out.high.emplace_back(inputs.cols());
    for (Eigen::Index input = 0; input < inputs.cols(); ++input) {
      out.low.back()[input] = mean(output, input, false);
      out.high.back()[input] = mean(output, input, true);
    }
  }
}

}  // namespace

bool depends_on_law(const std::string& name) {
  static constexpr std::string_view kSections[] = {"headline.", "forces.", "force_law.", "passes."};
  static constexpr std::string_view kNumbers[] = {"work_mj", "energy_mj", "floor_energy_mj", "friction_energy_mj",
                                                  "balance"};
  return std::ranges::any_of(kSections, [&](std::string_view section) { return name.starts_with(section); }) ||
         std::ranges::find(kNumbers, name) != std::end(kNumbers);
}

UqResults evaluate_uq(const UqDesign& design, const std::vector<std::string>& run_dirs) {
  const RunNumbers numbers(run_dirs);
  UqResults out;
  for (const UncertainInput& input : design.inputs()) out.inputs.push_back(input.name);
  out.outputs = kForceNames;
  out.outputs.insert(out.outputs.end(), numbers.names().begin(), numbers.names().end());
  const Intervals intervals(run_dirs);
  for (std::size_t i = 1; i <= intervals.count; ++i) out.time_s.push_back(intervals.length_s * static_cast<double>(i));

  // Run by run, so that one basis at a time is in memory.
  const std::vector<Eigen::VectorXd> points = design.points();
  const auto independent = static_cast<std::size_t>(design.a().rows() + design.b().rows());
  std::vector<std::vector<std::size_t>> points_of(run_dirs.size());
  for (std::size_t i = 0; i < points.size(); ++i) points_of[design.run_of(points[i])].push_back(i);
  std::map<std::vector<double>, Eigen::VectorXd> evaluated;
  out.samples.resize(static_cast<Eigen::Index>(independent), static_cast<Eigen::Index>(out.outputs.size()));
  out.histories.resize(independent);
  for (std::size_t run = 0; run < run_dirs.size(); ++run) {
    const EvaluatedRun simulated(run_dirs[run], design.needs_basis());
    for (const std::size_t i : points_of[run]) {
      ForceHistory* history = i < independent ? &out.histories[i] : nullptr;
      const auto forces = simulated.outputs(design.constants(points[i]), intervals, history);
      Eigen::VectorXd values(static_cast<Eigen::Index>(out.outputs.size()));
      for (std::size_t k = 0; k < kForceOutputs; ++k) values[static_cast<Eigen::Index>(k)] = forces[k];
      for (std::size_t k = 0; k < numbers.names().size(); ++k) {
        values[static_cast<Eigen::Index>(kForceOutputs + k)] = numbers.value(k, run);
      }
      if (i < independent) out.samples.row(static_cast<Eigen::Index>(i)) = values.transpose();
      evaluated[key_of(points[i])] = std::move(values);
    }
  }
  const auto indices =
      sobol_indices(design.a(), design.b(), [&](const Eigen::VectorXd& point) { return evaluated.at(key_of(point)); });
  for (const SobolIndices& of_output : indices) {
    const auto vector_of = [](const std::vector<double>& values) {
      return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
    };
    out.first.push_back(vector_of(of_output.first));
    out.total.push_back(vector_of(of_output.total));
    out.first_error.push_back(vector_of(of_output.first_error));
    out.total_error.push_back(vector_of(of_output.total_error));
    out.dominant.push_back(dominant_inputs(of_output, out.inputs));
  }
  add_ends(design, out);
  return out;
}

}  // namespace reamsim
