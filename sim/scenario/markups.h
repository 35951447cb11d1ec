// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/geometry.h"

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
  /// The positions of the only markup, in its order. Throws InputError where there are several, or a point is not
  /// placed.
  [[nodiscard]] std::vector<Vec3> positions_mm() const;
  /// Throws InputError with the file.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
};

/// Reads an .fcsv of any version of 3D Slicer or an .mrk.json; its content says which. RAS becomes LPS, other units
/// become mm. Throws InputError with the file: no markups, a frame that is no frame of the patient (IJK), an unknown
/// unit, a value that is no number; more than 16 MB or 100,000 points.
Markups read_markups(const std::string& path);

/// The labels of points for a message: "A", "B" and 3 more.
std::string shown_labels(const std::vector<MarkupsPoint>& points);

}  // namespace reamsim
