// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <map>
#include <set>

#include "sim/scan/dicom_stack.h"
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
  const auto [least, most] = std::minmax_element(slices.begin(), slices.end(),
                                                 [&](const Slice& a, const Slice& b) { return number(a) < number(b); });
  return (frames ? "frames " : "InstanceNumber ") + std::to_string(number(*least)) + " to " +
         std::to_string(number(*most));
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

std::string mixed_elements(const Stack& sorted) {
  static constexpr const char* kOfVolumes[] = {"TemporalPositionIdentifier",
                                               "TemporalPositionIndex",
                                               "NominalPercentageOfCardiacPhase",
                                               "EchoNumbers",
                                               "ConvolutionKernel",
                                               "KVP"};
  for (const char* keyword : kOfVolumes) {
    std::set<std::string> values;
    std::size_t runs = 0;
    for (std::size_t n = 0; n < sorted.size(); ++n) {
      const std::string value = sorted[n].header->tag(keyword);
      values.insert(value);
      if (n == 0 || value != sorted[n - 1].header->tag(keyword)) ++runs;
    }
    // Blocks of slices, as of two ranges of a scan, have one run each.
    if (values.size() < 2 || runs <= values.size()) continue;
    return std::string(keyword) + " " + *values.begin() + " and " + *std::next(values.begin());
  }
  return "";
}

}  // namespace reamsim::ct
