// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

void put_header(ResultWriter& out, const std::string& path, const std::string& key, bool allow_layers) {
  if (const auto nifti = read_nifti_header(path, key)) return out.put(facts_of(*nifti, path, key, allow_layers));
  std::string format;
  const itk::ImageIOBase::Pointer io = open_image_io(path, key, format);
  out.put(check_image(*io, path, key, format, allow_layers));
}

/// What is read of a file that had these dimensions and layers.
struct Part {
  Vec3i dims = Vec3i::Zero();
  int layers = 1;
  IndexBox box;
  int layer = 0;

  static auto fields(auto& self) { return std::tie(self.dims, self.layers, self.box, self.layer); }
};

/// Throws InputError unless the file still has the dimensions of its header.
void check_unchanged(const Part& part, const Vec3i& dims, int layers, const std::string& path, const std::string& key) {
  if (dims == part.dims && layers == part.layers) return;
  throw InputError({path}, key, "the file has changed while it was read", "start again");
}

void put_part(ResultWriter& out, const std::string& path, const std::string& key, const Part& part) {
  if (const auto nifti = read_nifti_header(path, key)) {
    check_unchanged(part, placement_of(*nifti, path, key).geometry.dims, nifti->layers(), path, key);
    float* const voxels = out.array<float>(static_cast<std::size_t>(part.box.voxels()));
    return read_nifti_voxels(*nifti, part.box, part.layer, path, key, voxels);
  }
  std::string format;
  const itk::ImageIOBase::Pointer io = open_image_io(path, key, format);
  read_header(*io, path, key, format);
  const ScanGeometry now = geometry_of(*io, path, key, false, true);
  check_unchanged(part, now.dims, static_cast<int>(io->GetNumberOfComponents()), path, key);
  read_voxels(*io, part.box, part.layer, path, key, out.array<float>(static_cast<std::size_t>(part.box.voxels())));
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
class FileScan : public LabelSource {
 public:
  FileScan(const std::string& path, const std::string& key, bool allow_layers, Diagnostics& report)
      : path_(path), key_(key) {
    const ReadLimits limits = ReadLimits().with(bytes_of_file(path), 0);
    ChildResult result = read_in_child<put_header>({path, key}, limits, path, key, allow_layers);
    facts_ = result.reader().take<ImageFacts>();
    check_fits_in_memory(static_cast<double>(facts_.geometry.size()), facts_.bytes_per_voxel, path, key);
    warn_of_header(path, facts_, report);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return facts_.geometry; }
  [[nodiscard]] std::string description() const override {
    return facts_.format + ", " + facts_.pixel_type + ", " + printable(facts_.frame);
  }
  [[nodiscard]] Scan read(const IndexBox& box) const override { return read_layer(box, 0); }

  [[nodiscard]] int layers() const override { return facts_.layers; }
  [[nodiscard]] bool has_whole_numbers() const override {
    return facts_.pixel_type != "float" && facts_.pixel_type != "double";
  }
  [[nodiscard]] Scan read_layer(const IndexBox& box, int layer) const override {
    const auto voxels = static_cast<std::size_t>(box.voxels());
    const Part part{facts_.geometry.dims, facts_.layers, box, layer};
    ChildResult result = read_in_child<put_part>({path_, key_}, limits_for(voxels), path_, key_, part);
    Scan scan{part_of(facts_.geometry, box), result.reader().array<float>()};
    if (scan.value.size() != voxels) result.reader().fail();
    return scan;
  }
  [[nodiscard]] const std::vector<NamedSegment>& segments() const override { return facts_.segments; }

 private:
  /// Formats that cannot be read in part are in memory as a whole, some of them twice.
  [[nodiscard]] ReadLimits limits_for(std::size_t voxels) const {
    const auto whole = static_cast<std::uint64_t>(facts_.bytes_per_voxel * static_cast<double>(facts_.geometry.size()));
    ReadLimits limits = ReadLimits().with(bytes_of_file(path_), 3 * whole);
    limits.result_bytes += voxels * sizeof(float);
    return limits;
  }

  std::string path_;
  std::string key_;
  ImageFacts facts_;
};

/// The kind of an existing path. Throws InputError if the path does not exist.
fs::file_status checked_status(const std::string& path, const std::string& key, const char* expected) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string reason = unreachable_reason(path);
  if (!reason.empty()) throw InputError({path}, key, "cannot be read (" + reason + ")", expected);
  if (!fs::exists(status)) throw InputError({path}, key, "no such file or folder", expected);
  if (!fs::is_directory(status) && !fs::is_regular_file(status)) {
    throw InputError({path}, key, "neither a file nor a folder", expected);
  }
  return status;
}

}  // namespace

void check_fits_in_memory(double voxels, double bytes_per_voxel, const std::string& path, const std::string& key) {
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (voxels * bytes_per_voxel <= 0.5 * memory) return;
  const std::string text =
      fmt::format("{:.3g} voxels need {:.3g} GB, more than half of this machine's memory ({:.3g} GB)", voxels,
                  voxels * bytes_per_voxel / 1e9, memory / 1e9);
  throw InputError({path}, key, text, "use fewer voxels, or check that the header is not damaged");
}

std::unique_ptr<ScanSource> open_scan(const std::string& path, const std::string& key, const DicomChoice& choice,
                                      Diagnostics& report) {
  const bool folder = fs::is_directory(checked_status(path, key, "give a CT image"));
  try {
    // DICOMDIR is the index file beside the folders of a study.
    if (!folder && lower_case(fs::path(path).filename().string()) == "dicomdir")
      return open_dicom(fs::path(path).parent_path().string(), key, choice, report);
    if (folder || looks_like_dicom(path)) return open_dicom(path, key, choice, report);
    auto scan = std::make_unique<FileScan>(path, key, false, report);
    if (choice.series.empty()) return scan;
    throw InputError({path}, "bone.ct.series", "given for a file that is not a DICOM folder", "remove it");
  } catch (const fs::filesystem_error&) {
    throw InputError({path}, key, "cannot be opened", "check its permissions");
  }
}

std::unique_ptr<LabelSource> open_labels(const std::string& path, const std::string& key, Diagnostics& report) {
  const char* expected = "give a label map: NRRD, NIfTI, MetaImage or DICOM SEG";
  const bool folder = fs::is_directory(checked_status(path, key, expected));
  try {
    if (folder || looks_like_dicom(path)) return open_dicom_seg(path, key, report);
    return std::make_unique<FileScan>(path, key, true, report);
  } catch (const fs::filesystem_error&) {
    throw InputError({path}, key, "cannot be opened", "check its permissions");
  }
}

}  // namespace reamsim::ct
