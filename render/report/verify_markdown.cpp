// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "render/report/verify_report.h"

#include "sim/base/text.h"

namespace reamsim {
namespace {

using verify::CaseFindings;
using verify::Check;
using verify::Findings;
using verify::Measure;
using verify::Refinement;

std::string row(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const std::string& cell : cells) out += " " + cell + " |";
  return out + "\n";
}

std::string head(const std::vector<std::string>& cells) {
  std::string rule = "|";
  for (std::size_t i = 0; i < cells.size(); ++i) rule += "---|";
  return row(cells) + rule + "\n";
}

std::string with_unit(const std::string& quantity, const std::string& unit) {
  return unit.empty() ? quantity : quantity + ", " + unit;
}

/// A relative error as a percentage; one that has a sign with its sign.
std::string percent(double fraction, bool has_sign = true) {
  return has_sign ? fmt::format("{:+.2g} %", 100 * fraction) : fmt::format("{:.2g} %", 100 * fraction);
}

std::string error_text(const verify::Level& level) {
  if (!level.error) return "–";
  return level.runs > 1 ? "RMS " + percent(*level.error, false) : percent(*level.error);
}

std::string expected_text(const Check& check) {
  if (check.measure == Measure::reported) return "–";
  if (check.measure == Measure::at_least) return "≥ " + fmt::format("{:.6g}", check.expected);
  if (check.measure == Measure::at_most) return "≤ " + fmt::format("{:.6g}", check.expected);
  return fmt::format("{:.8g}", check.expected);
}

std::string error_text(const Check& check) {
  if (check.measure == Measure::relative) return percent(check.error());
  return check.measure == Measure::absolute ? fmt::format("{:.2g}", check.error()) : "–";
}

std::string tolerance_text(const Check& check) {
  if (check.measure == Measure::relative) return "±" + fmt::format("{:.2g}", 100 * check.tolerance) + " %";
  return check.measure == Measure::absolute ? "±" + fmt::format("{:.2g}", check.tolerance) : "–";
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

std::string summary_table(const Findings& findings) {
  std::string out = head({"case", "", "figures", "failed"});
  for (const CaseFindings& found : findings.cases) {
    int failed = 0;
    for (const Check& check : found.checks) failed += check.passed() ? 0 : 1;
    out += row({"[" + found.title + "](#" + found.id + ")", found.passed() ? "pass" : "**FAIL**",
                std::to_string(found.checks.size()), std::to_string(failed)});
  }
  return out + "\n";
}

}  // namespace

std::string verification_markdown(const Findings& findings) {
  std::string out = "# Verification of reamsim " REAMSIM_VERSION "\n\n";
  out += std::string(findings.quick ? "Quick" : "Full") + " suite on " + code(findings.device) + ", erosion `exact`: " +
         (findings.passed() ? "all cases passed" : std::to_string(findings.failed_checks()) + " figures FAILED") +
         ". Took " + fmt::format("{:.0f}", findings.seconds) + " s.\n\n" + summary_table(findings);
  out +=
      "Errors are relative to the closed form unless they have a unit. The order of an error is its slope over the "
      "step size, both logarithmic, by least squares; it is \"none\" where the error is rounding. The order from three "
      "levels does not use the closed form; it is \"none\" where they do not converge monotonically. The grid "
      "convergence index is that of Roache, with this order, at most 2, and a safety factor of 1.25; without an order, "
      "with order 2 and a factor of 3.\n\n![Errors under refinement](verification.png)\n\n";
  for (const CaseFindings& found : findings.cases) {
    out += "<a id=\"" + found.id + "\"></a>\n## " + found.title + "\n\nScene: " + found.scene +
           ".\n\nClosed form: " + found.form + ".\n\n";
    for (const Refinement& refinement : found.refinements) out += refinement_table(refinement);
    out += checks_table(found);
  }
  return out;
}

}  // namespace reamsim
