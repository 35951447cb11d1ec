// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/verify_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "render/plots/plots.h"
#include "sim/base/file.h"

namespace reamsim {
namespace embedded {
extern const char* const verify_plot_script;
}
namespace {

using Json = nlohmann::ordered_json;
using verify::CaseFindings;
using verify::Check;
using verify::Findings;
using verify::Measure;
using verify::Refinement;

constexpr std::array kMeasureNames{"relative", "absolute", "at_least", "at_most", "reported"};

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json check_json(const Check& check) {
  Json out{{"quantity", check.quantity},
           {"unit", check.unit},
           {"measure", kMeasureNames.at(static_cast<std::size_t>(check.measure))}};
  out["expected"] = check.measure == Measure::reported ? Json(nullptr) : Json(check.expected);
  out["found"] = check.found;
  const bool toleranced = check.measure == Measure::relative || check.measure == Measure::absolute;
  out["error"] = toleranced ? Json(check.error()) : Json(nullptr);
  out["tolerance"] = toleranced ? Json(check.tolerance) : Json(nullptr);
  out["reason"] = check.reason;
  out["passed"] = check.passed();
  return out;
}

Json refinement_json(const Refinement& refinement) {
  Json out{{"quantity", refinement.quantity}, {"unit", refinement.unit}, {"step", refinement.step}};
  out["expected"] = or_null(refinement.expected);
  out["levels"] = Json::array();
  for (const verify::Level& level : refinement.levels) {
    out["levels"].push_back(
        {{"step", level.step}, {"found", level.found}, {"error", or_null(level.error)}, {"runs", level.runs}});
  }
  out["order"] = or_null(refinement.order);
  out["order_of_three"] = or_null(refinement.index.order);
  out["grid_convergence_index"] = refinement.index.fraction;
  out["safety_factor"] = refinement.index.safety_factor;
  return out;
}

Json case_json(const CaseFindings& found) {
  Json out{{"id", found.id}, {"title", found.title}, {"scene", found.scene}, {"closed_form", found.form}};
  out["passed"] = found.passed();
  out["seconds"] = found.seconds;
  out["ladders"] = Json::array();
  for (const Refinement& refinement : found.refinements) out["ladders"].push_back(refinement_json(refinement));
  out["checks"] = Json::array();
  for (const Check& check : found.checks) out["checks"].push_back(check_json(check));
  return out;
}

/// The panel of a refinement in the figure: 1 volumes, 2 loads.
int panel_of(const Refinement& refinement) {
  return refinement.unit.starts_with("mm³") ? 1 : 2;
}

/// The data of the plot: one curve per refinement with a closed form, errors in per cent.
std::string plot_data(const Findings& findings) {
  std::ostringstream data, names;
  int curve = 0, places[2] = {0, 0};
  // The place of a curve within its panel determines its colour.
  data << "# curve, panel, step, |error| in %\n$errors << END\n";
  for (const CaseFindings& found : findings.cases) {
    for (const Refinement& refinement : found.refinements) {
      if (!refinement.expected) continue;
      ++curve;
      for (const verify::Level& level : refinement.levels) {
        const double error = 100 * std::abs(level.error.value_or(0));
        data << curve << ' ' << panel_of(refinement) << ' ' << level.step << ' ' << std::max(error, 1e-7) << '\n';
      }
      names << "name[" << curve << "] = " << gnuplot_string(found.title + ": " + refinement.quantity) << "\npanel["
            << curve << "] = " << panel_of(refinement) << "\nplace[" << curve
            << "] = " << ++places[panel_of(refinement) - 1] << '\n';
    }
  }
  if (curve == 0) data << "0 0 1 1\n";
  data << "END\ncurves = " << curve << "\narray curves_in[2] = [" << places[0] << ", " << places[1] << "]\n";
  for (const char* array : {"name", "panel", "place"}) {
    data << "array " << array << '[' << std::max(1, curve) << "]\n";
  }
  return data.str() + names.str() + "\n";
}

}  // namespace

std::string verification_json(const Findings& findings) {
  Json out;
  out["program"] = "reamsim " REAMSIM_VERSION;
  out["device"] = findings.device;
  out["suite"] = findings.quick ? "quick" : "full";
  out["passed"] = findings.passed();
  out["failed_checks"] = findings.failed_checks();
  out["seconds"] = findings.seconds;
  out["cases"] = Json::array();
  for (const CaseFindings& found : findings.cases) out["cases"].push_back(case_json(found));
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_verification(const std::string& dir, const Findings& findings) {
  write_file(dir + "/verification.json", verification_json(findings));
  write_file(dir + "/verification.md", verification_markdown(findings));
  run_gnuplot(dir, "verification.gp", plot_data(findings) + embedded::verify_plot_script,
              {"verification.png", "verification.svg"});
}

}  // namespace reamsim
