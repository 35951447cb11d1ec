// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <string>

#include "render/report/page_data.h"
#include "render/report/summary_table.h"

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

constexpr std::array kPegColumns{ListColumn{"length_mm", "Length, mm"}, ListColumn{"in_bone_mm", "In bone, mm"},
                                 ListColumn{"perforated_mm", "Perforated, mm"},
                                 ListColumn{"least_wall_mm", "Least wall, mm"}};
constexpr ListTable kPegs{"/metrics/planning/pegs", "Pegs", "Peg", kPegColumns};

}  // namespace

std::string planning_html(const Json& summary, const std::string& path) {
  const std::string tables = summary_table_html(summary, "Implant and joint line", kPose, path) +
                             summary_table_html(summary, "Support of the implant", kSupport, path) +
                             summary_table_html(summary, "Vault", kVault, path) + list_table_html(summary, kPegs, path);
  if (tables.empty()) return "";
  return "<section aria-labelledby=\"planning-title\" class=\"planning\">\n<h2 id=\"planning-title\">Planning</h2>\n"
         "<div class=\"tables\">\n" +
         tables + "</div>\n</section>\n";
}

}  // namespace reamsim
