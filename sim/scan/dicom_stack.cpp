// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>
#include <utility>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/image_io.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

/// Deviation from the typical slice spacing, as a fraction of it, from which a slice counts as missing.
constexpr double kSpacingTolerance = 0.05;
/// Slices closer than this fraction of the typical spacing have the same position.
constexpr double kSamePlace = 0.01;
/// Axes of slices are equal to within this fraction of the side of a pixel.
constexpr double kSameAxes = 2e-3;
/// Largest displacement of a slice from the line through the first and the last one.
constexpr double kStraight_pixels = 0.5;

struct Slice {
  const DicomHeader* header = nullptr;
  ScanGeometry geometry;  ///< from the file; its slice thickness may differ from the slice spacing
  std::string pixel_type;
  double height_mm = 0;  ///< of its origin along the slice normal

  [[nodiscard]] const std::string& path() const { return header->path; }
};

using Stack = std::vector<Slice>;

/// Slices that form a volume, in the order of their positions.
struct DicomStack {
  std::vector<std::string> path;
  std::string pixel_type;
  ScanGeometry geometry;
  double kvp = 0;  ///< of the first slice; 0: unknown
};

/// False for screenshots, dose reports and multi-frame files.
bool may_be_slice(const DicomHeader& header) {
  return header.frames <= 1 && header.photometric.starts_with("MONOCHROME") && header.position_mm;
}

[[noreturn]] void refuse_image(const DicomHeader& header, const std::string& key) {
  const SourceLocation where{header.path};
  if (header.frames > 1) {
    throw InputError(where, key, fmt::format("a multi-frame DICOM file ({} frames)", header.frames),
                     "convert it to NRRD or NIfTI (3D Slicer, dcm2niix), or export single slices");
  }
  if (!header.position_mm) {
    throw InputError(where, key, "an image without a position (0020,0032)", "export the original series");
  }
  throw InputError(where, key, "pixels of kind '" + header.photometric + "'",
                   "expected MONOCHROME2, as CT slices have; export the original series");
}

/// The images that may be slices. The others are skipped with a warning and added to `skipped`.
std::vector<const DicomHeader*> slices_among(const DicomSeries& series, std::vector<std::string>& skipped,
                                             const std::string& key, Diagnostics& report) {
  std::vector<const DicomHeader*> out;
  std::vector<std::string> others;
  for (const DicomHeader& header : series.images) {
    if (may_be_slice(header)) {
      out.push_back(&header);
    } else {
      others.push_back(header.path);
    }
  }
  if (out.empty()) refuse_image(series.images.front(), key);
  if (!others.empty()) {
    report.warn("images of the DICOM series skipped because they are not slices: " + std::to_string(others.size()) +
                ", the first is " + others.front());
    skipped.insert(skipped.begin(), others.begin(), others.end());
  }
  return out;
}

void check_grey_values(const Stack& stack, const std::string& key) {
  for (const Slice& slice : stack) {
    if (slice.header->photometric != "MONOCHROME1") continue;
    throw InputError({slice.path()}, key, "MONOCHROME1: its grey values are inverted and are not HU",
                     "expected MONOCHROME2, as CT slices have; export the original series");
  }
}

/// Slices without a rescale among slices with one would be read 1024 HU too dense, or so.
void check_rescale(const Stack& stack, const std::string& key) {
  const auto rescales = [](const Slice& slice) { return slice.header->rescales; };
  if (std::ranges::none_of(stack, rescales)) return;
  const auto without = std::ranges::find_if_not(stack, rescales);
  if (without == stack.end()) return;
  throw InputError({without->path()}, key,
                   "has no rescale intercept and slope (0028,1052 and 0028,1053), as other slices of its series have",
                   "export the original series: the values of this slice are not HU");
}

bool belong_together(const ScanGeometry& a, const ScanGeometry& b) {
  const double side = a.step_mm.leftCols<2>().colwise().norm().minCoeff();
  return a.dims == b.dims && (a.step_mm - b.step_mm).leftCols<2>().cwiseAbs().maxCoeff() <= kSameAxes * side;
}

/// Groups of slices of one size, spacing and orientation, the largest group first.
std::vector<Stack> groups_of(const std::vector<const DicomHeader*>& slices, const std::string& key) {
  std::vector<std::string> files;
  for (const DicomHeader* header : slices) files.push_back(header->path);
  std::vector<SliceFacts> facts = read_slice_facts(files, key);
  std::vector<Stack> groups;
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const Slice slice{slices[n], std::move(facts[n].geometry), std::move(facts[n].pixel_type), 0};
    const auto group = std::ranges::find_if(
        groups, [&](const Stack& g) { return belong_together(g.front().geometry, slice.geometry); });
    if (group == groups.end()) {
      groups.push_back({slice});
    } else {
      group->push_back(slice);
    }
  }
  std::ranges::stable_sort(groups, [](const Stack& a, const Stack& b) { return a.size() > b.size(); });
  return groups;
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

/// Removes copies of a slice (the same instance). Two different slices at one position are an error.
void remove_duplicates(Stack& stack, double typical_mm, const std::string& key, Diagnostics& report) {
  Stack kept{stack.front()};
  int copies = 0;
  for (std::size_t n = 1; n < stack.size(); ++n) {
    const Slice& before = kept.back();
    const bool same_place = stack[n].height_mm - before.height_mm <= kSamePlace * typical_mm;
    if (!same_place) {
      kept.push_back(stack[n]);
      continue;
    }
    const std::string& instance = stack[n].header->instance_uid;
    if (instance.empty() || instance != before.header->instance_uid) {
      throw InputError({stack[n].path()}, key, "has the same position as " + before.path(),
                       "give each slice once; split a series with two volumes into two folders");
    }
    ++copies;
  }
  if (copies > 0) report.warn("copies of DICOM slices skipped: " + std::to_string(copies));
  stack = std::move(kept);
}

/// Median distance of neighbours, without those at the same position.
double typical_distance(const Stack& stack) {
  std::vector<double> gap;
  for (std::size_t n = 1; n < stack.size(); ++n) gap.push_back(stack[n].height_mm - stack[n - 1].height_mm);
  std::ranges::sort(gap);
  const auto first = std::ranges::lower_bound(gap, kSamePlace * gap.back());
  return *(first + (gap.end() - first) / 2);
}

/// Names an image of another group, or a skipped file, that may be the missing slice.
std::string hint_at_missing_slice(double low_mm, double high_mm, const Vec3& normal, const ScanGeometry& usual,
                                  const std::vector<Stack>& groups, const std::vector<std::string>& skipped) {
  for (std::size_t g = 1; g < groups.size(); ++g) {
    for (const Slice& slice : groups[g]) {
      const double height = normal.dot(slice.geometry.origin_mm);
      if (height > low_mm && height < high_mm) {
        return "; " + slice.path() + " lies there and has " + difference(slice.geometry, usual);
      }
    }
  }
  return skipped.empty() ? "" : "; " + skipped.front() + " was skipped";
}

void check_distances(const std::vector<Stack>& groups, double typical_mm, const Vec3& normal,
                     const std::vector<std::string>& skipped, const std::string& key) {
  const Stack& stack = groups.front();
  for (std::size_t k = 1; k < stack.size(); ++k) {
    const double gap = stack[k].height_mm - stack[k - 1].height_mm;
    if (std::abs(gap - typical_mm) <= kSpacingTolerance * typical_mm) continue;
    const std::string found =
        fmt::format("slice spacing is {:.3f} mm; most slices are {:.3f} mm apart: ", gap, typical_mm) +
        stack[k - 1].path() + " and " + stack[k].path();
    const long missing = std::lround(gap / typical_mm) - 1;
    const std::string between = missing == 1  ? "a slice is missing between them"
                                : missing > 1 ? std::to_string(missing) + " slices are missing between them"
                                              : "expected evenly spaced slices";
    throw InputError({stack[k].path()}, key, found,
                     between + hint_at_missing_slice(stack[k - 1].height_mm, stack[k].height_mm, normal,
                                                     stack.front().geometry, groups, skipped));
  }
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

/// The files that lie beside the slices and are named like them: slices that are damaged beyond recognition.
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

/// A slice that is missing at an end leaves no gap.
void refuse_damaged_slices(const std::vector<std::string>& damaged, const std::string& key) {
  if (damaged.empty()) return;
  const std::string others = damaged.size() == 1 ? "" : fmt::format(", as {} more", damaged.size() - 1);
  throw InputError({damaged.front()}, key,
                   "cannot be read as a DICOM slice" + others + ", but is named like the slices of the series",
                   "give a complete file, or move it out of the folder if it is no slice of this series");
}

void check_straight(const Stack& stack, const Vec3& step_mm, const std::string& key) {
  const double side = stack.front().geometry.step_mm.leftCols<2>().colwise().norm().minCoeff();
  for (std::size_t k = 0; k < stack.size(); ++k) {
    const Vec3 due = stack.front().geometry.origin_mm + static_cast<double>(k) * step_mm;
    const double off = (stack[k].geometry.origin_mm - due).norm();
    if (off <= kStraight_pixels * std::max(side, kSpacingTolerance * step_mm.norm())) continue;
    throw InputError({stack[k].path()}, key,
                     fmt::format("the slice is displaced by {:.2f} mm against its neighbours", off),
                     "export the original series");
  }
}

void warn_of_other_groups(const std::vector<Stack>& groups, Diagnostics& report) {
  std::size_t count = 0;
  for (std::size_t g = 1; g < groups.size(); ++g) count += groups[g].size();
  if (count == 0) return;
  const Slice& other = groups[1].front();
  report.warn("images of the DICOM series skipped: " + std::to_string(count) + ", the first is " + other.path() +
              " and has " + difference(other.geometry, groups[0].front().geometry));
}

void check_count(const std::vector<Stack>& groups, const std::string& key) {
  const Stack& stack = groups.front();
  if (stack.size() < 2) {
    throw InputError({stack.front().path()}, key, "one DICOM slice",
                     "expected the slices of a volume, at least two of one size and orientation");
  }
  if (groups.size() == 1 || groups[1].size() < stack.size()) return;
  const Slice& second = groups[1].front();
  throw InputError({second.path()}, key,
                   "the series holds two stacks of " + std::to_string(stack.size()) + " slices: this one has " +
                       difference(second.geometry, stack.front().geometry),
                   "move the stack that you want into a separate folder");
}

/// Sorts the slices of a series. Skips, with a warning, images of another size, spacing or orientation (a scout) and
/// copies of a slice. Files of `folder` that cannot be read may be missing slices.
/// Throws InputError with the file: truncated, damaged, MONOCHROME1, multi-frame, missing, duplicate, displaced.
DicomStack stack_slices(const DicomSeries& series, const DicomFolder& folder, const std::string& key,
                        Diagnostics& report) {
  std::vector<std::string> skipped = folder.damaged;
  const std::vector<const DicomHeader*> slices = slices_among(series, skipped, key, report);
  std::vector<Stack> groups = groups_of(slices, key);
  check_count(groups, key);
  Stack& stack = groups.front();
  check_grey_values(stack, key);
  check_rescale(stack, key);
  const ScanGeometry first = stack.front().geometry;
  const Vec3 normal = first.step_mm.col(0).cross(first.step_mm.col(1)).normalized();
  for (Slice& slice : stack) slice.height_mm = normal.dot(slice.geometry.origin_mm);
  std::ranges::stable_sort(stack, {}, &Slice::height_mm);
  const double typical_mm = typical_distance(stack);
  remove_duplicates(stack, typical_mm, key, report);
  check_count(groups, key);
  std::vector<std::string> unreadable = folder.damaged;
  unreadable.insert(unreadable.end(), folder.others.begin(), folder.others.end());
  const std::vector<std::string> damaged = named_like_slices(stack, unreadable);
  skipped.insert(skipped.begin(), damaged.begin(), damaged.end());
  check_distances(groups, typical_mm, normal, skipped, key);
  refuse_damaged_slices(damaged, key);
  warn_of_other_groups(groups, report);

  DicomStack out;
  for (const Slice& slice : stack) out.path.push_back(slice.path());
  out.pixel_type = stack.front().pixel_type;
  out.kvp = stack.front().header->kvp;
  out.geometry = stack.front().geometry;
  out.geometry.dims.z() = static_cast<int>(stack.size());
  // From the positions, not the slice thickness in the header: a tilted gantry is a shear.
  out.geometry.step_mm.col(2) =
      (stack.back().geometry.origin_mm - stack.front().geometry.origin_mm) / static_cast<double>(stack.size() - 1);
  check_straight(stack, out.geometry.step_mm.col(2), key);
  if (!is_plausible(out.geometry)) {
    throw InputError({out.path.front()}, key, "voxel spacing or axes are degenerate", "export the original series");
  }
  return out;
}

class DicomScan : public ScanSource {
 public:
  DicomScan(const std::string& folder, const std::string& key, const DicomChoice& choice, Diagnostics& report)
      : folder_(folder), key_(key) {
    const DicomFolder found = find_dicom_series(folder, key, report);
    const DicomSeries& series = choose_series(found, choice, folder, report);
    if (series.modality != "CT") {
      report.warn(folder + ": modality " + (series.modality.empty() ? "unknown" : series.modality) +
                  ", not CT; thresholds and densities are wrong unless its values are HU");
    }
    stack_ = stack_slices(series, found, key, report);
    name_ = series.description.empty() ? "" : " \"" + series.description + "\"";
    check_fits_in_memory(static_cast<double>(stack_.geometry.size()), sizeof(float), folder_, key_);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return stack_.geometry; }
  [[nodiscard]] std::string description() const override {
    return "DICOM series" + name_ + " of " + std::to_string(stack_.path.size()) + " files, " + stack_.pixel_type;
  }
  [[nodiscard]] bool is_unsigned() const override { return stack_.pixel_type.starts_with("uint"); }
  [[nodiscard]] double kvp() const override { return stack_.kvp; }

  [[nodiscard]] Scan read(const IndexBox& box) const override {
    const IndexBox in_slice{{box.start.x(), box.start.y(), 0}, {box.size.x(), box.size.y(), 1}};
    const auto first = stack_.path.begin() + box.start.z();
    return {part_of(stack_.geometry, box), read_slices({first, first + box.size.z()}, in_slice, key_)};
  }

 private:
  std::string folder_;
  std::string key_;
  std::string name_;
  DicomStack stack_;
};

}  // namespace

std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key,
                                              const DicomChoice& choice, Diagnostics& report) {
  return std::make_unique<DicomScan>(path, key, choice, report);
}

}  // namespace reamsim::ct
