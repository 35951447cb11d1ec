// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/dicom.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

void put_header(ResultWriter& out, const ForeignFile& file, bool allow_layers) {
  const auto nifti = read_nifti_header(file);
  out.put(nifti ? facts_of(*nifti, file, allow_layers) : check_image(*open_image_io(file), file, allow_layers));
  if (nifti && !is_complete(*nifti)) throw cut_off(file);
}

/// Reads a box of a layer of a file that had these dimensions and layers.
void put_part(ResultWriter& out, const ForeignFile& file, const Vec3i& dims, int layers, const IndexBox& box,
              int layer) {
  const auto nifti = read_nifti_header(file);
  const itk::ImageIOBase::Pointer io = nifti ? nullptr : open_image_io(file);
  const ImageFacts now = nifti ? facts_of(*nifti, file, true) : check_image(*io, file, true);
  if (now.geometry.dims != dims || now.layers != layers) {
    throw file.error("the file has changed while it was read", "start again");
  }
  float* const voxels = out.array<float>(static_cast<std::size_t>(box.voxels()));
  return nifti ? read_nifti_voxels(*nifti, box, layer, file, voxels) : read_voxels(*io, box, layer, file, voxels);
}

/// The largest angle by which two axes miss a right one, degrees.
double skew_deg(const ScanGeometry& geometry) {
  const Mat3 axes = geometry.step_mm.colwise().normalized();
  double sine = 0;
  for (int axis = 0; axis < 3; ++axis) sine = std::max(sine, std::abs(axes.col(axis).dot(axes.col((axis + 1) % 3))));
  return std::asin(std::min(sine, 1.0)) * 180 / std::numbers::pi;
}

void warn_of_header(const std::string& path, const ImageFacts& facts, Diagnostics& report) {
  for (const std::string& warning : facts.warnings) report.warn(path + ": " + printable(warning));
  constexpr double kWorthWarning_deg = 0.5;
  const double skew = skew_deg(facts.geometry);
  if (skew <= kWorthWarning_deg) return;
  report.warn(path +
              fmt::format(": the axes of the image miss right angles by up to {:.2g}° (a tilted gantry, or rounded "
                          "numbers); it is resampled as they say",
                          skew));
}

/// An NRRD, NIfTI or MetaImage file. A child process reads its header, and another one its voxels.
ScanSource file_source(const ForeignFile& file, bool allow_layers, Diagnostics& report) {
  const ReadLimits of_header = ReadLimits().with(bytes_of_file(file.path), 0);
  const auto facts = read_in_child<put_header>(file, of_header, file, allow_layers).take<ImageFacts>();
  const auto voxels_of_file = static_cast<double>(facts.geometry.size());
  check_fits_in_memory(voxels_of_file, facts.bytes_per_voxel, file);
  warn_of_header(file.path, facts, report);
  // Formats that cannot be read in part are in memory as a whole, some of them twice.
  const auto whole = static_cast<std::uint64_t>(facts.bytes_per_voxel * voxels_of_file);
  const ReadLimits limits = ReadLimits().with(bytes_of_file(file.path), 3 * whole);
  const auto read = [=, geometry = facts.geometry, layers = facts.layers](const IndexBox& box, int layer) {
    const auto voxels = static_cast<std::size_t>(box.voxels());
    ReadLimits most = limits;
    most.result_bytes += voxels * sizeof(float);
    ResultReader result = read_in_child<put_part>(file, most, file, geometry.dims, layers, box, layer);
    return Scan{part_of(geometry, box), result.array_of<float>(voxels)};
  };
  return {.geometry = facts.geometry,
          .description = facts.format + ", " + facts.pixel_type + ", " + printable(facts.frame),
          .layers = facts.layers,
          .has_whole_numbers = facts.pixel_type != "float" && facts.pixel_type != "double",
          .segments = facts.segments,
          .read = read};
}

/// Whether a path is a folder. Throws InputError if the path does not exist, or is neither a folder nor a file.
bool is_folder(const ForeignFile& file, const char* expected) {
  std::error_code error;
  const fs::file_status status = fs::status(file.path, error);
  const std::string reason = unreachable_reason(file.path);
  if (!reason.empty()) throw file.error("cannot be read (" + reason + ")", expected);
  if (!fs::exists(status)) throw file.error("no such file or folder", expected);
  if (fs::is_directory(status) || fs::is_regular_file(status)) return fs::is_directory(status);
  throw file.error("neither a file nor a folder", expected);
}

}  // namespace

void check_fits_in_memory(double voxels, double bytes_per_voxel, const ForeignFile& file) {
  const double memory = machine_memory_bytes();
  if (voxels * bytes_per_voxel <= 0.5 * memory) return;
  throw file.error(fmt::format("{:.3g} voxels need {:.3g} GB, more than half of this machine's memory ({:.3g} GB)",
                               voxels, voxels * bytes_per_voxel / 1e9, memory / 1e9),
                   "use fewer voxels, or check that the header is not damaged");
}

ScanSource open_scan(const CtSettings& settings, Diagnostics& report) {
  const std::string& path = settings.path;
  const ForeignFile file{path, kScanKey};
  const bool folder = is_folder(file, "give a CT image");
  try {
    // DICOMDIR is the index file beside the folders of a study.
    if (!folder && lower_case(fs::path(path).filename().string()) == "dicomdir")
      return open_dicom(fs::path(path).parent_path().string(), settings, report);
    if (folder || looks_like_dicom(path)) return open_dicom(path, settings, report);
    ScanSource scan = file_source(file, false, report);
    if (settings.series.empty()) return scan;
    throw InputError({path}, "bone.ct.series", "given for a file that is not a DICOM folder", "remove it");
  } catch (const fs::filesystem_error&) {
    throw file.error("cannot be opened", "check its permissions");
  }
}

ScanSource open_labels(const std::string& path, Diagnostics& report) {
  const ForeignFile file{path, kLabelPathKey};
  const bool folder = is_folder(file, "give a label map: NRRD, NIfTI, MetaImage or DICOM SEG");
  try {
    return folder || looks_like_dicom(path) ? open_dicom_seg(file, report) : file_source(file, true, report);
  } catch (const fs::filesystem_error&) {
    throw file.error("cannot be opened", "check its permissions");
  }
}

}  // namespace reamsim::ct
