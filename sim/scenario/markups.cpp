// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/markups.h"

#include <algorithm>
#include <iterator>

#include "sim/base/error.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostLabelsShown = 20;

std::string folded_label(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\t';
    if (blank && (out.empty() || out.back() == ' ')) continue;
    out += blank ? ' ' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (out.ends_with(' ')) out.pop_back();
  return out;
}

}  // namespace

std::string shown_labels(const std::vector<MarkupsPoint>& points) {
  std::string out;
  for (std::size_t i = 0; i < std::min(points.size(), kMostLabelsShown); ++i) {
    out += (i == 0 ? "" : ", ") + shown_text(points[i].label);
  }
  if (points.size() > kMostLabelsShown) out += " and " + std::to_string(points.size() - kMostLabelsShown) + " more";
  return out;
}

void Markups::fail(const std::string& found, const std::string& expected) const {
  throw InputError({shown_path(path), 0, 0}, "", found, expected);
}

std::vector<MarkupsPoint> Markups::points() const {
  std::vector<MarkupsPoint> out;
  for (const Markup& markup : markups) out.insert(out.end(), markup.points.begin(), markup.points.end());
  return out;
}

namespace {

std::string has_labels(const std::vector<MarkupsPoint>& points) {
  return points.empty() ? "the file has no points" : "expected one of the labels " + shown_labels(points);
}

Vec3 placed_position(const Markups& markups, const MarkupsPoint& point) {
  if (!point.placed) {
    markups.fail("the point " + shown_text(point.label) + " has no position: it is not placed yet",
                 "place it in 3D Slicer and save the file again");
  }
  return point.position_mm;
}

}  // namespace

Vec3 Markups::position_mm(std::string_view label) const {
  const std::vector<MarkupsPoint> all = points();
  std::vector<MarkupsPoint> found;
  const auto find = [&](const auto& same) { std::ranges::copy_if(all, std::back_inserter(found), same); };
  find([&](const MarkupsPoint& point) { return point.label == label; });
  if (found.empty()) find([&](const MarkupsPoint& point) { return folded_label(point.label) == folded_label(label); });
  if (found.empty()) fail("has no point " + shown_text(label), has_labels(all));
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

}  // namespace reamsim
