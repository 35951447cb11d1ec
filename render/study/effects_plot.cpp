// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/study/effects_plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "render/plots/plots.h"
#include "sim/base/csv.h"
#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {
namespace embedded {
extern const char* const effects_plot_script;
}
namespace {

/// Dots of single runs in a panel; more would hide the means.
constexpr std::size_t kMostDots = 300;
/// Names of levels that fit the axis of a panel; with more it counts them.
constexpr std::size_t kMostNamedLevels = 8;
constexpr std::size_t kMostInName = 22;
constexpr double kCharacter_mm = 1.5;
/// As in effects.gp.
constexpr double kWidth_mm = 154, kWidestPanel_mm = 62;

std::string effects_csv(const MainEffects& effects) {
  std::string out = "parameter,result,level,from,to,runs,mean,sd,explained\n";
  const auto number = [](double value) { return "," + shortest_text(value); };
  for (std::size_t p = 0; p < effects.parameters.size(); ++p) {
    const EffectParameter& parameter = effects.parameters[p];
    for (std::size_t r = 0; r < effects.results.size(); ++r) {
      for (const EffectGroup& group : effects.effects[p][r].groups) {
        out += csv_text(parameter.name.key) + "," + csv_text(effects.results[r].name.key) + "," +
               csv_text(level_text(parameter, group));
        out += parameter.is_number ? number(group.from) + number(group.to) : ",,";
        out +=
            number(group.runs) + number(group.mean) + number(group.sd) + number(effects.effects[p][r].explained) + "\n";
      }
    }
  }
  return out;
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double span() const { return high - low; }
};

/// The columns and rows of panels, with what each needs.
class EffectsFigure {
 public:
  explicit EffectsFigure(const MainEffects& effects)
      : effects_(effects),
        parameters_(std::min(effects.parameters.size(), kMostParametersOfFigure)),
        results_(std::min(effects.results.size(), kMostResultsOfFigure)) {}

  [[nodiscard]] std::string data() const {
    std::string out = fmt::format("parameters = {}\nresults = {}\n", parameters_, results_);
    out += list("x_title", parameters_, [&](std::size_t p) { return x_title(effects_.parameters[p]); });
    out += list("y_title", results_, [&](std::size_t r) { return on_two_lines(effects_.results[r].name.title()); });
    out += list("joined", parameters_, [&](std::size_t p) { return effects_.parameters[p].is_number ? "1" : "0"; });
    out += list("named", parameters_, [&](std::size_t p) { return is_named(effects_.parameters[p]) ? "1" : "0"; });
    out += list("slanted", parameters_, [&](std::size_t p) { return is_slanted(effects_.parameters[p]) ? "1" : "0"; });
    out += ranges("x", parameters_, [&](std::size_t p) { return x_range(effects_.parameters[p]); });
    out += ranges("y", results_, [&](std::size_t r) { return y_range(r); });
    out += fmt::format("label_mm = {:.1f}\n", label_mm());
    return out + means() + dots();
  }

 private:
  template <typename Text>
  static std::string list(const std::string& name, std::size_t count, const Text& text) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) out += (i == 0 ? "" : ", ") + std::string(text(i));
    return fmt::format("array {}[{}] = [{}]\n", name, count, out);
  }
  template <typename Limits>
  static std::string ranges(const std::string& name, std::size_t count, const Limits& limits) {
    return list(name + "_low", count, [&](std::size_t i) { return fmt::format("{:.9g}", limits(i).low); }) +
           list(name + "_high", count, [&](std::size_t i) { return fmt::format("{:.9g}", limits(i).high); });
  }

  /// As an expression of gnuplot: a title is longer than a panel is high.
  static std::string on_two_lines(const std::string& title) {
    const auto [upper, lower] = two_lines(title);
    return upper.empty() ? gnuplot_string(lower) : gnuplot_string(upper) + " . \"\\n\" . " + gnuplot_string(lower);
  }

  [[nodiscard]] double panel_mm() const {
    return std::min(kWidth_mm / static_cast<double>(parameters_), kWidestPanel_mm) - 2.5;
  }
  static bool is_named(const EffectParameter& parameter) {
    return !parameter.has_intervals && parameter.levels.size() <= kMostNamedLevels;
  }
  /// Whether names side by side would overlap.
  [[nodiscard]] bool is_slanted(const EffectParameter& parameter) const {
    if (!is_named(parameter)) return false;
    std::size_t longest = 0;
    for (const std::string& level : parameter.levels) longest = std::max(longest, text_width(level));
    return kCharacter_mm * static_cast<double>(longest * parameter.levels.size()) > 0.85 * panel_mm();
  }
  /// Height of the names of levels below the lowest panels.
  [[nodiscard]] double label_mm() const {
    double most = 4;
    for (std::size_t p = 0; p < parameters_; ++p) {
      if (!is_slanted(effects_.parameters[p])) continue;
      for (const std::string& level : effects_.parameters[p].levels) {
        most = std::max(most, 3 + 0.6 * kCharacter_mm * static_cast<double>(text_width(cut(level))));
      }
    }
    return most;
  }
  static std::string cut(const std::string& name) {
    if (text_width(name) <= kMostInName) return name;
    std::string out;
    for (const char c : name) {
      if ((static_cast<unsigned char>(c) & 0xc0) != 0x80 && text_width(out) == kMostInName - 1) break;
      out += c;
    }
    return out + "…";
  }
  [[nodiscard]] std::string x_title(const EffectParameter& parameter) const {
    const bool is_plain = parameter.is_number || is_named(parameter);
    const std::string title = parameter.name.title() + (is_plain ? "" : ", by number");
    return kCharacter_mm * static_cast<double>(text_width(title)) < panel_mm() ? gnuplot_string(title)
                                                                               : on_two_lines(title);
  }

  /// Least distance of levels.
  static double step_of(const EffectParameter& parameter) {
    std::vector<double> x = parameter.x;
    std::ranges::sort(x);
    double least = x.back() - x.front();
    for (std::size_t i = 1; i < x.size(); ++i) {
      if (x[i] > x[i - 1]) least = std::min(least, x[i] - x[i - 1]);
    }
    return least;
  }
  static Range x_range(const EffectParameter& parameter) {
    Range range;
    for (const double x : parameter.x) range.add(x);
    const double air = parameter.is_number ? 0.12 * range.span() : 0.5;
    return {range.low - air, range.high + air};
  }
  [[nodiscard]] Range y_range(std::size_t r) const {
    Range range;
    for (const double y : effects_.results[r].y) range.add(y);
    for (std::size_t p = 0; p < parameters_; ++p) {
      for (const EffectGroup& group : effects_.effects[p][r].groups) {
        range.add(group.mean - group.sd);
        range.add(group.mean + group.sd);
      }
    }
    return {range.low - 0.05 * range.span(), range.high + 0.26 * range.span()};  // the fraction stands above the dots
  }

  /// A block for each panel: position, mean, standard deviation, name of the level, fraction explained, blank.
  [[nodiscard]] std::string means() const {
    std::string out = "$means << END\n";
    for (std::size_t p = 0; p < parameters_; ++p) {
      const EffectParameter& parameter = effects_.parameters[p];
      for (std::size_t r = 0; r < results_; ++r) {
        const MainEffect& effect = effects_.effects[p][r];
        for (const EffectGroup& group : effect.groups) {
          out += fmt::format("{:.9g},{:.9g},{:.9g},{},{:.4f},\" \"\n", group.x, group.mean, group.sd,
                             csv_text(cut(level_text(parameter, group))), effect.explained);
        }
        out += "\n\n";
      }
    }
    return out + "END\n";
  }

  /// Single runs, at most kMostDots: positions in all columns, then the results. Those of the same level are beside one
  /// another.
  [[nodiscard]] std::string dots() const {
    const std::vector<bool> shown = runs_of_table(effects_.runs.size(), kMostDots);
    std::mt19937 random(1);
    std::string out = "$runs << END\n";
    for (std::size_t i = 0; i < effects_.runs.size(); ++i) {
      const double aside = static_cast<double>(random()) / 4294967296.0 - 0.5;
      if (!shown[i]) continue;
      for (std::size_t p = 0; p < parameters_; ++p) {
        const EffectParameter& parameter = effects_.parameters[p];
        const double spread =
            parameter.has_intervals ? 0 : std::min(0.24 * step_of(parameter), 0.08 * x_range(parameter).span());
        out += fmt::format("{:.9g},", parameter.x[i] + aside * spread);
      }
      for (std::size_t r = 0; r < results_; ++r) {
        const double y = effects_.results[r].y[i];
        out += (r == 0 ? "" : ",") + (std::isnan(y) ? std::string() : fmt::format("{:.6g}", y));
      }
      out += "\n";
    }
    return out + "END\n\n";
  }

  const MainEffects& effects_;
  std::size_t parameters_, results_;
};

}  // namespace

void write_main_effects(const std::string& dir, const MainEffects& effects) {
  write_file(dir + "/effects.csv", effects_csv(effects));
  draw_plot(dir, "effects", EffectsFigure(effects).data(), embedded::effects_plot_script);
}

}  // namespace reamsim
