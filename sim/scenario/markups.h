// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// A control point of a markup of 3D Slicer.
struct MarkupsPoint {
  std::string label;
  Vec3 position_mm = Vec3::Zero();  ///< LPS
  bool placed = true;               ///< false: Slicer has the label, but no position yet
};

/// A markup: a list of points, a line, a curve, a plane.
struct Markup {
  std::string name;  ///< "" where the file has none
  std::vector<MarkupsPoint> points;
};

/// A markups file of 3D Slicer.
struct Markups {
  std::string path;
  std::vector<Markup> markups;
  std::string frame;  ///< of the file, for messages: "RAS, as its header says"

  /// All points, in the order of the file.
  [[nodiscard]] std::vector<MarkupsPoint> points() const;
  /// The position of the point with this label; a to z equal A to Z where no label is the same. LPS, mm. Throws
  /// InputError with the labels that the file has: none, several, or one that is not placed.
  [[nodiscard]] Vec3 position_mm(std::string_view label) const;
  /// The position of the only point. Throws InputError where there are several or none.
  [[nodiscard]] Vec3 only_position_mm() const;
  /// The positions of the only markup, in its order. Throws InputError: several markups, a point that is not placed.
  [[nodiscard]] std::vector<Vec3> positions_mm() const;
  /// Throws InputError with the file.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
};

/// Reads an .fcsv of any version of 3D Slicer or an .mrk.json, by its content. RAS becomes LPS, other units become mm.
/// Throws InputError: no markups, a frame or unit that is unknown, no number, more than 16 MB or 100,000 points.
Markups read_markups(const std::string& path);

/// The labels of points for a message: "A", "B" and 3 more.
std::string shown_labels(const std::vector<MarkupsPoint>& points);

/// Keys of points whose value is {markups: FILE, point: LABEL}. Reads each file once.
class MarkupsKeys {
 public:
  /// `folder`: base of relative paths. `file`: name of the scenario in messages.
  MarkupsKeys(std::string file, std::string folder) : file_(std::move(file)), folder_(std::move(folder)) {}

  /// Whether a value names a file of markups, and not numbers.
  static bool are_in(const KeyInfo& info, const YamlNode& node) {
    return info.point && node.kind == YamlNode::Kind::map && node.find("markups") != nullptr;
  }

  /// The point of a value, or with `several` those that `point` lists, or all of the file; LPS, mm. Throws InputError
  /// with the place of the value, `key`, the file and its labels.
  std::vector<Vec3> points(const KeyInfo& info, const YamlNode& node, const std::string& key, bool several);

  [[nodiscard]] const std::vector<MarkupsSource>& sources() const { return sources_; }

 private:
  std::vector<Vec3> found_points(const KeyInfo& info, const YamlNode& node, const std::string& key, bool several);

  std::string file_;
  std::string folder_;
  std::map<std::string, Markups> read_;  // by path
  std::vector<MarkupsSource> sources_;
};

}  // namespace reamsim
