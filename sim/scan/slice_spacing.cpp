// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>

#include "sim/base/text.h"
#include "sim/scan/dicom.h"

namespace reamsim::ct {

namespace {

/// Deviation from the typical slice spacing, as a fraction of it, from which a slice counts as missing.
constexpr double kSpacingTolerance = 0.05;
/// A line through the ends is exact if no position deviates more, as a fraction of the step.
constexpr double kExact = 1e-3;

/// What a written number says about its rounding.
struct Digits {
  int decimals = 0;
  int significant = 0;
  double value = 0;
};

Digits digits_of(const std::string& text) {
  Digits out;
  out.value = std::strtod(text.c_str(), nullptr);
  const std::size_t end = std::min(text.find_first_of("eE"), text.size());
  const std::size_t point = std::min(text.find('.'), end);
  const auto count = [&](std::size_t from, std::size_t to) {
    return static_cast<int>(
        std::ranges::count_if(text.substr(from, to - from), [](char c) { return c >= '0' && c <= '9'; }));
  };
  out.decimals = count(point, end);
  if (end < text.size()) out.decimals -= std::atoi(text.c_str() + end + 1);
  const std::size_t first = std::min(text.find_first_of("123456789"), end);
  out.significant = count(first, end);
  return out;
}

std::vector<double> gaps_of(const Stack& slices) {
  std::vector<double> out;
  for (std::size_t k = 1; k < slices.size(); ++k) out.push_back(slices[k].height_mm - slices[k - 1].height_mm);
  return out;
}

bool same_gap(double a, double b) {
  return std::abs(a - b) <= kSpacingTolerance * std::min(std::abs(a), std::abs(b));
}

/// How far the positions leave room for lines with this spacing; negative: no such line lies within all half units.
double slack_of(const Stack& slices, double spacing_mm) {
  double low = -std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const double start = slices[k].height_mm - spacing_mm * static_cast<double>(k);
    low = std::max(low, start - slices[k].half_unit_mm);
    high = std::min(high, start + slices[k].half_unit_mm);
  }
  return high - low;
}

/// The spacing of the line that explains all positions by their rounding; none if there is no such line.
std::optional<double> spacing_within_rounding(const Stack& slices) {
  const double n = static_cast<double>(slices.size() - 1);
  const double mean = (slices.back().height_mm - slices.front().height_mm) / n;
  const double reach = (slices.front().half_unit_mm + slices.back().half_unit_mm) / n;
  double low = mean - reach, high = mean + reach;
  for (int step = 0; step < 100; ++step) {  // the slack is a concave function of the spacing
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    (slack_of(slices, a) < slack_of(slices, b) ? low : high) = slack_of(slices, a) < slack_of(slices, b) ? a : b;
  }
  const double best = 0.5 * (low + high);
  return explains(slices, best) ? std::optional(best) : std::nullopt;
}

/// The steps of the instance numbers across each gap, positive; empty unless instance_numbers() are known.
std::vector<int> instance_steps(const Stack& slices) {
  const std::vector<int> numbers = instance_numbers(slices);
  std::vector<int> out;
  for (std::size_t k = 1; k < numbers.size(); ++k) out.push_back(std::abs(numbers[k] - numbers[k - 1]));
  return out;
}

/// Whether a gap that holds several spacings is due to rounding: the header's spacing says so, or, where that fits
/// neither explanation, instance numbers without a jump.
bool rounding_explains(const Stack& slices, double header_mm) {
  const std::vector<double> gaps = gaps_of(slices);
  const double typical = typical_spacing(slices);
  const std::optional<double> even = spacing_within_rounding(slices);
  if (!even) return false;
  const auto is_wide = [&](double gap) { return std::lround(gap / typical) >= 2; };
  if (std::ranges::none_of(gaps, is_wide)) return true;
  const std::vector<int> steps = instance_steps(slices);
  const auto jumps = [](int step) { return step != 1; };
  if (std::ranges::any_of(steps, jumps)) return false;
  constexpr double kAgrees = 0.01;
  if (header_mm > 0 && std::abs(header_mm - typical) <= kAgrees * typical) return false;
  if (header_mm > 0 && std::abs(header_mm - *even) <= kAgrees * *even) return true;
  return !steps.empty();
}

SpacingFault fault_at(const Stack& slices, const std::vector<double>& gaps, double typical, std::size_t gap) {
  std::size_t last = gap;  // of the run of equal gaps that begins here
  while (last + 1 < gaps.size() && same_gap(gaps[last + 1], gaps[gap])) ++last;
  const std::size_t length = last - gap + 1;
  const long multiple = std::lround(gaps[gap] / typical);
  const double reach =
      kSpacingTolerance * typical + 2 * std::max(slices[gap].half_unit_mm, slices[gap + 1].half_unit_mm);
  const bool is_multiple = multiple >= 2 && std::abs(gaps[gap] - static_cast<double>(multiple) * typical) <= reach;
  const std::vector<int> steps = instance_steps(slices);
  const bool numbers_jump = !steps.empty() && steps[gap] == multiple;
  // Two wide gaps between slices without numbers are rather two missing slices than two changes.
  constexpr std::size_t kMostMissing = 2;
  const bool is_inside = gap > 0 && last + 1 < gaps.size();
  const bool is_missing = length == 1 || numbers_jump || (steps.empty() && is_inside);
  if (is_multiple && length <= kMostMissing && is_missing) {
    return {SpacingFault::Kind::missing, gap + 1, typical, gaps[gap], multiple - 1};
  }
  const long also_numbers = is_multiple && numbers_jump ? multiple - 1 : 0;
  const bool is_single = length == 1 && is_inside;
  if (gap > 0 && !is_single) return {SpacingFault::Kind::change, gap + 1, gaps[gap - 1], gaps[gap], also_numbers};
  if (gap == 0 && last + 1 < gaps.size()) return {SpacingFault::Kind::change, last + 2, gaps[gap], gaps[last + 1], 0};
  return {SpacingFault::Kind::irregular, gap + 1, typical, gaps[gap], 0};
}

/// Each frame says where it lies; all have the same axes and pixel spacing.
void check_frames(const std::vector<DicomHeader>& frames, const ForeignFile& file) {
  const DicomHeader& first = frames.front();
  for (const DicomHeader& frame : frames) {
    if (frame.frame < 0 || !frame.position_mm || !frame.axes || !frame.pixel_spacing_mm) {
      throw bad_seg(file, fmt::format("frame {} does not say where it lies", std::max(frame.frame, 0) + 1));
    }
    if ((*frame.axes - *first.axes).cwiseAbs().maxCoeff() > 1e-3 ||
        (*frame.pixel_spacing_mm - *first.pixel_spacing_mm).cwiseAbs().maxCoeff() > 1e-3) {
      throw bad_seg(file, "its frames differ in orientation or pixel spacing");
    }
  }
}

/// The finest distance of planes, of which the others are multiples; else the spacing in the header.
double plane_step(std::vector<double> heights, double header_mm, const ForeignFile& file) {
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
    if (planes > kMostPlanes) throw bad_seg(file, "its frames lie implausibly far apart");
    return (heights.back() - heights.front()) / planes;
  }
  throw bad_seg(file, "its frames are not evenly spaced");
}

void check_planes(const SegPlanes& planes, const std::vector<DicomHeader>& frames, const ForeignFile& file) {
  const ScanGeometry& geometry = planes.geometry;
  if (!geometry.is_valid()) throw bad_seg(file, "voxel spacing or axes are degenerate");
  check_fits_in_memory(static_cast<double>(geometry.size()), sizeof(float), file);
  const double reach = 0.5 * geometry.spacing_mm().minCoeff();
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const double off =
        (geometry.point_mm({0, 0, double{1} * planes.plane_of_frame[n]}) - *frames[n].position_mm).norm();
    if (off <= reach) continue;
    throw bad_seg(file, fmt::format("frame {} is displaced by {:.2f} mm against evenly spaced planes", n + 1, off));
  }
}

}  // namespace

std::vector<Vec3> half_units(const std::vector<std::string>& positions) {
  constexpr int kMostExactDigits = 9;
  std::vector<std::array<Digits, 3>> digits;
  int decimals[3] = {-kMostExactDigits, -kMostExactDigits, -kMostExactDigits};
  int significant[3] = {1, 1, 1};
  for (const std::string& position : positions) {
    const std::vector<std::string> parts = split(position, '\\');
    std::array<Digits, 3> of{};
    for (std::size_t axis = 0; axis < std::min<std::size_t>(parts.size(), 3); ++axis) {
      of[axis] = digits_of(parts[axis]);
      decimals[axis] = std::max(decimals[axis], of[axis].decimals);
      significant[axis] = std::max(significant[axis], of[axis].significant);
    }
    digits.push_back(of);
  }
  std::vector<Vec3> out;
  for (const auto& of : digits) {
    Vec3 half;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double by_decimals = std::pow(10.0, -decimals[axis]);
      const double size = std::abs(of[axis].value);
      // An exporter of four significant digits writes -99.38 and -100.6.
      const double by_digits = size > 0 ? std::pow(10.0, std::floor(std::log10(size)) + 1 - significant[axis]) : 0;
      half[static_cast<Eigen::Index>(axis)] = 0.5 * std::max(by_decimals, by_digits);
    }
    out.push_back(half);
  }
  return out;
}

std::vector<int> instance_numbers(const Stack& stack) {
  std::vector<int> out;
  for (const Slice& slice : stack) {
    if (!slice.header->instance_number) return {};
    out.push_back(*slice.header->instance_number);
  }
  const bool rises = std::ranges::is_sorted(out);
  if (!rises && !std::ranges::is_sorted(out, std::greater<>())) return {};
  return std::ranges::adjacent_find(out) == out.end() ? out : std::vector<int>();
}

bool explains(const Stack& slices, double spacing_mm) {
  constexpr double kRoundingError = 1e-6;
  return slack_of(slices, spacing_mm) >= -kRoundingError;
}

double typical_spacing(const Stack& slices) {
  std::vector<double> gap = gaps_of(slices);
  std::ranges::sort(gap);
  const auto first = std::ranges::lower_bound(gap, kSamePlace * gap.back());
  return *(first + (gap.end() - first) / 2);
}

std::optional<SpacingFault> spacing_fault(const Stack& slices, double header_mm) {
  const std::vector<double> gaps = gaps_of(slices);
  const double typical = typical_spacing(slices);
  const auto is_odd = [&](double gap) { return std::abs(gap - typical) > kSpacingTolerance * typical; };
  if (std::ranges::none_of(gaps, is_odd) || rounding_explains(slices, header_mm)) return std::nullopt;
  // Rounded gaps differ from one another; only what rounding cannot explain is a fault.
  for (std::size_t gap = 0; gap < gaps.size(); ++gap) {
    const double rounding = slices[gap].half_unit_mm + slices[gap + 1].half_unit_mm;
    const bool is_rounded = std::lround(gaps[gap] / typical) == 1 && rounding < 0.5 * typical &&
                            std::abs(gaps[gap] - typical) <= kSpacingTolerance * typical + 2 * rounding;
    if (is_odd(gaps[gap]) && !is_rounded) return fault_at(slices, gaps, typical, gap);
  }
  const auto first = std::ranges::find_if(gaps, is_odd);
  return fault_at(slices, gaps, typical, static_cast<std::size_t>(first - gaps.begin()));
}

SliceLine line_through(const std::vector<Vec3>& positions, const std::vector<double>& at) {
  SliceLine ends;
  ends.step_mm = (positions.back() - positions.front()) / (at.back() - at.front());
  ends.point_mm = positions.front() - at.front() * ends.step_mm;
  double worst = 0;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    worst = std::max(worst, (positions[k] - ends.point_mm - at[k] * ends.step_mm).norm());
  }
  const double spacing = (positions.back() - positions.front()).norm() / static_cast<double>(positions.size() - 1);
  if (worst <= kExact * spacing) return ends;
  const double n = static_cast<double>(at.size());
  double mean_at = 0;
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < at.size(); ++k) {
    mean_at += at[k] / n;
    mean += positions[k] / n;
  }
  double square = 0;
  Vec3 product = Vec3::Zero();
  for (std::size_t k = 0; k < at.size(); ++k) {
    square += (at[k] - mean_at) * (at[k] - mean_at);
    product += (at[k] - mean_at) * (positions[k] - mean);
  }
  SliceLine out;
  out.step_mm = product / square;
  out.point_mm = mean - mean_at * out.step_mm;
  return out;
}

std::vector<SliceBlend> blends_of(const Stack& slices) {
  std::vector<double> gaps = gaps_of(slices);
  const double extent = slices.back().height_mm - slices.front().height_mm;
  std::ranges::sort(gaps);
  double finest = gaps.back();
  for (std::size_t n = gaps.size(); n-- > 1;) {
    if (same_gap(gaps[n - 1], gaps[n])) finest = gaps[n];
  }
  constexpr double kRoundingError = 1e-3;
  const double count = std::max(1.0, std::ceil(extent / finest - kRoundingError));
  std::vector<SliceBlend> out;
  std::size_t below = 0;
  for (double k = 0; k <= count; ++k) {
    const double height = slices.front().height_mm + extent * k / count;
    while (below + 2 < slices.size() && slices[below + 1].height_mm <= height) ++below;
    const double gap = slices[below + 1].height_mm - slices[below].height_mm;
    out.push_back({below, std::clamp((height - slices[below].height_mm) / gap, 0.0, 1.0)});
  }
  return out;
}

InputError bad_seg(const ForeignFile& file, const std::string& found) {
  return file.error(found, "export the segmentation again, or save it as NRRD (3D Slicer)");
}

SegPlanes seg_planes(const std::vector<DicomHeader>& frames, const ForeignFile& file) {
  check_frames(frames, file);
  SegPlanes out;
  const DicomHeader& first = frames.front();
  const Vec3 normal = first.normal();
  std::vector<double> heights;
  for (const DicomHeader& frame : frames) heights.push_back(normal.dot(*frame.position_mm));
  const double lowest = std::ranges::min(heights);
  const double step = plane_step(heights, first.slice_spacing_mm, file);
  std::map<int, Vec3> positions;
  for (std::size_t n = 0; n < frames.size(); ++n) {
    out.plane_of_frame.push_back(static_cast<int>(std::lround((heights[n] - lowest) / step)));
    positions.emplace(out.plane_of_frame.back(), *frames[n].position_mm);
  }
  out.geometry = geometry_of(first);
  out.geometry.dims.z() = positions.rbegin()->first + 1;
  out.geometry.step_mm.col(2) *= step;
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
  check_planes(out, frames, file);
  return out;
}

}  // namespace reamsim::ct
