// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <string>

#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

// How far R·Rᵀ may be from the identity: matrices are written with few digits. A row of length 1.001 is within it.
constexpr double kRotationTolerance = 2.1e-3;

Mat3 matrix_of(const std::vector<Vec3>& rows) {
  Mat3 out;
  for (Eigen::Index i = 0; i < 3; ++i) out.row(i) = rows[static_cast<std::size_t>(i)].transpose();
  return out;
}

void check_transform(const std::string& key, const TransformSettings& transform, const KeyLocations& locations) {
  if (transform.rotation.empty()) return;
  const std::string at = key + ".rotation";
  const auto fail = [&](const std::string& found) {
    throw InputError(locations.of(at), at, found, "expected the three rows of a rotation matrix");
  };
  if (transform.rotation.size() != 3) fail("found " + std::to_string(transform.rotation.size()) + " rows");
  const Mat3 matrix = matrix_of(transform.rotation);
  const double error = (matrix * matrix.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance) fail("found rows that are not perpendicular or not of length 1");
  if (matrix.determinant() < 0) fail("found a reflection: its determinant is -1");
}

}  // namespace

Rigid TransformSettings::rigid() const {
  Rigid out = Rigid::Identity();
  if (quaternion) out.linear() = quaternion->toRotationMatrix();
  if (!rotation.empty()) out.linear() = Quat(matrix_of(rotation)).normalized().toRotationMatrix();
  out.translation() = translation_mm;
  return out;
}

void apply_format_defaults(CsvMotionSettings& csv) {
  if (csv.format != PoseFormat::tum) return;
  csv.separator = Separator::space;
  csv.time_column = "1";
  csv.position_columns = {"2", "3", "4"};
  csv.position_unit = LengthUnit::m;
  csv.quaternion_columns = {"5", "6", "7", "8"};
  csv.quaternion_order = QuaternionOrder::xyzw;
}

void check_csv(const Scenario& scenario, const KeyLocations& locations) {
  if (!scenario.motion.csv) return;
  const CsvMotionSettings& csv = *scenario.motion.csv;
  const std::string section = "motion.csv.";
  const auto fail = [&](const std::string& name, const std::string& found, const std::string& expected) {
    throw InputError(locations.of(section + name), section + name, found, "expected " + expected);
  };
  const auto require_columns = [&](const std::string& name, const std::vector<std::string>& columns,
                                   std::size_t count) {
    if (columns.size() != count) {
      fail(name, "found a list of " + std::to_string(columns.size()), std::to_string(count) + " names or numbers");
    }
    for (const std::string& column : columns) {
      if (column == "0") fail(name, "found column 0", "numbers from 1");
    }
  };
  require_columns("time_column", {csv.time_column}, 1);
  require_columns("position_columns", csv.position_columns, 3);
  require_columns("quaternion_columns", csv.quaternion_columns, 4);
  require_columns("spin_column", {csv.spin_column}, 1);
  if (csv.separator == Separator::comma && csv.decimal == DecimalMark::comma)
    fail("decimal", "found comma, which separates the columns", "another separator, or decimal: point");
  if (csv.bone_from_tracker) check_transform(section + "bone_from_tracker", *csv.bone_from_tracker, locations);
  if (csv.marker_from_tool) check_transform(section + "marker_from_tool", *csv.marker_from_tool, locations);
  if (csv.bone_from_tracker && scenario.motion.frame != PoseFrame::bone)
    fail("bone_from_tracker", "found beside motion.frame: glenoid", "motion.frame: bone, the frame that it leads to");
}

}  // namespace reamsim
