// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom.h"

#include <fmt/core.h>

#include <cmath>
#include <numeric>
#include <set>

#include "sim/base/text.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

/// Slices that form a volume, in the order of their positions.
struct DicomStack {
  std::vector<SliceSource> slices;
  std::vector<SliceBlend> blends;  ///< of the slices of the volume, where it is interpolated between `slices`
  ScanGeometry geometry;
  std::string pixel_type;  ///< of the first slice, as its tube voltage
  double kvp = 0;          ///< 0: unknown
};

/// The element of a slice's place that is missing or no geometry; "" if all are there.
std::string unplaced_by(const DicomHeader& header) {
  if (!header.position_mm) return "position (0020,0032)";
  if (!header.axes || header.axes->colwise().squaredNorm().minCoeff() < 0.5) return "orientation (0020,0037)";
  if (!header.pixel_spacing_mm || !(header.pixel_spacing_mm->minCoeff() > 0)) return "pixel spacing (0028,0030)";
  return "";
}

/// False for screenshots, dose reports and multi-frame files that do not say where their frames lie.
bool may_be_slice(const DicomHeader& header) {
  return (header.frames <= 1 || header.frame >= 0) && header.photometric.starts_with("MONOCHROME") &&
         unplaced_by(header).empty();
}

[[noreturn]] void refuse_image(const DicomHeader& header) {
  const ForeignFile file{header.path, kScanKey};
  if (header.frames > 1 && header.frame < 0) {
    throw file.error(
        fmt::format("a multi-frame DICOM file ({} frames) without functional groups that say where each frame "
                    "lies",
                    header.frames),
        "convert it to NRRD or NIfTI (3D Slicer, dcm2niix), or export single slices");
  }
  if (const std::string missing = unplaced_by(header); !missing.empty()) {
    throw file.error("an image without a valid " + missing, "export the original series");
  }
  throw file.error("pixels of kind '" + header.photometric + "'",
                   "expected MONOCHROME2, as CT slices have; export the original series");
}

/// The images that may be slices. The others are skipped with a warning and added to `skipped`.
std::vector<const DicomHeader*> slices_among(const DicomSeries& series, std::vector<std::string>& skipped,
                                             Diagnostics& report) {
  std::vector<const DicomHeader*> out;
  std::vector<std::string> others;
  std::string reason;
  for (const DicomHeader& header : series.images) {
    if (may_be_slice(header)) {
      out.push_back(&header);
    } else {
      if (others.empty() && header.photometric.starts_with("MONOCHROME")) reason = unplaced_by(header);
      others.push_back(header.path);
    }
  }
  if (out.empty()) refuse_image(series.images.front());
  if (!others.empty()) {
    report.warn("images of the DICOM series skipped because they are not slices: " + std::to_string(others.size()) +
                ", the first is " + others.front() + (reason.empty() ? "" : ", which has no valid " + reason));
    skipped.insert(skipped.begin(), others.begin(), others.end());
  }
  return out;
}

bool belong_together(const ScanGeometry& a, const ScanGeometry& b) {
  const double side = a.step_mm.leftCols<2>().colwise().norm().minCoeff();
  return a.dims == b.dims && (a.step_mm - b.step_mm).leftCols<2>().cwiseAbs().maxCoeff() <= kSameAxes * side;
}

/// Groups of slices of one size, spacing and orientation, the largest group first.
std::vector<Stack> groups_of(const std::vector<const DicomHeader*>& slices) {
  std::vector<Stack> groups;
  for (const DicomHeader* header : slices) {
    const Slice slice{geometry_of(*header), header};
    const auto group = std::ranges::find_if(
        groups, [&](const Stack& g) { return belong_together(g.front().geometry, slice.geometry); });
    (group == groups.end() ? groups.emplace_back() : *group).push_back(slice);
  }
  std::ranges::stable_sort(groups, [](const Stack& a, const Stack& b) { return a.size() > b.size(); });
  return groups;
}

/// All volumes of at least two slices. Removes copies from the groups, which stay sorted by size.
std::vector<DicomVolume> candidates_in(std::vector<Stack>& groups, Diagnostics& report) {
  int copies = 0;
  for (Stack& group : groups) copies += sort_slices(group);
  if (copies > 0) report.warn("copies of DICOM slices skipped: " + std::to_string(copies));
  std::ranges::stable_sort(groups, [](const Stack& a, const Stack& b) { return a.size() > b.size(); });
  std::vector<DicomVolume> out;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (DicomVolume& volume : volumes_in(groups[g])) {
      volume.group = g;
      if (volume.slices.size() >= 2) out.push_back(std::move(volume));
    }
  }
  return out;
}

std::string list_of(const std::vector<DicomVolume>& candidates, const std::string& series) {
  std::string out;
  for (std::size_t n = 0; n < candidates.size(); ++n) {
    const DicomVolume& volume = candidates[n];
    const ScanGeometry& g = volume.slices.front().geometry;
    out += fmt::format("{}{}/{}: ", n == 0 ? "" : "; ", series, n + 1);
    if (!volume.label.empty()) out += volume.label + ", ";
    out += fmt::format("{} slices of {}x{}, {:.4g}x{:.4g}x{:.4g} mm", volume.slices.size(), g.dims.x(), g.dims.y(),
                       g.spacing_mm().x(), g.spacing_mm().y(), typical_spacing(volume.slices));
  }
  return out;
}

DicomVolume chosen_volume(std::vector<DicomVolume> candidates, const std::vector<Stack>& groups, int wanted,
                          const std::string& series, const DicomFolder& folder) {
  if (wanted > 0) {
    const auto at = static_cast<std::size_t>(wanted - 1);
    if (at < candidates.size()) return std::move(candidates[at]);
    throw InputError({folder.folder}, kSeriesKey, fmt::format("no volume {} in the series", wanted),
                     "expected one of " + list_of(candidates, series));
  }
  const bool divided = candidates.size() > 1 && candidates[1].group == 0;
  const bool rivalled = groups.size() > 1 && groups[1].size() == groups[0].size();
  if (!divided && !rivalled) return std::move(candidates.front());
  const std::string& label = candidates.front().label;
  const std::string by_label = label.find('=') != std::string::npos ? " or " + series + "#" + label : "";
  throw InputError({candidates[0].slices.front().path()}, kSeriesKey,
                   fmt::format("the series holds {} volumes: ", candidates.size()) + list_of(candidates, series),
                   "choose one with bone.ct.series, for example " + series + "/1" + by_label);
}

void refuse_same_place(const Stack& stack) {
  const std::ptrdiff_t at = same_place(stack);
  if (at < 0) return;
  const Slice& slice = stack[static_cast<std::size_t>(at)];
  throw InputError({slice.path()}, kScanKey,
                   "has the same position as " + stack[static_cast<std::size_t>(at - 1)].path() +
                       ", and no element of the headers tells two volumes apart",
                   "give each slice once; split a series with two volumes into two folders");
}

/// A slice that is missing at an end leaves no gap.
void refuse_damaged_slices(const std::vector<std::string>& damaged) {
  if (damaged.empty()) return;
  const std::string others = damaged.size() == 1 ? "" : fmt::format(", as {} more", damaged.size() - 1);
  throw InputError({damaged.front()}, kScanKey,
                   "cannot be read as a DICOM slice" + others + ", but is named like the slices of the series",
                   "give a complete file, or move it out of the folder if it is no slice of this series");
}

void warn_of_other_groups(const std::vector<Stack>& groups, Diagnostics& report) {
  std::size_t count = 0;
  for (std::size_t g = 1; g < groups.size(); ++g) count += groups[g].size();
  if (count == 0) return;
  const Slice& other = groups[1].front();
  report.warn("images of the DICOM series skipped: " + std::to_string(count) + ", the first is " + other.path() +
              " and has " + difference(other.geometry, groups[0].front().geometry));
}

std::string keyword_named(const std::string& name, const DicomFolder& folder) {
  std::string known;
  for (const SeparatingTag& tag : separating_tags()) {
    if (lower_case(tag.keyword) == lower_case(name)) return tag.keyword;
    known += (known.empty() ? "" : ", ") + std::string(tag.keyword);
  }
  throw InputError({folder.folder}, kSeriesKey, "'" + name + "' is no element by which volumes are told apart",
                   "expected one of " + known);
}

/// The slices whose elements have the values that bone.ct.series gives.
std::vector<const DicomHeader*> with_tags(std::vector<const DicomHeader*> slices, const SeriesChoice& choice,
                                          const DicomFolder& folder) {
  for (const auto& [name, wanted] : choice.tags) {
    const std::string keyword = keyword_named(name, folder);
    std::set<std::string> values;
    for (const DicomHeader* header : slices) values.insert(header->tag(keyword));
    std::erase_if(slices, [&](const DicomHeader* header) { return header->tag(keyword) != wanted; });
    if (!slices.empty()) continue;
    constexpr std::size_t kMost = 20;
    std::string list;
    for (const std::string& value : values) {
      if (values.size() <= kMost || list.size() < 10 * kMost) list += (list.empty() ? "" : ", ") + value;
    }
    throw InputError({folder.folder}, kSeriesKey, "no slice has " + keyword + "=" + wanted, "its values are " + list);
  }
  return slices;
}

/// Warns how slices are interpolated.
void report_resampling(const SpacingFault& fault, const Stack& stack, const DicomStack& out, Diagnostics& report) {
  const std::string what =
      fault.kind == SpacingFault::Kind::missing
          ? fmt::format("{} missing before it (a gap of {:.3f} mm)",
                        fault.missing == 1 ? "a slice is" : std::to_string(fault.missing) + " slices are", fault.gap_mm)
          : fmt::format("slices are unevenly spaced (from here {:.3f} mm, before {:.3f} mm)", fault.gap_mm,
                        fault.before_mm);
  report.warn(stack[fault.slice].path() +
              fmt::format(": {}; {} slices were interpolated to {} at {:.4g} mm (bone.ct.uneven: resample). Detail "
                          "remains that of the original slices",
                          what, stack.size(), out.blends.size(), out.geometry.spacing_mm().z()));
}

/// Where positions are rounded, the header knows the spacing better, unless it contradicts them. The line keeps its
/// middle.
void use_spacing_of_header(SliceLine& line, const Stack& stack) {
  const ScanGeometry& g = stack.front().geometry;
  const double along = std::abs(g.step_mm.col(0).cross(g.step_mm.col(1)).normalized().dot(line.step_mm.normalized()));
  const double header_mm = stack.front().header->slice_spacing_mm;
  constexpr double kRounded = 1e-3;  // of the spacing
  if (!(header_mm > 0) || stack.front().half_unit_mm < kRounded * header_mm || !explains(stack, header_mm)) return;
  const double middle = 0.5 * static_cast<double>(stack.size() - 1);
  const Vec3 step = line.step_mm.normalized() * (header_mm / along);
  line.point_mm += middle * (line.step_mm - step);
  line.step_mm = step;
}

/// The geometry from the positions, not the slice thickness in the header: a tilted gantry is a shear.
void set_geometry(DicomStack& out, const Stack& stack, Diagnostics& report) {
  std::vector<Vec3> positions;
  for (const Slice& slice : stack) positions.push_back(slice.geometry.origin_mm);
  std::vector<double> at(stack.size());
  std::iota(at.begin(), at.end(), 0);
  if (!out.blends.empty()) {
    for (std::size_t k = 0; k < stack.size(); ++k) at[k] = stack[k].height_mm - stack.front().height_mm;
  }
  SliceLine line = line_through(positions, at);
  if (out.blends.empty()) use_spacing_of_header(line, stack);
  const std::size_t slices = out.blends.empty() ? stack.size() : out.blends.size();
  out.geometry = stack.front().geometry;
  out.geometry.dims.z() = static_cast<int>(slices);
  out.geometry.step_mm.col(2) = line.step_mm * (at.back() / static_cast<double>(slices - 1));
  out.geometry.origin_mm = line.point_mm;
  check_straight(stack, line, at, report);
  if (!out.geometry.is_valid()) {
    throw InputError({stack.front().path()}, kScanKey, "voxel spacing or axes are degenerate",
                     "export the original series");
  }
}

DicomStack stack_of(const Stack& stack, const std::vector<Stack>& groups, std::vector<std::string> skipped,
                    const DicomFolder& folder, bool resample, Diagnostics& report) {
  check_values(stack);
  refuse_same_place(stack);
  const std::vector<std::string> damaged = named_like_slices(stack, folder.unread);
  skipped.insert(skipped.begin(), damaged.begin(), damaged.end());
  const DicomHeader& first = *stack.front().header;
  DicomStack out{.slices = {}, .blends = {}, .geometry = {}, .pixel_type = first.pixel_type, .kvp = first.kvp};
  const auto fault = spacing_fault(stack, first.slice_spacing_mm);
  if (fault && !resample) refuse_spacing(*fault, stack, groups, skipped);
  if (fault) out.blends = blends_of(stack);
  refuse_damaged_slices(damaged);
  for (const Slice& slice : stack) {
    const DicomHeader& h = *slice.header;
    out.slices.push_back(
        {h.path, h.frame, h.slope, h.intercept, double{1} * h.rows * h.columns * std::max(h.frames, 1)});
  }
  set_geometry(out, stack, report);
  if (fault) report_resampling(*fault, stack, out, report);
  return out;
}

/// Sorts the slices of a series, or of the volume of it that is chosen. Skips, with a warning, images of another size,
/// spacing or orientation (a scout) and copies of a slice. Warns of rounded positions, slices missing at the ends,
/// lossy compression and mixed volumes. Files of `folder` that cannot be read may be missing slices. `resample`: slices
/// that are not evenly spaced are interpolated, with a warning. Throws InputError with the file: several volumes,
/// MONOCHROME1, a multi-frame file without positions, missing, unevenly spaced, duplicate, displaced.
DicomStack stack_slices(const DicomSeries& series, const SeriesChoice& choice, const DicomFolder& folder, bool resample,
                        Diagnostics& report) {
  std::vector<std::string> skipped = folder.damaged;
  std::vector<Stack> groups = groups_of(with_tags(slices_among(series, skipped, report), choice, folder));
  std::vector<DicomVolume> candidates = candidates_in(groups, report);
  if (candidates.empty()) {
    const ForeignFile file{groups.front().front().path(), kScanKey};
    if (file.path == folder.folder) throw file.error("a single DICOM slice", "give the folder of the series");
    throw file.error("one DICOM slice", "expected the slices of a volume, at least two of one size and orientation");
  }
  const auto number = &series - folder.series.data() + 1;
  const DicomVolume chosen =
      chosen_volume(std::move(candidates), groups, choice.volume, std::to_string(number), folder);
  const auto group = groups.begin() + static_cast<std::ptrdiff_t>(chosen.group);
  std::rotate(groups.begin(), group, group + 1);
  DicomStack out = stack_of(chosen.slices, groups, std::move(skipped), folder, resample, report);
  warn_of_other_groups(groups, report);
  warn_of_missing_ends(chosen.slices, series, report);
  warn_of_values(chosen.slices, report);
  return out;
}

Scan read_box(const DicomStack& stack, const IndexBox& box) {
  const IndexBox in_slice{{box.start.x(), box.start.y(), 0}, {box.size.x(), box.size.y(), 1}};
  const auto slices = [&](std::size_t first, std::size_t last) {
    const auto begin = stack.slices.begin();
    return read_slices({begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last) + 1},
                       in_slice);
  };
  const auto first = static_cast<std::size_t>(box.start.z());
  const std::size_t last = first + static_cast<std::size_t>(box.size.z()) - 1;
  if (stack.blends.empty()) return {part_of(stack.geometry, box), slices(first, last)};
  Scan out{part_of(stack.geometry, box), {}};
  const std::size_t lowest = stack.blends[first].below;
  const std::vector<float> source = slices(lowest, stack.blends[last].below + 1);
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  out.value.reserve(static_cast<std::size_t>(box.voxels()));
  for (std::size_t k = first; k <= last; ++k) {
    const SliceBlend& blend = stack.blends[k];
    const float* low = source.data() + (blend.below - lowest) * pixels;
    for (std::size_t n = 0; n < pixels; ++n) {
      const double value = (1 - blend.weight) * double{low[n]} + blend.weight * double{low[pixels + n]};
      out.value.push_back(static_cast<float>(value));
    }
  }
  return out;
}

}  // namespace

ScanGeometry geometry_of(const DicomHeader& header) {
  ScanGeometry out;
  out.dims = Vec3i(header.columns, header.rows, 1);
  out.step_mm.col(0) = header.axes->col(0) * header.pixel_spacing_mm->x();
  out.step_mm.col(1) = header.axes->col(1) * header.pixel_spacing_mm->y();
  out.step_mm.col(2) = header.normal();
  out.origin_mm = *header.position_mm;
  return out;
}

ScanSource open_dicom(const std::string& path, const CtSettings& settings, Diagnostics& report) {
  const SeriesChoice chosen = parse_series_choice(settings.series, path);
  const DicomFolder found = find_dicom_series(path, report);
  const DicomSeries& series = choose_series(found, chosen, settings.modality == Modality::any, report);
  const DicomHeader& first = series.first();
  if (first.modality != "CT") {
    report.warn(path + ": modality " + (first.modality.empty() ? "unknown" : first.modality) +
                ", not CT; thresholds and densities are wrong unless its values are HU");
  }
  const DicomStack stack = stack_slices(series, chosen, found, settings.uneven == Uneven::resample, report);
  check_fits_in_memory(static_cast<double>(stack.geometry.size()), sizeof(float), {path, kScanKey});
  std::set<std::string> files;
  for (const SliceSource& slice : stack.slices) files.insert(slice.path);
  std::string description = "DICOM series" + (first.description.empty() ? "" : " \"" + first.description + "\"") +
                            fmt::format(" of {} {}, ", files.size(), files.size() == 1 ? "file" : "files");
  if (files.size() != stack.slices.size()) description += fmt::format("{} frames, ", stack.slices.size());
  return {.geometry = stack.geometry,
          .description = description + stack.pixel_type,
          .kvp = stack.kvp,
          .segments = {},
          .read = [stack](const IndexBox& box, int) { return read_box(stack, box); }};
}

}  // namespace reamsim::ct
