#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace reamsim {

/// A number for people: `digits` significant ones, never an exponent like 1e+04 (1.2 × 10⁻⁸ where there must be one),
/// a true minus sign, thousands parted by a thin space.
std::string number_text(double value, int digits = 4);

/// A text of summary.json, escaped. Throws InputError, in the name of `path`, where there is none.
std::string text_at(const nlohmann::ordered_json& summary, const char* key, const std::string& path);

/// The parts of the page that are made from summary.json, as HTML. Values that a run has none of are left out.
/// All throw InputError, in the name of `path`, when what stands there is not what a run writes.
std::string key_figures_html(const nlohmann::ordered_json& summary, const std::string& path);
std::string summary_tables_html(const nlohmann::ordered_json& summary, const std::string& path);
std::string provenance_html(const nlohmann::ordered_json& summary, const std::string& path);
/// The warnings of the run; "" without any.
std::string warnings_html(const nlohmann::ordered_json& summary, const std::string& path);

/// What is known of the program's correctness: the run's own energy balance, and the result of `verification`
/// (verification.json; null where there is none), with a word where it is of another program or device.
std::string verification_html(const nlohmann::ordered_json& summary, const nlohmann::ordered_json& verification,
                              const std::string& summary_path, const std::string& verification_path);

}  // namespace reamsim
