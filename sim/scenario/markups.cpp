// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/markups.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {
namespace {

/// In small letters, with one space between words.
std::string folded_label(std::string_view text) {
  std::string out = lower_case(std::string(without_blanks(text)));
  std::ranges::replace(out, '\t', ' ');
  const auto rest = std::ranges::unique(out, [](char a, char b) { return a == ' ' && b == ' '; });
  out.erase(rest.begin(), rest.end());
  return out;
}

Vec3 placed_position(const Markups& markups, const MarkupsPoint& point) {
  if (!point.placed) {
    markups.fail("the point " + shown_text(point.label) + " has no position: it is not placed yet",
                 "place it in 3D Slicer and save the file again");
  }
  return point.position_mm;
}

constexpr std::uintmax_t kMostMarkupsBytes = 16u << 20;
constexpr std::size_t kMostMarkupsPoints = 100'000;
constexpr const char* kExpectedMarkups =
    "expected a markups file of 3D Slicer: .mrk.json or .fcsv, as its module Markups saves it";

constexpr std::string_view kAroundCells = " \t\r";

/// The cells of a line. A cell that begins with a quotation mark may hold commas, and two marks for one (RFC 4180).
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool next_is_quote = i + 1 < line.size() && line[i + 1] == '"';
    if (quoted && c == '"' && next_is_quote) {
      cells.back() += line[++i];
    } else if (quoted ? c == '"' : c == '"' && without_blanks(cells.back(), kAroundCells).empty()) {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = std::string(without_blanks(cell, kAroundCells));
  return cells;
}

/// Slicer 5 writes two cells beyond its header: the state of the point (2: placed), and who made it.
constexpr std::string_view kState = "position status", kPlaced = "2";

/// An .fcsv, line by line. Versions of Slicer 4 and 5 name their coordinate system: 0 or RAS, 1 or LPS; without it, and
/// in files of Slicer 3, the points are RAS, as Slicer reads them. Throws InputError with line.
class FcsvParser {
 public:
  explicit FcsvParser(const std::string& path) : path_(path) {}

  Markups read(const std::string& text) {
    for (const std::string& as_written : split(text, '\n')) {
      ++line_;
      const std::string_view line = without_blanks(as_written, kAroundCells);
      if (line.starts_with('#')) take_comment(without_blanks(line.substr(1), kAroundCells));
      if (!line.empty() && !line.starts_with('#')) take_point(line);
    }
    if (!known_ && points_.empty()) fail("is no markups file of 3D Slicer", kExpectedMarkups);
    const char* const unstated = "RAS, as 3D Slicer takes it where the header names no coordinate system";
    return {.path = path_,
            .markups = {{name_, std::move(points_)}},
            .frame = stated_ ? std::string(lps_ ? "LPS" : "RAS") + ", as its header says" : unstated};
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError({shown_path(path_), line_, 0}, "", found, expected);
  }

  void take_comment(std::string_view comment) {
    if (comment.starts_with("Fiducial List file")) known_ = true;
    const std::size_t equals = comment.find('=');
    if (equals == std::string_view::npos) return;
    const std::string_view key = without_blanks(comment.substr(0, equals), kAroundCells),
                           value = without_blanks(comment.substr(equals + 1), kAroundCells);
    if (key == "Markups fiducial file version" || key == "columns") {
      known_ = true;
      columns_ = cells_of(key == "columns" ? value : "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,node");
      if (columns_.size() == 14) columns_.emplace_back(kState);
    } else if (key == "CoordinateSystem") {
      take_frame(value);
    } else if (key == "name") {
      name_ = value;
    }
  }

  void take_frame(std::string_view value) {
    const bool before = std::exchange(lps_, value == "1" || value == "LPS");
    const bool repeated = stated_ && lps_ == before;  // joined files
    if (!points_.empty() && !repeated) fail("names its coordinate system after points", "expected it before them");
    stated_ = true;
    if (lps_ || value == "0" || value == "RAS") return;
    fail("CoordinateSystem is " + shown_text(value),
         "expected 0 or RAS, 1 or LPS; save the points again in 3D Slicer, in the frame of the patient");
  }

  void take_point(std::string_view line) {
    if (line.find('|') != std::string_view::npos && line.find(',') == std::string_view::npos)
      fail("is an annotation of an old 3D Slicer (.acsv)", "open it in 3D Slicer and save it as .mrk.json or .fcsv");
    const std::vector<std::string> cells = cells_of(line);
    if (!known_ && cells.size() < 4) fail("is no markups file of 3D Slicer", kExpectedMarkups);
    MarkupsPoint point;
    point.label = cell(cells, "label").value_or("");
    const std::optional<std::string> state = cell(cells, kState);
    point.placed = !state || state->empty() || *state == kPlaced;
    const Vec3 as_written(number(cells, "x"), number(cells, "y"), number(cells, "z"));
    // 0.0 is added so that a sign that changes leaves no negative zero.
    point.position_mm = (lps_ ? as_written : Vec3(-as_written.x(), -as_written.y(), as_written.z())).array() + 0.0;
    points_.push_back(std::move(point));
  }

  [[nodiscard]] std::optional<std::string> cell(const std::vector<std::string>& cells, std::string_view name) const {
    const auto column = static_cast<std::size_t>(std::ranges::find(columns_, name) - columns_.begin());
    return column < columns_.size() && column < cells.size() ? std::optional(cells[column]) : std::nullopt;
  }

  [[nodiscard]] double number(const std::vector<std::string>& cells, const char* name) const {
    const std::optional<std::string> text = cell(cells, name);
    if (!text) fail("has no column " + std::string(name), kExpectedMarkups);
    const std::optional<double> value = parse_number(*text);
    if (!value || !std::isfinite(*value)) {
      fail(std::string(name) + " is " + shown_text(*text),
           known_ ? "expected a finite number with a decimal point, in mm" : kExpectedMarkups);
    }
    return *value;
  }

  const std::string& path_;
  std::string name_;
  std::vector<MarkupsPoint> points_;
  int line_ = 0;
  bool known_ = false;   // a comment says that this is an .fcsv
  bool stated_ = false;  // and one names its frame
  bool lps_ = false;
  std::vector<std::string> columns_{"label", "x", "y", "z", "sel", "vis"};  // of Slicer 3
};

using MarkupsJson = nlohmann::json;

/// A value of an object, or null where there is none.
const MarkupsJson& value_in(const MarkupsJson& json, const char* key) {
  static const MarkupsJson kNull;
  return json.contains(key) ? json.at(key) : kNull;
}

/// A text of an object, or "" where there is none.
std::string text_in(const MarkupsJson& json, const char* key, const Markups& file) {
  const MarkupsJson& text = value_in(json, key);
  if (!text.is_null() && !text.is_string()) file.fail(std::string(key) + " is no text", kExpectedMarkups);
  return text.is_null() ? "" : text.get<std::string>();
}

/// Notes the frame in `file`.
bool is_lps(const MarkupsJson& markup, Markups& file) {
  const std::string frame = text_in(markup, "coordinateSystem", file);
  const bool lps = frame.empty() || frame == "LPS";
  if (!lps && frame != "RAS") {
    file.fail("coordinateSystem is " + shown_text(frame),
              "expected LPS or RAS; save the points again in 3D Slicer, in the frame of the patient");
  }
  const std::string said = frame.empty() ? "LPS, the default of its schema" : frame + ", as its header says";
  file.frame = file.frame.empty() || file.frame == said ? said : "LPS and RAS, as its markups say";
  return lps;
}

double unit_mm_of(const MarkupsJson& markup, const Markups& file) {
  constexpr std::array<std::pair<std::string_view, double>, 6> kUnitsInMm{
      {{"mm", 1}, {"um", 1e-3}, {"µm", 1e-3}, {"cm", 10}, {"m", 1000}, {"[in_i]", 25.4}}};
  const MarkupsJson& units = value_in(markup, "coordinateUnits");
  if (units.is_null()) return 1;
  // A code of UCUM, or the code with its scheme and its meaning.
  const MarkupsJson& code = units.is_array() && !units.empty() ? units[0] : units;
  for (const auto& [name, mm] : kUnitsInMm) {
    if (code == MarkupsJson(name)) return mm;
  }
  file.fail("coordinateUnits is " + shown_text(code.is_string() ? code.get<std::string>() : code.dump()),
            "expected mm, um, cm, m or [in_i]");
}

MarkupsPoint point_of(const MarkupsJson& json, bool lps, double unit_mm, const Markups& file) {
  if (!json.is_object()) file.fail("has a control point that is no object", kExpectedMarkups);
  MarkupsPoint point;
  point.label = text_in(json, "label", file);
  const std::string status = text_in(json, "positionStatus", file);
  const MarkupsJson& position = value_in(json, "position");
  point.placed = !position.is_null() && (status.empty() || status == "defined");
  if (!point.placed) return point;
  const std::string name = "the position of the point " + shown_text(point.label);
  if (!position.is_array() || position.size() != 3)
    file.fail(name + " is " + shown_text(position.dump()), "expected 3 numbers");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!position[i].is_number()) file.fail(name + " has " + shown_text(position[i].dump()), "expected 3 numbers");
    const double value = position[i].get<double>() * unit_mm;
    if (!std::isfinite(value)) file.fail(name + " is not finite", "expected 3 numbers");
    point.position_mm[static_cast<Eigen::Index>(i)] = lps || i == 2 ? value + 0.0 : 0.0 - value;
  }
  return point;
}

Markup markup_of(const MarkupsJson& json, Markups& file) {
  if (!json.is_object()) file.fail("has a markup that is no object", kExpectedMarkups);
  Markup markup{.name = text_in(json, "name", file), .points = {}};
  const bool lps = is_lps(json, file);
  const double unit_mm = unit_mm_of(json, file);
  const MarkupsJson& points = value_in(json, "controlPoints");
  if (!points.is_null() && !points.is_array()) file.fail("controlPoints is no list", kExpectedMarkups);
  for (const MarkupsJson& point : points) markup.points.push_back(point_of(point, lps, unit_mm, file));
  return markup;
}

/// The text of an .mrk.json (schema 1.0.0 to 1.0.4), LPS and mm where it does not say. Throws InputError.
Markups parse_markups_json(const std::string& text, Markups file) {
  constexpr int kMostLevels = 32;  // a deeper document is no markups file, and those who read it recurse
  bool too_deep = false;
  const auto visit = [&](int depth, MarkupsJson::parse_event_t, MarkupsJson&) {
    too_deep = too_deep || depth > kMostLevels;
    return !too_deep;
  };
  const MarkupsJson json = MarkupsJson::parse(text, visit, /*allow_exceptions=*/false);
  if (json.is_discarded() || too_deep) file.fail("is no JSON, or is cut off", kExpectedMarkups);
  if (!json.is_object() || !json.contains("markups") || !json["markups"].is_array())
    file.fail("is no markups file of 3D Slicer: there is no list \"markups\"", kExpectedMarkups);
  for (const MarkupsJson& markup : json["markups"]) file.markups.push_back(markup_of(markup, file));
  return file;
}

constexpr const char* kExpectedValue = "expected {markups: FILE, point: LABEL}";

/// The labels that a value lists; none: those of the file.
std::vector<std::string> labels_of(const YamlNode& node, const std::string& file, const std::string& key) {
  const auto reject = [&](const YamlMark& mark, const std::string& found) {
    throw InputError(mark.in(file), key, found, kExpectedValue);
  };
  std::vector<std::string> out;
  for (const YamlEntry& entry : node.entries) {
    const YamlNode& value = *entry.value;
    if (entry.key != "markups" && entry.key != "point") reject(entry.mark, "found " + shown_key(entry.key));
    const bool list = entry.key == "point" && value.kind == YamlNode::Kind::sequence && !value.items.empty();
    if (!list && value.kind != YamlNode::Kind::scalar) reject(value.mark, shown_key(entry.key) + " is " + shown(value));
    if (entry.key == "markups") continue;
    if (!list) out.push_back(value.text);
    for (const YamlNodePtr& item : value.items) {
      if (item->kind != YamlNode::Kind::scalar) reject(item->mark, "point has " + shown(*item));
      out.push_back(item->text);
    }
  }
  return out;
}

}  // namespace

std::string shown_labels(const std::vector<MarkupsPoint>& points) {
  constexpr std::size_t kMostShown = 20;
  std::vector<std::string> shown;
  for (const MarkupsPoint& point : points | std::views::take(kMostShown)) shown.push_back(shown_text(point.label));
  const std::string out = fmt::format("{}", fmt::join(shown, ", "));
  return points.size() > shown.size() ? fmt::format("{} and {} more", out, points.size() - shown.size()) : out;
}

void Markups::fail(const std::string& found, const std::string& expected) const {
  refuse_file(shown_path(path), found, expected);
}

std::vector<MarkupsPoint> Markups::points() const {
  std::vector<MarkupsPoint> out;
  for (const Markup& markup : markups) out.insert(out.end(), markup.points.begin(), markup.points.end());
  return out;
}

Vec3 Markups::position_mm(std::string_view label) const {
  const std::vector<MarkupsPoint> all = points();
  std::vector<MarkupsPoint> found;
  const auto find = [&](const auto& same) { std::ranges::copy_if(all, std::back_inserter(found), same); };
  find([&](const MarkupsPoint& point) { return point.label == label; });
  if (found.empty()) find([&](const MarkupsPoint& point) { return folded_label(point.label) == folded_label(label); });
  if (found.empty())
    fail("has no point " + shown_text(label),
         all.empty() ? "the file has no points" : "expected one of the labels " + shown_labels(all));
  if (found.size() > 1) {
    fail("has " + std::to_string(found.size()) + " points with the label " + shown_text(label),
         "give each a label of its own in 3D Slicer; found " + shown_labels(all));
  }
  return placed_position(*this, found.front());
}

Vec3 Markups::only_position_mm() const {
  const std::vector<MarkupsPoint> all = points();
  if (all.size() == 1) return placed_position(*this, all.front());
  if (all.empty()) fail("has no points", "place a point in 3D Slicer and save the file again");
  fail("has " + std::to_string(all.size()) + " points", "name one: point: LABEL, one of " + shown_labels(all));
}

std::vector<Vec3> Markups::positions_mm() const {
  if (markups.size() > 1) {
    std::string names;
    for (const Markup& markup : markups) {
      names += (names.empty() ? "" : ", ") + shown_text(markup.name) + " with " + std::to_string(markup.points.size());
    }
    fail("has " + std::to_string(markups.size()) + " markups: " + names + " points",
         "expected a file of one markup, or the labels of the points: point: [LABEL, LABEL, ...]");
  }
  std::vector<Vec3> out;
  for (const MarkupsPoint& point : points()) out.push_back(placed_position(*this, point));
  return out;
}

Markups read_markups(const std::string& path) {
  const Markups file{.path = path, .markups = {}, .frame = ""};
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (!error && bytes > kMostMarkupsBytes) file.fail("is larger than 16 MB", kExpectedMarkups);
  if (!error && bytes == 0) file.fail("is empty", kExpectedMarkups);
  std::string text = read_file(path, kExpectedMarkups);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) file.fail("is empty", kExpectedMarkups);
  const bool json = text[first] == '{' || text[first] == '[';
  Markups out = json ? parse_markups_json(text, file) : FcsvParser(path).read(text);
  if (const std::size_t points = out.points().size(); points > kMostMarkupsPoints)
    out.fail("has " + std::to_string(points) + " points", "at most 100,000 are possible");
  return out;
}

std::vector<Vec3> MarkupsKeys::points(const KeyInfo& info, const YamlNode& node, const std::string& key, bool several) {
  try {
    return found_points(info, node, key, several);
  } catch (const InputError& error) {  // what it says of the file is said at the value in the scenario
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (!mistake.key.empty()) continue;
      mistake.found = mistake.where.text() + ": " + mistake.found;
      mistake.where = node.mark.in(file_);
      mistake.key = key;
    }
    throw InputError(std::move(mistakes));
  }
}

std::vector<Vec3> MarkupsKeys::found_points(const KeyInfo& info, const YamlNode& node, const std::string& key,
                                            bool several) {
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(node.mark.in(file_), key, found, expected);
  };
  std::vector<std::string> labels = labels_of(node, file_, key);
  const YamlNode& name = *node.find("markups")->value;
  if (name.text.empty()) throw InputError(name.mark.in(file_), key, "markups is empty", kExpectedValue);
  const std::string path = resolve_path(name.text, TextKind::input_file, folder_, name.mark.in(file_), key);
  if (!read_.contains(path)) read_.emplace(path, read_markups(path));
  const Markups& markups = read_.at(path);
  if (!several && labels.size() > 1)
    fail("point has " + std::to_string(labels.size()) + " labels", "expected one: this key is one point");
  std::vector<Vec3> out;
  for (const std::string& label : labels) out.push_back(markups.position_mm(label));
  if (labels.empty()) out = several ? markups.positions_mm() : std::vector{markups.only_position_mm()};
  if (several && std::ssize(out) < info.least_points) {
    fail("found " + std::to_string(out.size()) + " points in " + shown_path(path),
         "expected at least " + std::to_string(info.least_points));
  }
  for (const Vec3& p : out) {
    if (info.range.contains(p.x()) && info.range.contains(p.y()) && info.range.contains(p.z())) continue;
    fail("found the point (" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ") mm",
         "expected each number " + range_text(info.range));
  }
  for (std::string& label : labels) label = shown_text(label);
  const std::string found = labels.empty() ? fmt::format("{} point{}", out.size(), out.size() == 1 ? "" : "s")
                                           : fmt::format("{}", fmt::join(labels, ", "));
  sources_.push_back({key, path, found + " of " + shown_path(path) + " (" + markups.frame + ")"});
  return out;
}

}  // namespace reamsim
