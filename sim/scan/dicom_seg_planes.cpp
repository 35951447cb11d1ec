// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <map>

#include "sim/scan/dicom_stack.h"

namespace reamsim::ct {

namespace {

/// Each frame says where it lies; all have the same axes and pixel spacing.
void check_frames(const std::vector<DicomHeader>& frames, const std::string& path, const std::string& key) {
  const DicomHeader& first = frames.front();
  for (const DicomHeader& frame : frames) {
    if (frame.frame < 0 || !frame.position_mm || !frame.axes || !frame.pixel_spacing_mm) {
      throw bad_seg(path, key, fmt::format("frame {} does not say where it lies", std::max(frame.frame, 0) + 1));
    }
    if ((*frame.axes - *first.axes).cwiseAbs().maxCoeff() > 1e-3 ||
        (*frame.pixel_spacing_mm - *first.pixel_spacing_mm).cwiseAbs().maxCoeff() > 1e-3) {
      throw bad_seg(path, key, "its frames differ in orientation or pixel spacing");
    }
  }
}

/// The finest distance of planes, of which the others are multiples; else the spacing in the header.
double plane_step(std::vector<double> heights, double header_mm, const std::string& path, const std::string& key) {
  constexpr double kLeast_mm = 1e-3;
  std::ranges::sort(heights);
  std::vector<double> gaps;
  for (std::size_t n = 1; n < heights.size(); ++n) {
    if (heights[n] - heights[n - 1] > kLeast_mm) gaps.push_back(heights[n] - heights[n - 1]);
  }
  if (gaps.empty()) return header_mm > 0 ? header_mm : 1;
  for (double step : {std::ranges::min(gaps), header_mm}) {
    if (!(step > kLeast_mm)) continue;
    const auto is_multiple = [step](double gap) {
      constexpr double kTolerance = 0.1;
      return std::lround(gap / step) >= 1 && std::abs(gap / step - std::round(gap / step)) <= kTolerance;
    };
    if (!std::ranges::all_of(gaps, is_multiple)) continue;
    double planes = 0;
    for (const double gap : gaps) planes += std::round(gap / step);
    constexpr double kMostPlanes = 1e6;
    if (planes > kMostPlanes) throw bad_seg(path, key, "its frames lie implausibly far apart");
    return (heights.back() - heights.front()) / planes;
  }
  throw bad_seg(path, key, "its frames are not evenly spaced");
}

void check_planes(const SegPlanes& planes, const std::vector<DicomHeader>& frames, const std::string& path,
                  const std::string& key) {
  const ScanGeometry& geometry = planes.geometry;
  if (!geometry.is_valid()) throw bad_seg(path, key, "voxel spacing or axes are degenerate");
  check_fits_in_memory(static_cast<double>(geometry.size()), sizeof(float), path, key);
  const double reach = 0.5 * geometry.spacing_mm().minCoeff();
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const double off =
        (geometry.point_mm({0, 0, double{1} * planes.plane_of_frame[n]}) - *frames[n].position_mm).norm();
    if (off <= reach) continue;
    throw bad_seg(path, key,
                  fmt::format("frame {} is displaced by {:.2f} mm against evenly spaced planes", n + 1, off));
  }
}

}  // namespace

InputError bad_seg(const std::string& path, const std::string& key, const std::string& found) {
  return {{path}, key, found, "export the segmentation again, or save it as NRRD (3D Slicer)"};
}

SegPlanes seg_planes(const std::vector<DicomHeader>& frames, const std::string& path, const std::string& key) {
  check_frames(frames, path, key);
  SegPlanes out;
  const DicomHeader& first = frames.front();
  const Vec3 normal = first.normal();
  std::vector<double> heights;
  for (const DicomHeader& frame : frames) {
    heights.push_back(normal.dot(*frame.position_mm));
  }
  const double lowest = std::ranges::min(heights);
  const double step = plane_step(heights, first.slice_spacing_mm, path, key);
  std::map<int, Vec3> positions;
  for (std::size_t n = 0; n < frames.size(); ++n) {
    out.plane_of_frame.push_back(static_cast<int>(std::lround((heights[n] - lowest) / step)));
    positions.emplace(out.plane_of_frame.back(), *frames[n].position_mm);
  }
  out.geometry.dims = Vec3i(first.columns, first.rows, positions.rbegin()->first + 1);
  out.geometry.step_mm.col(0) = first.axes->col(0) * first.pixel_spacing_mm->x();
  out.geometry.step_mm.col(1) = first.axes->col(1) * first.pixel_spacing_mm->y();
  out.geometry.step_mm.col(2) = step * normal;
  out.geometry.origin_mm = positions.begin()->second;
  if (positions.size() > 1) {
    std::vector<Vec3> place;
    std::vector<double> at;
    for (const auto& [plane, position] : positions) {
      place.push_back(position);
      at.push_back(plane);
    }
    const SliceLine line = line_through(place, at);
    out.geometry.step_mm.col(2) = line.step_mm;
    out.geometry.origin_mm = line.point_mm;
  }
  check_planes(out, frames, path, key);
  return out;
}

}  // namespace reamsim::ct
