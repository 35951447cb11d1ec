// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/fit_forces.h"

#include <fmt/core.h>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/study/fit_problem.h"
#include "sim/study/fit_warnings.h"
#include "sim/study/minimize.h"
#include "sim/study/nonnegative_least_squares.h"

namespace reamsim {

namespace {

constexpr double kMillijoules = 1000;  // per J

/// Ranges of the searches in one dimension: those of the scenario keys.
constexpr double kMostNormalRatio = 10, kMostExponent = 5;

/// Without noise, weights would grow without limit.
constexpr double kLeastNoise = 1e-7;

/// A part whose square is smaller, relative to the whole, says nothing about its constant.
constexpr double kNegligible = 1e-8;

/// Logarithms of density that spread less (standard deviation, by removed volume) do not tell an exponent.
constexpr double kLeastSpread = 0.02;

/// A constant with a larger standard error is not determined: relative to its value, or of an exponent.
constexpr double kMostRelativeError = 0.5, kMostExponentError = 1;

/// Constants with a higher correlation are hard to tell apart.
constexpr double kHighCorrelation = 0.99;

std::vector<DensityClass> classes_of(const ForceBasis& basis, const FitOptions& options) {
  const std::array<double, 256> volume = basis.volume_mm3();
  std::vector<DensityClass> out;
  for (int grade = 1; grade < 256; ++grade) {
    const double mm3 = volume[static_cast<std::size_t>(grade)];
    if (!(mm3 > 0)) continue;
    const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    const auto& edges = options.class_edges_g_cm3;
    const auto class_at = [&](double at) { return std::ranges::upper_bound(edges, at) - edges.begin(); };
    const bool same = !out.empty() && (edges.empty() ? density - out.back().most_g_cm3 <= kClassGap_g_cm3
                                                     : class_at(density) == class_at(out.back().most_g_cm3));
    if (!same) out.push_back({.least_g_cm3 = density, .most_g_cm3 = density, .grades = {}});
    DensityClass& to = out.back();
    to.most_g_cm3 = density;
    to.mean_g_cm3 = (to.mean_g_cm3 * to.volume_mm3 + density * mm3) / (to.volume_mm3 + mm3);
    to.volume_mm3 += mm3;
    to.grades.push_back(grade);
  }
  return out;
}

/// Standard deviation of the logarithm of density, by removed volume.
double density_spread(const std::array<double, 256>& volume) {
  double sum = 0, first = 0, second = 0;
  for (std::size_t grade = 1; grade < volume.size(); ++grade) {
    const double log = std::log(static_cast<double>(grade));
    sum += volume[grade];
    first += volume[grade] * log;
    second += volume[grade] * log * log;
  }
  return sum > 0 ? std::sqrt(std::max(0.0, second / sum - first * first / (sum * sum))) : 0;
}

/// A fit: the shape of u over the units, and the searches.
class Fit {
 public:
  Fit(const ForceBasis& basis, const std::vector<FrameTime>& frames, const CuttingSettings& cutting,
      const MeasuredForces& measured, const FitOptions& options)
      : cutting_(cutting),
        options_(options),
        basis_(basis),
        measured_file_(measured.file),
        classes_(classes_of(basis, options)),
        problem_(basis, frames, measured, units()) {}

  ForceFit run() {
    choose_searches();
    ForceFit out = fit();
    if (fix_undetermined(out)) out = fit();
    require_energy(out);
    out.warnings = fit_warnings(out, cutting_.reference_density_g_cm3);
    add_statements(out);
    return out;
  }

 private:
  ForceFit fit() {
    problem_.weigh(nullptr, 0);
    search();
    for (int round = 0; round < 3; ++round) {
      const Eigen::VectorXd coefficients = coefficients_at();
      problem_.weigh(&coefficients, std::max(kLeastNoise, options_.noise_floor));
      search();
    }
    return result();
  }

  /// Fixes k_n and p where their errors show that the data do not tell them: they would only spoil the others. Returns
  /// whether it did.
  bool fix_undetermined(const ForceFit& fit) {
    const auto is_vague = [&](const char* name, double most) { return fit.of(name).standard_error > most; };
    const bool normal =
        fit_normal_ratio_ && (without_energy() || is_vague("k_n", kMostRelativeError * std::max(normal_ratio_, 0.1)));
    const bool exponent = fit_exponent_ && (without_energy() || is_vague("p", kMostExponentError));
    if (normal) {
      fit_normal_ratio_ = normal_matters_ = false;
      normal_ratio_ = cutting_.normal_ratio;
    }
    if (exponent) {
      fit_exponent_ = false;
      exponent_ = cutting_.density_exponent;
    }
    return normal || exponent;
  }

  /// Whether every specific energy is 0. Then nothing tells k_n and p.
  [[nodiscard]] bool without_energy() const {
    return linear_.head(is_law() ? 1 : static_cast<Eigen::Index>(problem_.units())).isZero(0);
  }

  /// Throws InputError where every coefficient is 0: such a fit says nothing but that the measured columns are wrong.
  void require_energy(const ForceFit& fit) const {
    if (!linear_.isZero(0)) return;
    const bool zeros = std::ranges::all_of(fit.residuals, [](const ChannelResidual& r) { return r.rms_measured == 0; });
    throw InputError({measured_file_, 0, 0}, "",
                     zeros ? "every measured value in the time of contact is 0"
                           : fit.constants[0].name + " is 0: a negative value would fit better",
                     zeros
                         ? "check the columns, and that time_s begins with the run"
                         : "check the sign of each column: axial_force_n is positive where the bone pushes the tool "
                           "out, spin_torque_nmm where it brakes a positive spin_rpm; reverse the sign of a load cell "
                           "that measures the force on the bone");
  }

  [[nodiscard]] bool is_law() const { return options_.model == FitModel::law; }

  std::vector<std::vector<int>> units() {
    std::vector<std::vector<int>> out;
    for (const DensityClass& c : classes_) {
      if (!is_law()) out.push_back(c.grades);
      for (const int grade : c.grades) {
        if (is_law()) out.push_back({grade});
        density_.push_back(DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade)));
      }
    }
    return out;
  }

  /// Fixes what the data cannot tell.
  void choose_searches() {
    exponent_ = cutting_.density_exponent;
    normal_ratio_ = cutting_.normal_ratio;
    fit_exponent_ = is_law() && density_spread(basis_.volume_mm3()) >= kLeastSpread;
    fit_normal_ratio_ = options_.fit_normal_ratio;
    problem_.weigh(nullptr, 0);
    const auto n = static_cast<Eigen::Index>(problem_.units());
    Eigen::VectorXd p = Eigen::VectorXd::Zero(problem_.columns()), normal = p;
    p.head(n).setOnes();
    normal.segment(n, n).setOnes();
    normal_matters_ = normal.dot(problem_.gram() * normal) > kNegligible * p.dot(problem_.gram() * p);
    fit_normal_ratio_ = fit_normal_ratio_ && normal_matters_;
  }

  /// Columns whose coefficients are found by linear least squares: u of each class, or of all by the law; K_t, K_n.
  [[nodiscard]] Eigen::MatrixXd linear_part(double exponent, double normal_ratio) const {
    const auto n = static_cast<Eigen::Index>(problem_.units());
    const Eigen::Index own = is_law() ? 1 : n, edge = problem_.has_edge() ? 2 : 0;
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(problem_.columns(), own + edge);
    for (Eigen::Index unit = 0; unit < n; ++unit) {
      const Eigen::Index column = is_law() ? 0 : unit;
      const double u = is_law() ? relative_energy(unit, exponent) : 1;
      out(unit, column) = kMillijoules * u;
      out(n + unit, column) = kMillijoules * u * normal_ratio;
    }
    for (Eigen::Index i = 0; i < edge; ++i) out(2 * n + i, own + i) = 1;
    return out;
  }

  [[nodiscard]] double relative_energy(Eigen::Index unit, double exponent) const {
    return std::pow(density_[static_cast<std::size_t>(unit)] / cutting_.reference_density_g_cm3, exponent);
  }

  [[nodiscard]] Eigen::VectorXd solve(double exponent, double normal_ratio) const {
    const Eigen::MatrixXd part = linear_part(exponent, normal_ratio);
    return nonnegative_least_squares(part.transpose() * problem_.gram() * part, part.transpose() * problem_.right());
  }

  [[nodiscard]] double squares(double exponent, double normal_ratio) const {
    return problem_.squares(linear_part(exponent, normal_ratio) * solve(exponent, normal_ratio));
  }

  [[nodiscard]] double best_normal_ratio(double exponent) const {
    if (!fit_normal_ratio_) return normal_ratio_;
    return minimize([&](double k) { return squares(exponent, k); }, 0, kMostNormalRatio, 40);
  }

  void search() {
    if (fit_exponent_) {
      exponent_ = minimize([&](double p) { return squares(p, best_normal_ratio(p)); }, 0, kMostExponent, 20);
    }
    normal_ratio_ = best_normal_ratio(exponent_);
    linear_ = solve(exponent_, normal_ratio_);
  }

  [[nodiscard]] Eigen::VectorXd coefficients_at() const { return linear_part(exponent_, normal_ratio_) * linear_; }

  /// The derivatives of the coefficients by the constants, in the order of the result.
  [[nodiscard]] Eigen::MatrixXd derivatives() const {
    const auto n = static_cast<Eigen::Index>(problem_.units());
    const Eigen::MatrixXd linear = linear_part(exponent_, normal_ratio_);
    const Eigen::Index own = is_law() ? 1 : n;
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(problem_.columns(), linear.cols() + (is_law() ? 2 : 1));
    out.leftCols(own) = linear.leftCols(own);
    const Eigen::VectorXd c = coefficients_at();
    Eigen::Index at = own;
    if (is_law()) {
      for (Eigen::Index i = 0; i < n; ++i) {
        const double log = std::log(density_[static_cast<std::size_t>(i)] / cutting_.reference_density_g_cm3);
        out(i, at) = c[i] * log;
        out(n + i, at) = c[n + i] * log;
      }
      ++at;
    }
    for (Eigen::Index i = 0; i < n; ++i) out(n + i, at) = c[i];
    ++at;
    for (Eigen::Index i = own; i < linear.cols(); ++i) out.col(at++) = linear.col(i);
    return out;
  }

  [[nodiscard]] std::vector<FittedConstant> constants() const {
    std::vector<FittedConstant> out;
    const auto add = [&](const std::string& name, double value, bool fitted) {
      out.push_back({.name = name, .value = value, .fitted = fitted, .at_bound = fitted && value <= 0});
    };
    const Eigen::Index own = is_law() ? 1 : static_cast<Eigen::Index>(problem_.units());
    if (is_law()) {
      add("u0", linear_[0], true);
      add("p", exponent_, fit_exponent_);
    } else {
      for (Eigen::Index i = 0; i < own; ++i) add("u" + std::to_string(i + 1), linear_[i], true);
    }
    add("k_n", normal_ratio_, fit_normal_ratio_);
    if (problem_.has_edge()) {
      add("K_t", linear_[own], true);
      add("K_n", linear_[own + 1], true);
    }
    return out;
  }

  /// Standard errors and covariance, and what they say.
  void add_covariance(ForceFit& out) const {
    std::vector<Eigen::Index> free;
    for (std::size_t i = 0; i < out.constants.size(); ++i) {
      out.constants[i].standard_error = std::nan("");
      if (out.constants[i].fitted && !out.constants[i].at_bound) free.push_back(static_cast<Eigen::Index>(i));
    }
    out.covariance.resize(0, 0);
    if (free.empty()) return;
    const Eigen::MatrixXd all = derivatives();
    const Eigen::MatrixXd part = all(Eigen::seqN(0, all.rows()), free);
    const Eigen::MatrixXd information = part.transpose() * problem_.gram() * part;
    const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * information * scale.asDiagonal());
    constexpr double kSingular = 1e-12;
    const double freedom = std::max(1.0, static_cast<double>(problem_.samples()) - static_cast<double>(free.size()));
    const double variance = problem_.squares(coefficients_at()) / freedom;
    const Eigen::VectorXd inverse = eigen.eigenvalues().cwiseMax(kSingular).cwiseInverse();
    out.covariance = variance * (scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
                                 eigen.eigenvectors().transpose() * scale.asDiagonal());
    for (std::size_t i = 0; i < free.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      out.constants[static_cast<std::size_t>(free[i])].standard_error = std::sqrt(out.covariance(at, at));
    }
  }

  static void add_correlations(ForceFit& out) {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < out.constants.size(); ++i)
      if (out.constants[i].fitted && !out.constants[i].at_bound) free.push_back(i);
    for (std::size_t i = 0; i < free.size(); ++i) {
      for (std::size_t j = i + 1; j < free.size(); ++j) {
        const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
        const double correlation = out.covariance(a, b) / std::sqrt(out.covariance(a, a) * out.covariance(b, b));
        if (!(std::abs(correlation) > kHighCorrelation)) continue;
        out.statements.push_back(
            fmt::format("{} and {} are hard to tell apart (correlation {:.4f}): only a combination "
                        "of them is well determined",
                        out.constants[free[i]].name, out.constants[free[j]].name, correlation));
      }
    }
  }

  void add_statements(ForceFit& out) const {
    if (is_law() && !fit_exponent_ && !without_energy()) {
      out.statements.push_back(fmt::format(
          "the removed bone has nearly one density: it cannot tell the exponent from u0, so p stays that of "
          "the run ({:g}); what is determined is u = {:.5g} J/mm3 at {:.3g} g/cm3",
          exponent_, linear_[0] * std::pow(mean_density() / cutting_.reference_density_g_cm3, exponent_),
          mean_density()));
    }
    if (options_.fit_normal_ratio && !normal_matters_ && !without_energy()) {
      out.statements.push_back(fmt::format(
          "the measured columns do not tell k_n, which stays that of the run ({:g}); measure the axial force and the "
          "spin torque together",
          normal_ratio_));
    }
    for (const FittedConstant& c : out.constants) {
      if (c.at_bound) {
        out.statements.push_back(c.name +
                                 " is 0: a negative value would fit better, so the model or the data are wrong");
      } else if (c.fitted && c.standard_error > kMostRelativeError * std::abs(c.value)) {
        out.statements.push_back(c.name + " is not determined by these data: its standard error exceeds half of it");
      }
    }
    add_correlations(out);
    if (out.statements.empty() && out.warnings.empty())
      out.statements.emplace_back("all constants are determined by these data");
  }

  [[nodiscard]] double mean_density() const {
    double sum = 0, volume = 0;
    for (const DensityClass& c : classes_) {
      sum += c.mean_g_cm3 * c.volume_mm3;
      volume += c.volume_mm3;
    }
    return volume > 0 ? sum / volume : 0;
  }

  [[nodiscard]] ForceConstants force() const {
    ForceConstants out;
    const Eigen::VectorXd c = coefficients_at();
    Eigen::Index unit = 0;
    for (const DensityClass& of : classes_) {
      for (const int grade : of.grades) {
        out.specific_energy_n_mm2[static_cast<std::size_t>(grade)] = c[unit];
        if (is_law()) ++unit;
      }
      if (!is_law()) ++unit;
    }
    out.normal_ratio = normal_ratio_;
    if (problem_.has_edge()) {
      out.edge_tangential_n_mm = c[problem_.columns() - 2];
      out.edge_normal_n_mm = c[problem_.columns() - 1];
    }
    return out;
  }

  [[nodiscard]] ForceFit result() const {
    ForceFit out;
    out.constants = constants();
    out.classes = classes_;
    out.residuals = problem_.residuals(coefficients_at());
    out.force = force();
    add_covariance(out);
    return out;
  }

  const CuttingSettings& cutting_;
  const FitOptions& options_;
  const ForceBasis& basis_;
  const std::string& measured_file_;
  std::vector<DensityClass> classes_;
  std::vector<double> density_;  ///< of each grade
  FitProblem problem_;
  double exponent_ = 0, normal_ratio_ = 0;
  bool fit_exponent_ = false, fit_normal_ratio_ = false, normal_matters_ = true;
  Eigen::VectorXd linear_;
};

}  // namespace

const FittedConstant& ForceFit::of(const std::string& name) const {
  const auto found = std::ranges::find(constants, name, &FittedConstant::name);
  if (found == constants.end()) throw std::out_of_range(name);
  return *found;
}

ForceFit fit_forces(const ForceBasis& basis, const std::vector<FrameTime>& frames, const CuttingSettings& cutting,
                    const MeasuredForces& measured, const FitOptions& options) {
  return Fit(basis, frames, cutting, measured, options).run();
}

}  // namespace reamsim
