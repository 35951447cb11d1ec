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

}  // namespace reamsim::python
