#include <fmt/core.h>
#include <array>
#include <string>

#include "render/report/page_data.h"
#include "render/report/summary_table.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kPose{SummaryLine{"/metrics/planning/native/version_deg", "Version, native face", "°"},
                           SummaryLine{"/metrics/planning/planned/version_deg", "Version, implant", "°"},
                           SummaryLine{"/metrics/planning/retroversion_corrected_deg", "Retroversion corrected", "°"},
                           SummaryLine{"/metrics/planning/native/inclination_deg", "Inclination, native face", "°"},
                           SummaryLine{"/metrics/planning/planned/inclination_deg", "Inclination, implant", "°"},
                           SummaryLine{"/metrics/planning/inclination_corrected_deg", "Inclination corrected", "°"},
                           SummaryLine{"/metrics/planning/corrected_frame", "Frame of the corrections", ""},
                           SummaryLine{"/metrics/planning/medialization_mm", "Medialization of the joint line", "mm"},
                           SummaryLine{"/metrics/planning/native_reason", "No native orientation", ""},
                           SummaryLine{"/metrics/planning/planned_reason", "No planned orientation", ""},
                           SummaryLine{"/metrics/planning/corrected_reason", "No correction", ""},
                           SummaryLine{"/metrics/planning/medialization_reason", "No medialization", ""}};
constexpr std::array kSupport{
    SummaryLine{"/metrics/seating/seated_percent", "Backside seated", "%"},
    SummaryLine{"/metrics/seating/mean_gap_mm", "Gap under the implant, mean", "mm"},
    SummaryLine{"/metrics/seating/max_gap_mm", "Gap under the implant, maximum", "mm"},
    SummaryLine{"/metrics/seating/footprint_mm2", "Footprint", "mm²"},
    SummaryLine{"/metrics/seating/overhang_mm2", "Overhang", "mm²"},
    SummaryLine{"/metrics/seating/overhang_percent", "Overhang, of the footprint", "%"},
    SummaryLine{"/metrics/seating/dense_percent", "Dense fraction of the supporting bone", "%"}};
constexpr std::array kVault{
    SummaryLine{"/metrics/planning/vault/left_mm3", "Vault bone under the implant", "mm³"},
    SummaryLine{"/metrics/planning/vault/left_percent", "of the vault before reaming", "%"},
    SummaryLine{"/metrics/planning/vault/axis_depth_mm", "Depth on the axis of the implant", "mm"},
    SummaryLine{"/metrics/planning/vault/mean_depth_mm", "Depth, mean", "mm"}};

struct PegColumn {
  const char* key;
  const char* title;
};
constexpr std::array kPegColumns{PegColumn{"length_mm", "Length, mm"}, PegColumn{"in_bone_mm", "In bone, mm"},
                                 PegColumn{"perforated_mm", "Perforated, mm"},
                                 PegColumn{"least_wall_mm", "Least wall, mm"}};

std::string peg_cell(const Json& peg, const char* key, const std::string& path) {
  const Json value = peg.is_object() && peg.contains(key) ? peg.at(key) : Json();
  if (value.is_null()) return "–";
  if (!value.is_number()) {
    throw InputError({path, 0}, std::string("metrics.planning.pegs.") + key, "found another type", "expected a number");
  }
  return fmt::format("{:.1f}", value.get<double>());
}

/// A row for each peg, numbered as in the scenario.
std::string pegs_html(const Json& summary, const std::string& path) {
  const Json::json_pointer at("/metrics/planning/pegs");
  if (!summary.contains(at) || summary.at(at).empty()) return "";
  std::string out = "<table>\n<caption>Pegs</caption>\n<thead><tr><th scope=\"col\">Peg</th>";
  for (const PegColumn& column : kPegColumns)
    out += std::string("<th scope=\"col\" style=\"text-align: right\">") + column.title + "</th>";
  out += "</tr></thead>\n<tbody>\n";
  int number = 0;
  for (const Json& peg : summary.at(at)) {
    out += "<tr><th scope=\"row\">" + std::to_string(++number) + "</th>";
    for (const PegColumn& column : kPegColumns) out += "<td>" + peg_cell(peg, column.key, path) + "</td>";
    out += "</tr>\n";
  }
  return out + "</tbody>\n</table>\n";
}

}  // namespace

std::string planning_html(const Json& summary, const std::string& path) {
  const std::string tables = summary_table_html(summary, "Implant and joint line", kPose, path) +
                             summary_table_html(summary, "Support of the implant", kSupport, path) +
                             summary_table_html(summary, "Vault", kVault, path) + pegs_html(summary, path);
  if (tables.empty()) return "";
  return "<section aria-labelledby=\"planning-title\" class=\"planning\">\n<h2 id=\"planning-title\">Planning</h2>\n"
         "<div class=\"tables\">\n" +
         tables + "</div>\n</section>\n";
}

}  // namespace reamsim
