// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "python/native/arguments.h"

#include <string>

namespace reamsim::python {

namespace {

/// Columns of a pose without and with the spin angle.
constexpr py::ssize_t kColumns = 8, kColumnsWithAngle = 9;

std::string shown(const py::handle& value) {
  return py::repr(value).cast<std::string>();
}

[[noreturn]] void fail(const char* name, const py::handle& found, const std::string& expected) {
  PyErr_Clear();
  throw BadInput(std::string(name) + ": found " + shown(found) + "; expected " + expected);
}

}  // namespace

template <std::size_t N>
std::array<double, N> numbers_of(const py::handle& values, const char* name) {
  const std::string expected = std::to_string(N) + " numbers";
  const auto sequence = py::reinterpret_steal<py::object>(PySequence_Fast(values.ptr(), ""));
  if (!sequence || PySequence_Fast_GET_SIZE(sequence.ptr()) != py::ssize_t{N}) fail(name, values, expected);
  std::array<double, N> out{};
  for (std::size_t i = 0; i < N; ++i) {
    out[i] = PyFloat_AsDouble(PySequence_Fast_GET_ITEM(sequence.ptr(), static_cast<py::ssize_t>(i)));
    if (out[i] == -1 && PyErr_Occurred() != nullptr) fail(name, values, expected);
  }
  return out;
}

template std::array<double, 3> numbers_of(const py::handle&, const char*);
template std::array<double, 4> numbers_of(const py::handle&, const char*);

double number_of(const py::handle& value, const char* name) {
  const double out = PyFloat_AsDouble(value.ptr());
  if (out == -1 && PyErr_Occurred() != nullptr) fail(name, value, "a number");
  return out;
}

std::optional<double> optional_number_of(const py::handle& value, const char* name) {
  return value.is_none() ? std::nullopt : std::optional(number_of(value, name));
}

Pose pose_of(const py::handle& position_mm, const py::handle& quaternion, const py::handle& spin_rpm,
             const py::handle& spin_angle_rad) {
  return {.position_mm = numbers_of<3>(position_mm, "position_mm"),
          .quaternion = numbers_of<4>(quaternion, "quaternion"),
          .spin_rpm = number_of(spin_rpm, "spin_rpm"),
          .spin_angle_rad = optional_number_of(spin_angle_rad, "spin_angle_rad")};
}

std::vector<Pose> poses_of(const py::array_t<double, py::array::c_style>& rows) {
  if (rows.ndim() != 2 || (rows.shape(1) != kColumns && rows.shape(1) != kColumnsWithAngle)) {
    throw BadInput("poses: found an array of shape " + shown(rows.attr("shape")) +
                   "; expected (n, 8): position, quaternion, spindle speed; or (n, 9), with the spin angle");
  }
  std::vector<Pose> out(static_cast<std::size_t>(rows.shape(0)));
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    const double* v = rows.data(i, 0);
    Pose& pose = out[static_cast<std::size_t>(i)];
    pose = {.position_mm = {v[0], v[1], v[2]}, .quaternion = {v[3], v[4], v[5], v[6]}, .spin_rpm = v[7]};
    if (rows.shape(1) == kColumnsWithAngle) pose.spin_angle_rad = v[8];
  }
  return out;
}

}  // namespace reamsim::python
