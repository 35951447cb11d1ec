#include "sim/bone/ct/dicom_stack.h"

#include <fmt/core.h>
#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/bone/ct/complete.h"
#include "sim/bone/ct/dicom_probe.h"
#include "sim/bone/ct/image_file.h"
#include "sim/bone/ct/quiet.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

/// Neighbouring slices may differ from the usual distance by this fraction before a slice counts as missing.
constexpr double kSpacingTolerance = 0.05;
/// Slices closer than this fraction of the usual distance are two of the same place.
constexpr double kSamePlace = 0.01;
/// Axes of slices that differ by less than this fraction of a pixel's side are the same.
constexpr double kSameAxes = 2e-3;
/// A slice may be off the line through the first and the last by this fraction of a pixel.
constexpr double kStraight_pixels = 0.5;

struct Slice {
  const DicomHeader* header = nullptr;
  ScanGeometry geometry;  ///< the file's own; z from its header, which need not be the distance to the next slice
  double height_mm = 0;   ///< of its origin along the slice normal

  [[nodiscard]] const std::string& path() const { return header->path; }
};

using Stack = std::vector<Slice>;

/// Whether an image may be a slice at all; screenshots, dose reports and multi-frame files are not.
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

/// The images that may be slices. The others are left out with a warning, and added to `left_out`.
std::vector<const DicomHeader*> slices_among(const DicomSeries& series, std::vector<std::string>& left_out,
                                             const std::string& key, Report& report) {
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
    left_out.insert(left_out.begin(), others.begin(), others.end());
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

ScanGeometry slice_geometry(const std::string& path, const std::string& key) {
  const auto io = itk::GDCMImageIO::New();
  const QuietLibraries quiet;
  try {
    io->SetFileName(path);
    io->ReadImageInformation();
  } catch (const std::exception&) {
    throw InputError({path}, key, "the slice cannot be read: it is truncated or damaged", "give a complete file");
  }
  if (says_incomplete(quiet.output())) throw InputError({path}, key, "the slice is truncated", "give a complete file");
  return geometry_of(*io, path, key, true);
}

bool belong_together(const ScanGeometry& a, const ScanGeometry& b) {
  const double side = a.step_mm.leftCols<2>().colwise().norm().minCoeff();
  return a.dims == b.dims && (a.step_mm - b.step_mm).leftCols<2>().cwiseAbs().maxCoeff() <= kSameAxes * side;
}

/// Slices of one size, spacing and orientation each, the largest such group first.
std::vector<Stack> groups_of(const std::vector<const DicomHeader*>& slices, const std::string& key) {
  std::vector<Stack> groups;
  for (const DicomHeader* header : slices) {
    const Slice slice{header, slice_geometry(header->path, key), 0};
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

std::string difference(const ScanGeometry& stray, const ScanGeometry& usual) {
  if (stray.dims != usual.dims) {
    return fmt::format("{}x{} pixels; the other slices have {}x{}", stray.dims.x(), stray.dims.y(), usual.dims.x(),
                       usual.dims.y());
  }
  const Vec3 a = stray.spacing_mm();
  const Vec3 b = usual.spacing_mm();
  if ((a - b).head<2>().cwiseAbs().maxCoeff() > kSameAxes * b.head<2>().minCoeff()) {
    return fmt::format("pixels of {:.4g}x{:.4g} mm; those of the other slices are {:.4g}x{:.4g} mm", a.x(), a.y(),
                       b.x(), b.y());
  }
  return "an orientation different from that of the other slices";
}

/// A copy of a slice (the same instance) goes; two slices in one place are an error.
void drop_copies(Stack& stack, double usual_mm, const std::string& key, Report& report) {
  Stack kept{stack.front()};
  int copies = 0;
  for (std::size_t n = 1; n < stack.size(); ++n) {
    const Slice& before = kept.back();
    const bool same_place = stack[n].height_mm - before.height_mm <= kSamePlace * usual_mm;
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

/// The distance that most neighbours have, without those in the same place.
double usual_distance(const Stack& stack) {
  std::vector<double> gap;
  for (std::size_t n = 1; n < stack.size(); ++n) gap.push_back(stack[n].height_mm - stack[n - 1].height_mm);
  std::ranges::sort(gap);
  const auto first = std::ranges::lower_bound(gap, kSamePlace * gap.back());
  const auto left = gap.end() - first;
  return *(first + left / 2);
}

/// What of the rest of the series, or of the damaged files, may be the missing slice.
std::string suspect(double low_mm, double high_mm, const Vec3& normal, const ScanGeometry& usual,
                    const std::vector<Stack>& groups, const std::vector<std::string>& left_out) {
  for (std::size_t g = 1; g < groups.size(); ++g) {
    for (const Slice& slice : groups[g]) {
      const double height = normal.dot(slice.geometry.origin_mm);
      if (height > low_mm && height < high_mm) {
        return "; " + slice.path() + " lies there and has " + difference(slice.geometry, usual);
      }
    }
  }
  return left_out.empty() ? "" : "; " + left_out.front() + " was skipped";
}

void check_distances(const std::vector<Stack>& groups, double usual_mm, const Vec3& normal,
                     const std::vector<std::string>& left_out, const std::string& key) {
  const Stack& stack = groups.front();
  for (std::size_t k = 1; k < stack.size(); ++k) {
    const double gap = stack[k].height_mm - stack[k - 1].height_mm;
    if (std::abs(gap - usual_mm) <= kSpacingTolerance * usual_mm) continue;
    const std::string found =
        fmt::format("slice spacing is {:.3f} mm; most slices are {:.3f} mm apart: ", gap, usual_mm) +
        stack[k - 1].path() + " and " + stack[k].path();
    const long missing = std::lround(gap / usual_mm) - 1;
    const std::string between = missing == 1  ? "a slice is missing between them"
                                : missing > 1 ? std::to_string(missing) + " slices are missing between them"
                                              : "expected evenly spaced slices";
    throw InputError({stack[k].path()}, key, found,
                     between + suspect(stack[k - 1].height_mm, stack[k].height_mm, normal, stack.front().geometry,
                                       groups, left_out));
  }
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

void warn_of_strays(const std::vector<Stack>& groups, Report& report) {
  std::size_t count = 0;
  for (std::size_t g = 1; g < groups.size(); ++g) count += groups[g].size();
  if (count == 0) return;
  const Slice& stray = groups[1].front();
  report.warn("images of the DICOM series skipped: " + std::to_string(count) + ", the first is " + stray.path() +
              " and has " + difference(stray.geometry, groups[0].front().geometry));
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

}  // namespace

DicomStack stack_slices(const DicomSeries& series, const std::vector<std::string>& damaged, const std::string& key,
                        Report& report) {
  std::vector<std::string> left_out = damaged;
  const std::vector<const DicomHeader*> slices = slices_among(series, left_out, key, report);
  std::vector<std::string> files;
  for (const DicomHeader* header : slices) files.push_back(header->path);
  check_dicom_is_survived(files, key);
  std::vector<Stack> groups = groups_of(slices, key);
  check_count(groups, key);
  Stack& stack = groups.front();
  check_grey_values(stack, key);
  const ScanGeometry first = stack.front().geometry;
  const Vec3 normal = first.step_mm.col(0).cross(first.step_mm.col(1)).normalized();
  for (Slice& slice : stack) slice.height_mm = normal.dot(slice.geometry.origin_mm);
  std::ranges::stable_sort(stack, {}, &Slice::height_mm);
  const double usual_mm = usual_distance(stack);
  drop_copies(stack, usual_mm, key, report);
  check_count(groups, key);
  check_distances(groups, usual_mm, normal, left_out, key);
  warn_of_strays(groups, report);

  DicomStack out;
  for (const Slice& slice : stack) out.path.push_back(slice.path());
  out.geometry = stack.front().geometry;
  out.geometry.dims.z() = static_cast<int>(stack.size());
  // From the positions, not the header's slice thickness; so a tilted gantry comes out as the shear that it is.
  out.geometry.step_mm.col(2) =
      (stack.back().geometry.origin_mm - stack.front().geometry.origin_mm) / static_cast<double>(stack.size() - 1);
  check_straight(stack, out.geometry.step_mm.col(2), key);
  return out;
}

}  // namespace reamsim::ct
