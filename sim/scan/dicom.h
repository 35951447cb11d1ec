// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/scan/scan.h"

namespace reamsim::ct {

// DICOM files, the series and volumes in them. Private to sim/scan. Files are read by child processes, because GDCM
// crashes on some damaged ones.

/// The directions of the rows and of the columns of a slice, perpendicular unit vectors in LPS.
using SliceAxes = Eigen::Matrix<double, 3, 2>;

/// The header of a slice: of a DICOM file, or of a frame of a multi-frame file. Texts are printable ASCII without
/// padding.
struct DicomHeader {
  std::string path;
  std::string series_uid;
  std::string instance_uid;  ///< with the number of the frame
  std::string sop_class;
  std::string description;
  std::string kernel;    ///< convolution kernel of the reconstruction
  std::string modality;  ///< "CT", "MR", ...
  std::string photometric;
  std::string pixel_type;     ///< "int16", ...
  std::string position_text;  ///< the position as it is written, "x\y\z", for its rounding
  std::string lossy;          ///< how the pixels were compressed with loss; empty: they were not
  std::string assumed;        ///< what was taken for an element that is incomplete; empty: none is
  int series_number = 0;
  int frames = 1;  ///< above 1: a multi-frame file
  int frame = -1;  ///< index of a frame that says where it lies (functional groups); -1: the file is one slice
  int columns = 0;
  int rows = 0;
  int images_in_acquisition = 0;  ///< 0: unknown
  bool rescales = false;          ///< says how its values become HU
  double slope = 1;
  double intercept = 0;
  double kvp = 0;               ///< tube voltage, kV; 0: unknown
  double slice_spacing_mm = 0;  ///< as the header says it, else the slice thickness; 0: unknown
  std::optional<int> instance_number;
  std::optional<Vec2> pixel_spacing_mm;  ///< of columns (along a row) and of rows
  std::optional<Vec3> position_mm;       ///< of the first pixel, LPS
  std::optional<SliceAxes> axes;
  /// What may tell the volumes of a series apart, by keyword: "AcquisitionNumber".
  std::vector<std::pair<std::string, std::string>> tags;

  [[nodiscard]] Vec3 normal() const { return axes->col(0).cross(axes->col(1)); }
  [[nodiscard]] bool is_valid() const {
    const auto is_finite = [](const auto& numbers) { return !numbers || numbers->allFinite(); };
    return is_finite(pixel_spacing_mm) && is_finite(position_mm) && is_finite(axes);
  }
  /// The value of an element that may tell volumes apart; "" without it.
  [[nodiscard]] std::string tag(const std::string& keyword) const {
    const auto found = std::ranges::find(tags, keyword, &std::pair<std::string, std::string>::first);
    return found == tags.end() ? "" : found->second;
  }

  static auto fields(auto& h) {
    return std::tie(h.path, h.series_uid, h.instance_uid, h.sop_class, h.description, h.kernel, h.modality,
                    h.photometric, h.pixel_type, h.position_text, h.lossy, h.assumed, h.series_number, h.frames,
                    h.frame, h.columns, h.rows, h.images_in_acquisition, h.rescales, h.slope, h.intercept, h.kvp,
                    h.slice_spacing_mm, h.instance_number, h.pixel_spacing_mm, h.position_mm, h.axes, h.tags);
  }
};

enum class DicomKind {
  other,        ///< not a DICOM file
  no_image,     ///< a DICOM file without an image: a report, a plan, a directory
  damaged,      ///< a DICOM file whose header cannot be read
  unsupported,  ///< in a transfer syntax that cannot be decoded
  image
};

/// A DICOM file.
struct DicomFile {
  DicomKind kind = DicomKind::other;
  std::string note;                 ///< the transfer syntax that cannot be decoded; the modality without an image
  std::vector<DicomHeader> images;  ///< one, or its frames

  [[nodiscard]] bool is_valid() const {
    return kind >= DicomKind::other && kind <= DicomKind::image && (kind == DicomKind::image) != images.empty();
  }

  static auto fields(auto& self) { return std::tie(self.kind, self.note, self.images); }
};

/// Reads a file up to its pixels.
DicomFile read_dicom_header(const std::string& path);

/// Whether a file looks like DICOM: "DICM" after the preamble, or without one an element of the first groups.
bool looks_like_dicom(const std::string& path);

/// The headers of `files`, in their order. Files that crash the reader, or take it too long, are DicomKind::damaged.
/// `folder`: for messages. Throws InputError when there are many such files.
std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const ForeignFile& folder);

/// What is read of a slice, with its rescale.
struct SliceSource {
  std::string path;
  int frame = -1;  ///< of the file; -1: the file is one slice
  double slope = 1;
  double intercept = 0;
  double file_pixels = 0;  ///< of all frames

  static auto fields(auto& s) { return std::tie(s.path, s.frame, s.slope, s.intercept, s.file_pixels); }
};

/// The values of a box of each slice, one slice after the other. Throws InputError, with the file.
std::vector<float> read_slices(const std::vector<SliceSource>& slices, const IndexBox& in_slice);

/// The error of pixels that are cut off, or in a coding that GDCM should decode and does not: damaged, or a variant.
InputError unreadable(const ForeignFile& file);

/// The regular files in a folder and its subfolders, sorted by path, or the file `path`. Links to folders are not
/// followed.
std::vector<std::string> files_below(const std::string& path);

/// The images of a folder with one series UID, sorted by path.
struct DicomSeries {
  std::vector<DicomHeader> images;
  /// Pixel spacing and median slice spacing; 0 where unknown.
  Vec3 spacing_mm = Vec3::Zero();

  [[nodiscard]] const DicomHeader& first() const { return images.front(); }
  /// Number of slices: frames count each.
  [[nodiscard]] int slices() const;
};

struct DicomFolder {
  std::vector<DicomSeries> series;   ///< by series number, then UID: the order that the scenario's numbers refer to
  std::vector<std::string> damaged;  ///< DICOM files that cannot be read
  std::vector<std::string> unread;   ///< these, files coded in a way that cannot be decoded, others than DICOM
  std::string folder;                ///< or a single file
};

/// All DICOM images in a folder and its subfolders, or the file `folder`. Throws InputError if there is none, or if
/// files are coded in a way that cannot be decoded.
DicomFolder find_dicom_series(const std::string& folder, Diagnostics& report);

/// "1: UID 1.2.3, "Bone", CT, 24 slices of 512x512, 0.488x0.488x1.25 mm, kernel B60s; 2: ...".
std::string list_of(const std::vector<DicomSeries>& series);

inline constexpr const char* kSeriesKey = "bone.ct.series";

/// What bone.ct.series says: SERIES, SERIES/VOLUME or SERIES#TAG=VALUE#TAG=VALUE. SERIES is a UID or number; without
/// it the usual series is meant.
struct SeriesChoice {
  std::string series;
  int volume = 0;                                         ///< in the list of its volumes, from 1; 0: not given
  std::vector<std::pair<std::string, std::string>> tags;  ///< keyword and value
};

/// Throws InputError.
SeriesChoice parse_series_choice(const std::string& text, const std::string& folder);

/// The series that the scenario chooses by UID or number, or else the CT series with the most slices, with a warning if
/// there are several. Throws InputError: no such series, not CT, two with the same number and spacing of slices.
const DicomSeries& choose_series(const DicomFolder& found, const SeriesChoice& chosen, bool any_modality,
                                 Diagnostics& report);

// The slices of one series: their spacing, the volumes that they form, and what is checked of these.

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

// Volumes: phases, acquisitions, reconstructions, and what is checked of them (dicom_volumes.cpp).

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
