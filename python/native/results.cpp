// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "python/native/results.h"

#include <algorithm>
#include <memory>
#include <string>

namespace reamsim::python {

namespace {

using Row = std::array<double, kStepColumns>;

constexpr std::size_t kFrame = 0, kContacts = 20, kPass = 25, kPoseColumns = 9;

std::array<double, kPoseColumns> values_of(const Pose& pose) {
  const auto& [x, y, z] = pose.position_mm;
  const auto& [qw, qx, qy, qz] = pose.quaternion;
  return {x, y, z, qw, qx, qy, qz, pose.spin_rpm, pose.spin_angle_rad.value_or(0)};
}

/// In the order of forces.csv (docs/columns.md).
Row row_of(const StepResult& s) {
  Row out{static_cast<double>(s.frame), s.time_s};
  std::ranges::copy(values_of(s.pose), out.begin() + 2);
  constexpr std::size_t kAfterPose = 11;
  const auto& [fx, fy, fz] = s.force_n;
  const auto& [tx, ty, tz] = s.torque_nmm;
  constexpr double kOnlyPass = 1;
  const std::array<double, kStepColumns - kAfterPose> rest{s.depth_mm,
                                                           fx,
                                                           fy,
                                                           fz,
                                                           tx,
                                                           ty,
                                                           tz,
                                                           s.axial_force_n,
                                                           s.spin_torque_nmm,
                                                           static_cast<double>(s.contacts),
                                                           s.removed_mm3,
                                                           s.energy_mj,
                                                           s.floor_energy_mj,
                                                           s.balance,
                                                           kOnlyPass};
  std::ranges::copy(rest, out.begin() + kAfterPose);
  return out;
}

}  // namespace

py::tuple tuple_of(const StepResult& step) {
  const Row row = row_of(step);
  py::tuple out(kStepColumns);
  for (std::size_t i = 0; i < kStepColumns; ++i) {
    const bool whole = i == kFrame || i == kContacts || i == kPass;
    PyObject* value = whole ? PyLong_FromLongLong(static_cast<long long>(row[i])) : PyFloat_FromDouble(row[i]);
    if (value == nullptr) throw py::error_already_set();
    PyTuple_SET_ITEM(out.ptr(), static_cast<py::ssize_t>(i), value);
  }
  return out;
}

py::array_t<double> array_of(const std::vector<StepResult>& steps) {
  py::array_t<double> out({steps.size(), kStepColumns});
  double* at = out.mutable_data();
  for (const StepResult& step : steps) at = std::ranges::copy(row_of(step), at).out;
  return out;
}

py::array_t<double> array_of(const std::vector<Pose>& poses) {
  py::array_t<double> out({poses.size(), kPoseColumns});
  double* at = out.mutable_data();
  for (const Pose& pose : poses) at = std::ranges::copy(values_of(pose), at).out;
  return out;
}

py::tuple grid_of(Volume volume) {
  auto owned = std::make_unique<std::vector<float>>(std::move(volume.values));
  const float* data = owned->data();
  const py::capsule owner(owned.get(), [](void* values) { delete static_cast<std::vector<float>*>(values); });
  owned.release();  // NOLINT: the capsule owns it
  const auto [nx, ny, nz] = volume.dims;
  constexpr py::ssize_t kBytes = sizeof(float);
  const py::array_t<float> values({nx, ny, nz}, {kBytes, kBytes * nx, kBytes * nx * ny}, data, owner);
  values.attr("flags").attr("writeable") = false;
  std::array<double, 3> center = volume.origin_mm;
  for (double& x : center) x += 0.5 * volume.voxel_mm;
  return py::make_tuple(values, py::make_tuple(center[0], center[1], center[2]), volume.voxel_mm);
}

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
