// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/result_json.h"

namespace reamsim {
namespace verify {

using Json = nlohmann::ordered_json;

static void to_json(Json& out, const Check& check) {
  constexpr std::array kMeasureNames{"relative", "absolute", "at_least", "at_most", "reported"};
  const bool toleranced = check.measure == Measure::relative || check.measure == Measure::absolute;
  const auto where = [](bool has_value, double value) { return has_value ? Json(value) : Json(); };
  out = {{"quantity", check.quantity},
         {"unit", check.unit},
         {"measure", kMeasureNames.at(static_cast<std::size_t>(check.measure))},
         {"expected", where(check.measure != Measure::reported, check.expected)},
         {"found", check.found},
         {"error", where(toleranced, check.error())},
         {"tolerance", where(toleranced, check.tolerance)},
         {"reason", check.reason},
         {"passed", check.passed()}};
}

REAMSIM_TO_JSON(Level, step, found, error, runs)

static void to_json(Json& out, const Refinement& refinement) {
  out = {{"quantity", refinement.quantity},
         {"unit", refinement.unit},
         {"step", refinement.step},
         {"expected", refinement.expected},
         {"levels", refinement.levels},
         {"order", refinement.order},
         {"order_of_three", refinement.index.order},
         {"grid_convergence_index", refinement.index.fraction},
         {"safety_factor", refinement.index.safety_factor}};
}

static void to_json(Json& out, const CaseFindings& found) {
  out = {{"id", found.id},
         {"title", found.title},
         {"scene", found.scene},
         {"closed_form", found.form},
         {"passed", found.passed()},
         {"seconds", found.seconds},
         {"ladders", found.refinements},
         {"checks", found.checks}};
}

}  // namespace verify

namespace {

using verify::CaseFindings;
using verify::Check;
using verify::Findings;
using verify::Json;
using verify::Measure;
using verify::Refinement;

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

std::string row(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

std::string head(const std::vector<std::string>& cells) {
  return row(cells) + fmt::format("|{}\n", fmt::join(std::vector<std::string>(cells.size(), "---|"), ""));
}

std::string with_unit(const std::string& quantity, const std::string& unit) {
  return unit.empty() ? quantity : quantity + ", " + unit;
}

std::string error_text(const verify::Level& level) {
  if (!level.error) return "–";
  const double percent = 100 * *level.error;
  return level.runs > 1 ? fmt::format("RMS {:.2g} %", percent) : fmt::format("{:+.2g} %", percent);
}

std::string expected_text(const Check& check) {
  if (check.measure == Measure::reported) return "–";
  if (check.measure == Measure::at_least) return fmt::format("≥ {:.6g}", check.expected);
  if (check.measure == Measure::at_most) return fmt::format("≤ {:.6g}", check.expected);
  return fmt::format("{:.8g}", check.expected);
}

std::string error_text(const Check& check) {
  if (check.measure == Measure::relative) return fmt::format("{:+.2g} %", 100 * check.error());
  return check.measure == Measure::absolute ? fmt::format("{:.2g}", check.error()) : "–";
}

std::string tolerance_text(const Check& check) {
  if (check.measure == Measure::relative) return fmt::format("±{:.2g} %", 100 * check.tolerance);
  return check.measure == Measure::absolute ? fmt::format("±{:.2g}", check.tolerance) : "–";
}

/// A text that is not markup.
std::string code(const std::string& text) {
  std::string out = printable(text);
  std::ranges::replace(out, '`', '\'');
  return "`" + out + "`";
}

std::string verdict(const Check& check) {
  if (check.measure == Measure::reported) return "–";
  return check.passed() ? "pass" : "**FAIL**";
}

std::string checks_table(const CaseFindings& findings) {
  std::string out =
      head({"figure", "closed form or limit", "result", "error", "tolerance", "", "reason for the tolerance"});
  for (const Check& check : findings.checks) {
    out += row({with_unit(check.quantity, check.unit), expected_text(check), fmt::format("{:.8g}", check.found),
                error_text(check), tolerance_text(check), verdict(check), check.reason});
  }
  return out + "\n";
}

std::string order_text(const std::optional<double>& order) {
  if (!order) return "none";
  return *order > 0 ? fmt::format("{:.2f}", *order) : "none, the error does not decrease with the step";
}

std::string refinement_table(const Refinement& refinement) {
  std::string out =
      head({refinement.step, with_unit(refinement.quantity, refinement.unit), "closed form", "error", "runs"});
  for (const verify::Level& level : refinement.levels) {
    out += row({fmt::format("{:g}", level.step), fmt::format("{:.8g}", level.found),
                refinement.expected ? fmt::format("{:.8g}", *refinement.expected) : "–", error_text(level),
                std::to_string(level.runs)});
  }
  out += "\nOrder of the error: " + order_text(refinement.order) +
         "; order from three levels alone: " + order_text(refinement.index.order) + "; grid convergence index " +
         fmt::format("{:.2g}", 100 * refinement.index.fraction) + " % (safety factor " +
         fmt::format("{:.2f}", refinement.index.safety_factor) + ").\n\n";
  return out;
}

}  // namespace

std::string verification_markdown(const Findings& findings) {
  std::string out = "# Verification of reamsim " REAMSIM_VERSION "\n\n";
  out += std::string(findings.quick ? "Quick" : "Full") + " suite on " + code(findings.device()) +
         ", erosion `exact`: " +
         (findings.passed() ? "all cases passed" : std::to_string(findings.failed_checks()) + " figures FAILED") +
         ". Took " + fmt::format("{:.0f}", findings.seconds) + " s.\n\n" + head({"case", "", "figures", "failed"});
  for (const CaseFindings& found : findings.all_cases()) {
    out += row({"[" + found.title + "](#" + found.id + ")", found.passed() ? "pass" : "**FAIL**",
                std::to_string(found.checks.size()), std::to_string(found.failed_checks())});
  }
  out +=
      "\nErrors are relative to the closed form unless they have a unit. The order of an error is its slope over the "
      "step size, both logarithmic, by least squares; it is \"none\" where the error is rounding. The order from three "
      "levels does not use the closed form; it is \"none\" where they do not converge monotonically. The grid "
      "convergence index is that of Roache, with this order, at most 2, and a safety factor of 1.25; without an order, "
      "with order 2 and a factor of 3.\n\n![Errors under refinement](verification.png)\n\n";
  for (const CaseFindings& found : findings.all_cases()) {
    out += "<a id=\"" + found.id + "\"></a>\n## " + found.title + "\n\nScene: " + found.scene +
           ".\n\nClosed form: " + found.form + ".\n\n";
    for (const Refinement& refinement : found.refinements) out += refinement_table(refinement);
    out += checks_table(found);
  }
  return out;
}

std::string device_markdown(const Findings& findings) {
  const auto passed = std::ranges::count_if(findings.cases, &CaseFindings::passed);
  std::string out = "# reamsim " REAMSIM_VERSION " on " + code(findings.device()) + "\n\n" +
                    fmt::format(
                        "Closed forms and invariants: {} of {} cases of the {} suite passed; every figure is in "
                        "verification.md and, with those below, in verification.json. {:.0f} s.\n\n",
                        passed, findings.cases.size(), findings.quick ? "quick" : "full", findings.seconds);
  out += head({"capability", ""});
  for (const auto& [name, value] : findings.capabilities) out += row({name, code(value)});
  for (const CaseFindings& found : findings.device_cases) {
    out += "\n## " + found.title + "\n\n" + found.scene + ". Criterion: " + found.form + ".\n\n" +
           head({"figure", "result", "limit", ""});
    for (const Check& check : found.checks) {
      out += row({with_unit(check.quantity, check.unit), fmt::format("{:.4g}", check.found), expected_text(check),
                  verdict(check)});
    }
  }
  return out;
}

std::string verification_json(const Findings& findings) {
  Json capabilities;
  for (const auto& [name, value] : findings.capabilities) capabilities[name] = value;
  const Json out{{"program", "reamsim " REAMSIM_VERSION}, {"device", findings.device()},
                 {"capabilities", capabilities},          {"suite", findings.quick ? "quick" : "full"},
                 {"passed", findings.passed()},           {"failed_checks", findings.failed_checks()},
                 {"seconds", findings.seconds},           {"cases", findings.cases},
                 {"device_cases", findings.device_cases}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_verification(const std::string& dir, const Findings& findings) {
  write_file(dir + "/verification.json", verification_json(findings));
  write_file(dir + "/verification.md", verification_markdown(findings));
  write_file(dir + "/device.md", device_markdown(findings));
  run_gnuplot(dir, "verification.gp", plot_data(findings) + embedded::script_verify,
              {"verification.png", "verification.svg"});
}

}  // namespace reamsim
