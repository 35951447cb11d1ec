// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "sim/base/text.h"
#include "sim/scan/dicom.h"
#include "sim/scan/dicom_values.h"

namespace reamsim::ct {

namespace {

using Keywords = std::vector<std::string>;

/// Numbers by size, other texts by their characters.
struct ByValue {
  bool operator()(const std::string& a, const std::string& b) const {
    char *end_a = nullptr, *end_b = nullptr;
    const double x = std::strtod(a.c_str(), &end_a), y = std::strtod(b.c_str(), &end_b);
    const bool numbers = !a.empty() && !b.empty() && *end_a == '\0' && *end_b == '\0';
    return numbers && x != y ? x < y : a < b;
  }
  bool operator()(const Keywords& a, const Keywords& b) const {
    return std::ranges::lexicographical_compare(a, b, *this);
  }
};

std::vector<DicomVolume> divide(const Stack& sorted, const Keywords& keywords) {
  std::map<Keywords, Stack, ByValue> groups;
  for (const Slice& slice : sorted) {
    Keywords values;
    for (const std::string& keyword : keywords) values.push_back(slice.header->tag(keyword));
    groups[values].push_back(slice);
  }
  std::vector<DicomVolume> out;
  for (auto& [values, slices] : groups) {
    std::string label;
    for (std::size_t n = 0; n < values.size(); ++n) label += (n == 0 ? "" : "#") + keywords[n] + "=" + values[n];
    out.push_back({label, std::move(slices)});
  }
  return out;
}

/// Elements with at least two values, and on average two slices of each.
Keywords candidates_in(const Stack& sorted) {
  Keywords out;
  for (const SeparatingTag& tag : separating_tags()) {
    std::set<std::string> values;
    for (const Slice& slice : sorted) values.insert(slice.header->tag(tag.keyword));
    if (values.size() >= 2 && 2 * values.size() <= sorted.size()) out.emplace_back(tag.keyword);
  }
  return out;
}

std::size_t least_slices(const std::vector<DicomVolume>& volumes) {
  return std::ranges::min(volumes, {}, [](const DicomVolume& v) { return v.slices.size(); }).slices.size();
}

/// Calls `accept` for the division by each element, then by each two; the first that it accepts.
template <class Accept>
std::optional<std::vector<DicomVolume>> first_division(const Stack& sorted, const Accept& accept) {
  const Keywords candidates = candidates_in(sorted);
  for (const std::string& keyword : candidates) {
    std::vector<DicomVolume> volumes = divide(sorted, {keyword});
    if (accept(volumes)) return volumes;
  }
  for (std::size_t a = 0; a < candidates.size(); ++a) {
    for (std::size_t b = a + 1; b < candidates.size(); ++b) {
      std::vector<DicomVolume> volumes = divide(sorted, {candidates[a], candidates[b]});
      if (accept(volumes)) return volumes;
    }
  }
  return std::nullopt;
}

bool has_single_places(const DicomVolume& volume) {
  return same_place(volume.slices) < 0;
}

std::string range_of(const Stack& slices) {
  const bool frames = slices.front().header->frame >= 0;
  const auto number = [&](const Slice& s) { return frames ? s.header->frame + 1 : *s.header->instance_number; };
  const auto [least, most] = std::ranges::minmax(slices, {}, number);
  return fmt::format("{} {} to {}", frames ? "frames" : "InstanceNumber", number(least), number(most));
}

/// The first slices of all positions, the second ones, and so on, by instance number or frame.
std::optional<std::vector<DicomVolume>> divide_by_order(Stack sorted) {
  const auto is_numbered = [](const Slice& s) { return s.header->frame >= 0 || s.header->instance_number; };
  if (!std::ranges::all_of(sorted, is_numbered)) return std::nullopt;
  const double near_mm = kSamePlace * typical_spacing(sorted);
  std::vector<DicomVolume> out;
  for (std::size_t first = 0, last = 0; first < sorted.size(); first = last) {
    while (last < sorted.size() && sorted[last].height_mm - sorted[first].height_mm <= near_mm) ++last;
    const auto from = sorted.begin() + static_cast<std::ptrdiff_t>(first);
    std::stable_sort(from, sorted.begin() + static_cast<std::ptrdiff_t>(last), [](const Slice& a, const Slice& b) {
      return std::tuple(a.header->instance_number.value_or(0), a.header->frame) <
             std::tuple(b.header->instance_number.value_or(0), b.header->frame);
    });
    if (first == 0) out.resize(last);
    if (last - first != out.size()) return std::nullopt;
    for (std::size_t n = 0; n < out.size(); ++n) out[n].slices.push_back(sorted[first + n]);
  }
  if (out.size() < 2 || least_slices(out) < 2) return std::nullopt;
  for (DicomVolume& volume : out) volume.label = range_of(volume.slices);
  return out;
}

/// Whether two of the volumes lie in one range of heights, so that they are no parts of one volume.
bool any_overlap(std::vector<DicomVolume> volumes) {
  std::ranges::sort(volumes, {}, [](const DicomVolume& v) { return v.slices.front().height_mm; });
  for (std::size_t n = 1; n < volumes.size(); ++n) {
    const Stack& low = volumes[n - 1].slices;
    const Stack& high = volumes[n].slices;
    if (low.size() > 2 && low[low.size() - 2].height_mm > high[1].height_mm) return true;
  }
  return false;
}

/// Volumes whose slices alternate: each is evenly spaced by itself, together they are not.
std::optional<std::vector<DicomVolume>> divide_alternating(const Stack& sorted) {
  return first_division(sorted, [](const std::vector<DicomVolume>& volumes) {
    constexpr std::size_t kLeastSlices = 3;
    if (least_slices(volumes) < kLeastSlices) return false;
    const auto is_even = [](const DicomVolume& v) { return has_single_places(v) && !spacing_fault(v.slices, 0); };
    return std::ranges::all_of(volumes, is_even) && any_overlap(volumes);
  });
}

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

/// Elements that differ within a volume as they would if two volumes were mixed: "ConvolutionKernel B30f and B60s".
/// Empty: none.
std::string mixed_elements(const Stack& sorted) {
  constexpr std::string_view kOfVolumes =
      "TemporalPositionIdentifier TemporalPositionIndex NominalPercentageOfCardiacPhase EchoNumbers ConvolutionKernel "
      "KVP";
  for (const std::string& keyword : split(kOfVolumes, ' ')) {
    std::set<std::string> values;
    std::size_t runs = 0;
    for (std::size_t n = 0; n < sorted.size(); ++n) {
      const std::string value = sorted[n].header->tag(keyword);
      values.insert(value);
      if (n == 0 || value != sorted[n - 1].header->tag(keyword)) ++runs;
    }
    // Blocks of slices, as of two ranges of a scan, have one run each.
    if (values.size() < 2 || runs <= values.size()) continue;
    return keyword + " " + *values.begin() + " and " + *std::next(values.begin());
  }
  return "";
}

}  // namespace

std::ptrdiff_t same_place(const Stack& sorted) {
  if (sorted.size() < 2) return -1;
  const double near_mm = kSamePlace * typical_spacing(sorted);
  for (std::size_t n = 1; n < sorted.size(); ++n) {
    if (sorted[n].height_mm - sorted[n - 1].height_mm <= near_mm) return static_cast<std::ptrdiff_t>(n);
  }
  return -1;
}

int sort_slices(Stack& stack) {
  const ScanGeometry& first = stack.front().geometry;
  const Vec3 normal = first.step_mm.col(0).cross(first.step_mm.col(1)).normalized();
  std::vector<std::string> positions;
  for (const Slice& slice : stack) positions.push_back(slice.header->position_text);
  const std::vector<Vec3> half = half_units(positions);
  for (std::size_t n = 0; n < stack.size(); ++n) {
    stack[n].height_mm = normal.dot(stack[n].geometry.origin_mm);
    stack[n].half_unit_mm = normal.cwiseAbs().dot(half[n]);
    stack[n].rounding_mm = half[n].norm();
  }
  std::ranges::stable_sort(stack, {}, &Slice::height_mm);
  Stack kept;
  std::set<std::string> instances;
  for (Slice& slice : stack) {
    const std::string& instance = slice.header->instance_uid;
    // Broken exporters give several slices one UID.
    const std::string name = instance + fmt::format("@{:.3f}", slice.height_mm);
    if (instance.empty() || instances.insert(name).second) kept.push_back(std::move(slice));
  }
  const int copies = static_cast<int>(stack.size() - kept.size());
  stack = std::move(kept);
  return copies;
}

std::vector<DicomVolume> volumes_in(const Stack& sorted) {
  const std::vector<DicomVolume> whole{{"", sorted}};
  if (sorted.size() < 2) return whole;
  if (same_place(sorted) < 0) {
    if (!spacing_fault(sorted, 0)) return whole;
    return divide_alternating(sorted).value_or(whole);
  }
  for (const std::size_t least : {2U, 1U}) {
    auto out = first_division(sorted, [least](const std::vector<DicomVolume>& volumes) {
      return least_slices(volumes) >= least && std::ranges::all_of(volumes, has_single_places);
    });
    if (out) return *out;
  }
  return divide_by_order(sorted).value_or(whole);
}

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
  std::vector<std::string> out = files;
  std::erase_if(out, [&](const std::string& file) { return !names.contains(name_of(file)); });
  return out;
}

[[noreturn]] void refuse_spacing(const SpacingFault& fault, const Stack& stack, const std::vector<Stack>& groups,
                                 const std::vector<std::string>& skipped) {
  const Slice& low = stack[fault.slice - 1];
  const Slice& high = stack[fault.slice];
  const std::string files = low.path() + " and " + high.path();
  const std::string resample = "bone.ct.uneven: resample";
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
