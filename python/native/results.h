// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <pybind11/numpy.h>
#include <reamsim/simulation.h>
#include <vector>

namespace reamsim::python {

namespace py = pybind11;

/// The columns of forces.csv.
inline constexpr std::size_t kStepColumns = 26;

/// A row of forces.csv as a tuple: whole numbers where the column has them.
py::tuple tuple_of(const StepResult& step);

/// Rows of forces.csv, of shape (n, kStepColumns).
py::array_t<double> array_of(const std::vector<StepResult>& steps);

/// Position, quaternion, spindle speed and spin angle: 9 numbers per pose.
py::array_t<double> array_of(const std::vector<Pose>& poses);

/// The values as a read-only array of shape `dims`, without a copy; the centre of the first voxel, mm; the edge of a
/// voxel, mm.
py::tuple grid_of(Volume volume);

namespace py = pybind11;

/// Numbers of a sequence or an array. Throws BadInput with `name` for another length and for what is no number.
template <std::size_t N>
std::array<double, N> numbers_of(const py::handle& values, const char* name);

/// A number; nullopt for None. Throws BadInput.
double number_of(const py::handle& value, const char* name);
std::optional<double> optional_number_of(const py::handle& value, const char* name);

/// Position, quaternion (w, x, y, z), spindle speed, spin angle or None. Throws BadInput.
Pose pose_of(const py::handle& position_mm, const py::handle& quaternion, const py::handle& spin_rpm,
             const py::handle& spin_angle_rad);

/// The rows of an array: position, quaternion, spindle speed, and the spin angle if there are nine columns.
/// Throws BadInput for another shape.
std::vector<Pose> poses_of(const py::array_t<double, py::array::c_style>& rows);

}  // namespace reamsim::python
