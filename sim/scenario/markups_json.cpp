// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "sim/base/error.h"
#include "sim/scenario/markups_formats.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

using MarkupsJson = nlohmann::json;

/// A deeper document is no markups file, and those who read it recurse.
constexpr int kMostMarkupsLevels = 32;

constexpr std::array<std::pair<std::string_view, double>, 6> kMarkupsUnits{
    {{"mm", 1}, {"um", 1e-3}, {"µm", 1e-3}, {"cm", 10}, {"m", 1000}, {"[in_i]", 25.4}}};

/// The markups of a document.
class JsonMarkups {
 public:
  explicit JsonMarkups(const std::string& path) { out_.path = path; }

  Markups read(const MarkupsJson& json) {
    if (!json.is_object() || !json.contains("markups") || !json["markups"].is_array())
      fail("is no markups file of 3D Slicer: there is no list \"markups\"", kExpectedMarkups);
    for (const MarkupsJson& markup : json["markups"]) take(markup);
    return std::move(out_);
  }

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError({shown_path(out_.path), 0, 0}, "", found, expected);
  }

 private:
  void take(const MarkupsJson& json) {
    if (!json.is_object()) fail("has a markup that is no object", kExpectedMarkups);
    Markup markup;
    markup.name = text(json, "name");
    const bool lps = is_lps(json);
    const double unit_mm = unit_mm_of(json);
    if (!json.contains("controlPoints") || json["controlPoints"].is_null()) return out_.markups.push_back(markup);
    if (!json["controlPoints"].is_array()) fail("controlPoints is no list", kExpectedMarkups);
    for (const MarkupsJson& point : json["controlPoints"]) markup.points.push_back(point_of(point, lps, unit_mm));
    out_.markups.push_back(std::move(markup));
  }

  /// A text, or "" where there is none.
  [[nodiscard]] std::string text(const MarkupsJson& json, const char* key) const {
    if (!json.contains(key) || json[key].is_null()) return "";
    if (!json[key].is_string()) fail(std::string(key) + " is no text", kExpectedMarkups);
    return json[key].get<std::string>();
  }

  bool is_lps(const MarkupsJson& json) {
    const std::string frame = text(json, "coordinateSystem");
    const bool lps = frame.empty() || frame == "LPS";
    if (!lps && frame != "RAS") {
      fail("coordinateSystem is " + shown_text(frame),
           "expected LPS or RAS; save the points again in 3D Slicer, in the frame of the patient");
    }
    const std::string said = frame.empty() ? "LPS, the default of its schema" : frame + ", as its header says";
    if (out_.frame.empty()) out_.frame = said;
    if (out_.frame != said) out_.frame = "LPS and RAS, as its markups say";
    return lps;
  }

  [[nodiscard]] double unit_mm_of(const MarkupsJson& json) const {
    if (!json.contains("coordinateUnits") || json["coordinateUnits"].is_null()) return 1;
    // A code of UCUM, or the code with its scheme and its meaning.
    const MarkupsJson& units = json["coordinateUnits"];
    const MarkupsJson& code = units.is_array() && !units.empty() ? units[0] : units;
    if (code.is_string()) {
      for (const auto& [name, mm] : kMarkupsUnits) {
        if (code.get_ref<const std::string&>() == name) return mm;
      }
    }
    fail("coordinateUnits is " + shown_text(code.is_string() ? code.get<std::string>() : code.dump()),
         "expected mm, um, cm, m or [in_i]");
  }

  [[nodiscard]] MarkupsPoint point_of(const MarkupsJson& json, bool lps, double unit_mm) const {
    if (!json.is_object()) fail("has a control point that is no object", kExpectedMarkups);
    MarkupsPoint point;
    point.label = text(json, "label");
    const std::string status = text(json, "positionStatus");
    const bool has_position = json.contains("position") && !json["position"].is_null();
    point.placed = has_position && (status.empty() || status == "defined");
    if (!point.placed) return point;
    const MarkupsJson& position = json["position"];
    const std::string name = "the position of the point " + shown_text(point.label);
    const bool three = position.is_array() && position.size() == 3;
    if (!three) fail(name + " is " + shown_text(position.dump()), "expected 3 numbers");
    for (std::size_t i = 0; i < 3; ++i) {
      if (!position[i].is_number()) fail(name + " has " + shown_text(position[i].dump()), "expected 3 numbers");
      const double value = position[i].get<double>() * unit_mm;
      if (!std::isfinite(value)) fail(name + " is not finite", "expected 3 numbers");
      point.position_mm[static_cast<Eigen::Index>(i)] = lps || i == 2 ? value + 0.0 : 0.0 - value;
    }
    return point;
  }

  Markups out_;
};

}  // namespace

Markups parse_markups_json(const std::string& text, const std::string& path) {
  bool too_deep = false;
  const auto visit = [&](int depth, MarkupsJson::parse_event_t, MarkupsJson&) {
    too_deep = too_deep || depth > kMostMarkupsLevels;
    return !too_deep;
  };
  const MarkupsJson json = MarkupsJson::parse(text, visit, /*allow_exceptions=*/false);
  JsonMarkups reader(path);
  if (json.is_discarded() || too_deep) reader.fail("is no JSON, or is cut off", kExpectedMarkups);
  return reader.read(json);
}

}  // namespace reamsim
