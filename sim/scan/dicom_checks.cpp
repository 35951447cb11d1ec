// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>

#include "sim/scan/dicom_stack.h"

namespace reamsim::ct {

namespace {

constexpr const char* kUnevenKey = "bone.ct.uneven";
/// Largest displacement of a slice from the line through all of them, beside the rounding of its position.
constexpr double kStraight_pixels = 0.5;
constexpr double kStraight_steps = 0.05;
/// Deviation from even spacing, as a fraction of it, that is warned of.
constexpr double kWarnedDeviation = 0.005;

/// Names an image of another group, or a skipped file, that may be the missing slice.
std::string hint_at_missing_slice(const Slice& low, const Slice& high, const std::vector<Stack>& groups,
                                  const std::vector<std::string>& skipped) {
  for (std::size_t g = 1; g < groups.size(); ++g) {
    for (const Slice& slice : groups[g]) {
      const double height_mm = low.header->normal().dot(slice.geometry.origin_mm);
      if (height_mm > low.height_mm && height_mm < high.height_mm) {
        return "; " + slice.path() + " lies there and has " + difference(slice.geometry, low.geometry);
      }
    }
  }
  return skipped.empty() ? "" : "; " + skipped.front() + " was skipped";
}

/// A file's name with "#" for each run of digits.
std::string name_pattern(const std::string& path) {
  std::string out;
  for (const char c : std::filesystem::path(path).filename().string()) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit) out += c;
    if (digit && !out.ends_with('#')) out += '#';
  }
  return out;
}

/// "instances 1 to 2"
std::string instances_text(int first, int last) {
  return first == last ? fmt::format("instance {}", first) : fmt::format("instances {} to {}", first, last);
}

/// How many images the acquisition of the stack has, as the header says; 0: unknown, or all are here.
int images_said(const Stack& stack, const DicomSeries& series) {
  constexpr const char* kAcquisition = "AcquisitionNumber";
  const DicomHeader& first = *stack.front().header;
  const auto here = std::ranges::count_if(
      series.images, [&](const DicomHeader& image) { return image.tag(kAcquisition) == first.tag(kAcquisition); });
  return first.images_in_acquisition > here ? first.images_in_acquisition : 0;
}

}  // namespace

std::string difference(const ScanGeometry& other, const ScanGeometry& usual) {
  if (other.dims != usual.dims) {
    return fmt::format("{}x{} pixels; the other slices have {}x{}", other.dims.x(), other.dims.y(), usual.dims.x(),
                       usual.dims.y());
  }
  const Vec3 a = other.spacing_mm();
  const Vec3 b = usual.spacing_mm();
  if ((a - b).head<2>().cwiseAbs().maxCoeff() > kSameAxes * b.head<2>().minCoeff()) {
    return fmt::format("pixels of {:.4g}x{:.4g} mm; those of the other slices are {:.4g}x{:.4g} mm", a.x(), a.y(),
                       b.x(), b.y());
  }
  return "an orientation different from that of the other slices";
}

void check_values(const Stack& stack) {
  const auto grey =
      std::ranges::find(stack, "MONOCHROME1", [](const Slice& slice) { return slice.header->photometric; });
  if (grey != stack.end()) {
    throw InputError({grey->path()}, kScanKey, "MONOCHROME1: its grey values are inverted and are not HU",
                     "expected MONOCHROME2, as CT slices have; export the original series");
  }
  // Slices without a rescale among slices with one would be read 1024 HU too dense, or so.
  const auto rescales = [](const Slice& slice) { return slice.header->rescales; };
  const auto without = std::ranges::find_if_not(stack, rescales);
  if (without == stack.end() || std::ranges::none_of(stack, rescales)) return;
  throw InputError({without->path()}, kScanKey,
                   "has no rescale intercept and slope (0028,1052 and 0028,1053), as other slices of its series have",
                   "export the original series: the values of this slice are not HU");
}

std::vector<std::string> named_like_slices(const Stack& stack, const std::vector<std::string>& files) {
  std::set<std::pair<std::filesystem::path, std::string>> names;
  const auto name_of = [](const std::string& path) {
    return std::pair(std::filesystem::path(path).parent_path(), name_pattern(path));
  };
  for (const Slice& slice : stack) names.insert(name_of(slice.path()));
  std::vector<std::string> out;
  std::ranges::copy_if(files, std::back_inserter(out),
                       [&](const std::string& f) { return names.contains(name_of(f)); });
  return out;
}

[[noreturn]] void refuse_spacing(const SpacingFault& fault, const Stack& stack, const std::vector<Stack>& groups,
                                 const std::vector<std::string>& skipped) {
  const Slice& low = stack[fault.slice - 1];
  const Slice& high = stack[fault.slice];
  const std::string files = low.path() + " and " + high.path();
  const std::string resample = std::string(kUnevenKey) + ": resample";
  if (fault.kind == SpacingFault::Kind::change) {
    const std::string numbers =
        fault.missing > 0 ? "; instance numbers jump there as well, so slices may be missing from there on" : "";
    throw InputError({high.path()}, kScanKey,
                     fmt::format("slice spacing changes from {:.3f} to {:.3f} mm at slice {} of {}: {}",
                                 fault.before_mm, fault.gap_mm, fault.slice + 1, stack.size(), files) +
                         numbers,
                     "set " + resample + " to interpolate evenly spaced slices, or give a series of one spacing");
  }
  const std::string found = fmt::format("slice spacing is {:.3f} mm; most slices are {:.3f} mm apart: {}", fault.gap_mm,
                                        fault.before_mm, files);
  const std::string between = fault.missing == 1  ? "a slice is missing between them"
                              : fault.missing > 1 ? std::to_string(fault.missing) + " slices are missing between them"
                                                  : "expected evenly spaced slices, or " + resample;
  throw InputError({high.path()}, kScanKey, found, between + hint_at_missing_slice(low, high, groups, skipped));
}

void check_straight(const Stack& stack, const SliceLine& line, const std::vector<double>& at, Diagnostics& report) {
  const double side = stack.front().geometry.step_mm.leftCols<2>().colwise().norm().minCoeff();
  const double step = (line.step_mm * (at.back() - at.front())).norm() / static_cast<double>(stack.size() - 1);
  double worst = 0;
  std::size_t worst_slice = 0;
  for (std::size_t k = 0; k < stack.size(); ++k) {
    const Slice& slice = stack[k];
    const double off = (slice.geometry.origin_mm - line.point_mm - at[k] * line.step_mm).norm();
    if (off > kStraight_pixels * std::max(side, kStraight_steps * step) + slice.rounding_mm) {
      throw InputError({slice.path()}, kScanKey,
                       fmt::format("the slice is displaced by {:.2f} mm against its neighbours", off),
                       "export the original series");
    }
    if (off > worst) {
      worst = off;
      worst_slice = k;
    }
  }
  if (worst <= kWarnedDeviation * step) return;
  report.warn(stack[worst_slice].path() +
              fmt::format(": slice positions are rounded or uneven: they deviate by up to {:.3g} mm from a spacing of "
                          "{:.4f} mm, which is used",
                          worst, step));
}

void warn_of_missing_ends(const Stack& stack, const DicomSeries& series, Diagnostics& report) {
  const std::vector<int> numbers = instance_numbers(stack);
  if (numbers.size() < 2) return;
  const bool rises = numbers.front() < numbers.back();
  const auto [least, most] = std::minmax(numbers.front(), numbers.back());
  const Slice& first = rises ? stack.front() : stack.back();
  const Slice& last = rises ? stack.back() : stack.front();
  std::set<int> present;
  for (const DicomHeader& image : series.images) present.insert(image.instance_number.value_or(0));
  const auto is_missing = [&](int number) { return !present.contains(number); };
  std::string found;
  int lowest = 1;
  while (lowest < least && !is_missing(lowest)) ++lowest;
  int below = least - 1;
  while (below >= lowest && !is_missing(below)) --below;
  // The numbers of a volume among others may begin anywhere.
  const bool elsewhere = stack.size() < series.images.size() && below - lowest >= static_cast<int>(stack.size());
  if (lowest <= below && !elsewhere) found = instances_text(lowest, below) + " before " + first.path();
  const int said = images_said(stack, series);
  if (said > most && said > *present.rbegin()) {
    found += (found.empty() ? "" : ", ") + instances_text(*present.rbegin() + 1, said) + " after " + last.path();
  }
  if (!found.empty()) {
    report.warn("DICOM slices are missing at the ends of the series: " + found +
                "; the bone may be cut off there, unless the scanner numbers its images otherwise");
  } else if (said > 0) {
    report.warn(
        fmt::format("the DICOM header says {} images in this acquisition, and {} are here; the bone may be cut "
                    "off at an end",
                    said, stack.size()));
  }
}

void warn_of_values(const Stack& stack, Diagnostics& report) {
  const auto is_lossy = [](const Slice& slice) { return !slice.header->lossy.empty(); };
  const auto lossy = std::ranges::find_if(stack, is_lossy);
  if (lossy != stack.end()) {
    report.warn(lossy->path() +
                fmt::format(": {} of {} slices were compressed with loss ({}); their values differ from the scanner's: "
                            "edges and densities are less exact",
                            std::ranges::count_if(stack, is_lossy), stack.size(), lossy->header->lossy));
  }
  const auto is_assumed = [](const Slice& slice) { return !slice.header->assumed.empty(); };
  const auto assumed = std::ranges::find_if(stack, is_assumed);
  if (assumed != stack.end()) {
    report.warn(assumed->path() + fmt::format(": {}; so in {} of {} slices", assumed->header->assumed,
                                              std::ranges::count_if(stack, is_assumed), stack.size()));
  }
  const std::string mixed = mixed_elements(stack);
  if (!mixed.empty()) {
    report.warn(stack.front().path() + ": the slices of the series alternate between " + mixed +
                ", as two volumes that are mixed; choose one with bone.ct.series: SERIES#TAG=VALUE");
  }
}

}  // namespace reamsim::ct
