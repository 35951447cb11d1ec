// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/scan/dicom_files.h"

namespace reamsim::ct {

// The slices of one DICOM series: their spacing, the volumes that they form, and what is checked of these. Private to
// sim/scan.

struct Slice {
  ScanGeometry geometry;  ///< its slice thickness may differ from the slice spacing
  const DicomHeader* header = nullptr;
  double height_mm = 0;     ///< of its origin along the slice normal
  double half_unit_mm = 0;  ///< half a unit of the last digit of its position, along the normal
  double rounding_mm = 0;   ///< the same in any direction

  [[nodiscard]] const std::string& path() const { return header->path; }
};

using Stack = std::vector<Slice>;

/// The geometry in the header of a slice, 1 mm thick: the positions of its neighbours say more.
ScanGeometry geometry_of(const DicomHeader& header);

// Spacing (slice_spacing.cpp). Stacks are sorted by height.

/// Slices closer than this fraction of the spacing have the same position.
inline constexpr double kSamePlace = 0.01;

/// Half a unit of the last written digit of each coordinate of each position "x\y\z". An exporter rounds all of them
/// alike, so trailing zeros that it omits count. Huge where a text has no number.
std::vector<Vec3> half_units(const std::vector<std::string>& positions);

/// Why slices are not evenly spaced.
struct SpacingFault {
  enum class Kind { missing, change, irregular };
  Kind kind = Kind::irregular;
  std::size_t slice = 0;  ///< the gap ends at this slice
  double before_mm = 0;   ///< the usual spacing; before a change
  double gap_mm = 0;      ///< of this gap; after a change
  long missing = 0;       ///< slices; after a change, per gap, if instance numbers jump as well
};

/// Median distance of neighbours, without those at the same place; slices closer than a hundredth of the largest gap
/// are at the same place.
double typical_spacing(const Stack& slices);

/// The first fault; none where every gap is within 5 % of the typical one, or where even spacing explains all positions
/// within half a unit of their last digit and nothing says that a slice is missing. `header_mm`: the slice spacing in
/// the header, 0: unknown.
std::optional<SpacingFault> spacing_fault(const Stack& slices, double header_mm);

/// A line of positions: point_mm + step_mm·k.
struct SliceLine {
  Vec3 point_mm = Vec3::Zero();
  Vec3 step_mm = Vec3::Zero();
};

/// The least-squares line of positions at the places `at` along it; through the first and the last one where that
/// deviates by less than a thousandth of the step.
SliceLine line_through(const std::vector<Vec3>& positions, const std::vector<double>& at);

/// The instance numbers of slices, if all have one and they run in one direction without repetition; else empty.
std::vector<int> instance_numbers(const Stack& stack);

/// Whether slices with this spacing explain all positions within half a unit of their last digit.
bool explains(const Stack& slices, double spacing_mm);

/// For each slice of an evenly spaced stack, the source slice below it and the weight of the next one.
struct SliceBlend {
  std::size_t below = 0;
  double weight = 0;
};

/// The evenly spaced slices, from the first height to the last, that interpolate these. Their spacing is the finest
/// that occurs more than once, or a little less.
std::vector<SliceBlend> blends_of(const Stack& slices);

/// A mistake in a DICOM segmentation, with what to do about it.
InputError bad_seg(const ForeignFile& file, const std::string& found);

/// The evenly spaced planes on which the frames of a segmentation lie; SEG leaves empty planes out.
struct SegPlanes {
  ScanGeometry geometry;
  std::vector<int> plane_of_frame;
};
SegPlanes seg_planes(const std::vector<DicomHeader>& frames, const ForeignFile& file);

// Volumes: phases, acquisitions, reconstructions (dicom_volumes.cpp).

/// Slices of one size and orientation, sorted by height.
struct DicomVolume {
  std::string label;  ///< "AcquisitionNumber=1"; empty: the only one
  Stack slices;
  std::size_t group = 0;  ///< of those by geometry, to which it belongs
};

/// Sorts by height, finds the rounding of positions, and removes copies of a slice (the same instance). Returns the
/// number of copies.
int sort_slices(Stack& stack);

/// The volumes in sorted slices of one geometry. Where different slices have the same position, or where slices of two
/// volumes alternate, the first elements that tell them apart divide them, one of separating_tags() or two. Without
/// such an element, and as many slices at every position, their instance numbers do. One volume otherwise.
std::vector<DicomVolume> volumes_in(const Stack& sorted);

/// The first slice that lies where its neighbour lies; -1: none.
std::ptrdiff_t same_place(const Stack& sorted);

/// Elements that differ within a volume as they would if two volumes were mixed: "ConvolutionKernel B30f and B60s".
/// Empty: none.
std::string mixed_elements(const Stack& sorted);

// Checks (dicom_checks.cpp).

/// Axes of slices are equal to within this fraction of the side of a pixel.
inline constexpr double kSameAxes = 2e-3;

/// "26x20 pixels; the other slices have 26x30".
std::string difference(const ScanGeometry& other, const ScanGeometry& usual);

/// Throws InputError: MONOCHROME1, or slices with and without rescale.
void check_values(const Stack& stack);

/// The files that lie beside the slices and are named like them: slices that are damaged beyond recognition.
std::vector<std::string> named_like_slices(const Stack& stack, const std::vector<std::string>& files);

/// Throws InputError for a fault of the spacing. `groups`: all slices of the series by geometry, the stack's first;
/// one of the others, or a `skipped` file, may be the missing slice.
[[noreturn]] void refuse_spacing(const SpacingFault& fault, const Stack& stack, const std::vector<Stack>& groups,
                                 const std::vector<std::string>& skipped);

/// Throws InputError unless the slices lie on the line, at these places along it. Warns of the largest deviation.
void check_straight(const Stack& stack, const SliceLine& line, const std::vector<double>& at, Diagnostics& report);

/// Warns of instance numbers before the first and after the last slice that no image of the series has.
void warn_of_missing_ends(const Stack& stack, const DicomSeries& series, Diagnostics& report);

/// Warns of lossy compression, and of two volumes that are mixed.
void warn_of_values(const Stack& stack, Diagnostics& report);

}  // namespace reamsim::ct
