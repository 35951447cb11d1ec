// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/markups_formats.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

std::string_view trimmed_cell(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The cells of a line. A cell that begins with a quotation mark may hold commas, and two marks for one (RFC 4180).
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool next_is_quote = i + 1 < line.size() && line[i + 1] == '"';
    if (quoted && c == '"' && next_is_quote) {
      cells.back() += line[++i];
    } else if (quoted ? c == '"' : c == '"' && trimmed_cell(cells.back()).empty()) {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  for (std::string& cell : cells) cell = std::string(trimmed_cell(cell));
  return cells;
}

/// Slicer 5 writes two cells beyond its header: the state of the point (2: placed), and who made it.
constexpr std::string_view kState = "position status", kPlaced = "2";

/// An .fcsv, line by line.
class FcsvParser {
 public:
  explicit FcsvParser(const std::string& path) { out_.path = path; }

  void take(std::string_view line) {
    ++line_;
    line = trimmed_cell(line);
    if (line.empty()) return;
    if (line.starts_with('#')) return take_comment(trimmed_cell(line.substr(1)));
    take_point(line);
  }

  Markups finish() {
    if (!known_ && markup_.points.empty()) fail("is no markups file of 3D Slicer", kExpectedMarkups);
    out_.frame = lps_ ? "LPS, as its header says"
                      : (stated_ ? "RAS, as its header says"
                                 : "RAS, as 3D Slicer takes it where the header names no coordinate system");
    out_.markups.push_back(markup_);
    return out_;
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError({shown_path(out_.path), line_, 0}, "", found, expected);
  }

  void take_comment(std::string_view comment) {
    if (comment.starts_with("Fiducial List file")) known_ = true;
    const std::size_t equals = comment.find('=');
    if (equals == std::string_view::npos) return;
    const std::string_view key = trimmed_cell(comment.substr(0, equals)),
                           value = trimmed_cell(comment.substr(equals + 1));
    if (key == "Markups fiducial file version") {
      known_ = true;
      columns_ = {"id",   "x",     "y",    "z",    "ow",
                  "ox",   "oy",    "oz",   "vis",  "sel",
                  "lock", "label", "desc", "node", std::string(kState)};
    } else if (key == "CoordinateSystem") {
      take_frame(value);
    } else if (key == "columns") {
      known_ = true;
      columns_ = cells_of(value);
      if (columns_.size() == 14) columns_.emplace_back(kState);
    } else if (key == "name") {
      markup_.name = std::string(value);
    }
  }

  void take_frame(std::string_view value) {
    if (!markup_.points.empty()) fail("names its coordinate system after points", "expected it before them");
    lps_ = value == "1" || value == "LPS";
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
    point.position_mm = lps_ ? as_written : Vec3(0.0 - as_written.x(), 0.0 - as_written.y(), as_written.z());
    point.position_mm.array() += 0.0;
    markup_.points.push_back(std::move(point));
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

  Markups out_;
  Markup markup_;
  int line_ = 0;
  bool known_ = false;   // a comment says that this is an .fcsv
  bool stated_ = false;  // and one names its frame
  bool lps_ = false;
  std::vector<std::string> columns_{"label", "x", "y", "z", "sel", "vis"};  // of Slicer 3
};

}  // namespace

Markups parse_fcsv(const std::string& text, const std::string& path) {
  FcsvParser parser(path);
  for (const std::string& line : split(text, '\n')) parser.take(line);
  return parser.finish();
}

}  // namespace reamsim
