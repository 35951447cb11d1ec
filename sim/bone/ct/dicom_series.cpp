#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "sim/base/error.h"
#include "sim/bone/ct/complete.h"
#include "sim/bone/ct/dicom_probe.h"
#include "sim/bone/ct/image_file.h"
#include "sim/bone/ct/quiet.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

/// Neighbouring slices may differ from the mean distance by this share before a slice counts as missing.
constexpr double kSpacingTolerance = 0.05;

struct Slice {
  std::string path;
  ScanGeometry geometry;  ///< the file's own; z from its header, which need not be the distance to the next slice
  double height_mm = 0;   ///< of its origin along the slice normal
};

/// Slices that belong together: the same series number in the files, size, spacing and axes.
using SeriesKey = std::string;

/// The files of a folder in the order of their names, so that nothing depends on the file system's order.
std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_dicom(itk::GDCMImageIO& io, const std::string& file) {
  const QuietLibraries quiet;
  try {
    return io.CanReadFile(file.c_str());
  } catch (const std::exception&) {
    return false;
  }
}

SeriesKey series_of(itk::GDCMImageIO& io, const ScanGeometry& geometry) {
  std::string uid;
  io.GetValueFromTag("0020|000e", uid);
  std::string key = uid + words(" %dx%d", geometry.dims.x(), geometry.dims.y());
  for (const double step_mm : geometry.step_mm.leftCols<2>().reshaped())
    key += words(" %ld", std::lround(1e3 * step_mm));
  return key;
}

/// Whether a DICOM file holds an image; reports and plans do not. Throws InputError where the image is cut off.
bool read_image_header(itk::GDCMImageIO& io, const std::string& file, const std::string& key) {
  const QuietLibraries quiet;
  try {
    io.SetFileName(file);
    io.ReadImageInformation();
  } catch (const std::exception&) {
    return false;
  }
  if (says_incomplete(quiet.output())) throw InputError({file}, key, "the slice is cut off", "it must be complete");
  return true;
}

/// Each DICOM image of a folder by its series.
std::map<SeriesKey, std::vector<Slice>> read_headers(const std::string& folder, const std::string& key,
                                                     Report& report) {
  std::map<SeriesKey, std::vector<Slice>> series;
  std::vector<std::string> left_out;
  const std::vector<std::string> files = files_in(folder);
  check_dicom_is_survived(files, key);
  for (const std::string& file : files) {
    const auto io = itk::GDCMImageIO::New();
    if (!is_dicom(*io, file)) continue;
    if (!read_image_header(*io, file, key)) {
      left_out.push_back(file);
      continue;
    }
    const ScanGeometry geometry = geometry_of(*io, file, key, true);
    series[series_of(*io, geometry)].push_back({file, geometry, 0});
  }
  if (!left_out.empty()) {
    report.warn(folder + ": " + std::to_string(left_out.size()) +
                " DICOM files without a readable image are left out, " + left_out.front() + " the first");
  }
  return series;
}

/// The series with the most slices. Several in a folder are usual (a scout, another kernel), so this is a warning.
std::vector<Slice> choose_series(const std::string& folder, const std::string& key, Report& report) {
  const auto all = read_headers(folder, key, report);
  if (all.empty()) throw InputError({folder}, key, "no DICOM image in this folder", "expected one DICOM series");
  const auto most = std::max_element(all.begin(), all.end(),
                                     [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  if (all.size() > 1) {
    report.warn(folder + ": " + std::to_string(all.size()) + " DICOM series; the one with the most slices is used (" +
                std::to_string(most->second.size()) + " slices)");
  }
  return most->second;
}

/// Slices in the order of their position along the normal of the first, which must be evenly spaced.
void sort_slices(std::vector<Slice>& slices, const std::string& folder, const std::string& key) {
  const ScanGeometry first = slices.front().geometry;
  const Vec3 normal = first.step_mm.col(0).cross(first.step_mm.col(1)).normalized();
  for (Slice& slice : slices) {
    if (slice.geometry.dims.z() != 1) {
      throw InputError({slice.path}, key, "a volume by itself, among others", "expected slices, or one file alone");
    }
    slice.height_mm = normal.dot(slice.geometry.origin_mm);
  }
  std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.height_mm < b.height_mm; });
  const double mean = (slices.back().height_mm - slices.front().height_mm) / static_cast<double>(slices.size() - 1);
  for (std::size_t k = 1; k < slices.size(); ++k) {
    const double gap = slices[k].height_mm - slices[k - 1].height_mm;
    if (mean > 0 && std::abs(gap - mean) <= kSpacingTolerance * mean) continue;
    const std::string text = words("slices lie %.3f mm apart where the mean is %.3f mm: ", gap, mean);
    throw InputError({folder}, key, text + slices[k - 1].path + " and " + slices[k].path,
                     "expected evenly spaced slices, none missing and none twice");
  }
}

class DicomScan : public ScanSource {
 public:
  DicomScan(const std::string& folder, const std::string& key, Report& report) : folder_(folder), key_(key) {
    slices_ = choose_series(folder, key, report);
    geometry_ = slices_.front().geometry;
    if (slices_.size() == 1 && geometry_.dims.z() == 1) {
      throw InputError({folder}, key, "one DICOM slice", "expected the slices of a volume, at least two");
    }
    if (slices_.size() > 1) stack_slices();
    check_fits_in_memory(static_cast<double>(geometry_.size()), sizeof(float), folder_, key_);
    const auto io = reader(0);
    pixel_type_ = pixel_type_of(*io);
    is_unsigned_ = has_unsigned_pixels(*io);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return geometry_; }
  [[nodiscard]] std::string description() const override {
    return "DICOM series of " + std::to_string(slices_.size()) + (slices_.size() == 1 ? " file, " : " files, ") +
           pixel_type_;
  }
  [[nodiscard]] bool is_unsigned() const override { return is_unsigned_; }

  [[nodiscard]] Scan read(const IndexBox& box) const override {
    if (slices_.size() == 1) return {part_of(geometry_, box), read_voxels(*reader(0), box, slices_[0].path, key_)};
    Scan scan{part_of(geometry_, box), {}};
    scan.value.reserve(static_cast<std::size_t>(box.voxels()));
    const IndexBox in_slice{{box.start.x(), box.start.y(), 0}, {box.size.x(), box.size.y(), 1}};
    for (int k = 0; k < box.size.z(); ++k) {
      const std::size_t slice = static_cast<std::size_t>(box.start.z() + k);
      const std::vector<float> values = read_voxels(*reader(slice), in_slice, slices_[slice].path, key_);
      scan.value.insert(scan.value.end(), values.begin(), values.end());
    }
    return scan;
  }

 private:
  void stack_slices() {
    sort_slices(slices_, folder_, key_);
    geometry_ = slices_.front().geometry;
    geometry_.dims.z() = static_cast<int>(slices_.size());
    // From the positions, not the header's slice thickness; so a tilted gantry comes out as the shear that it is.
    geometry_.step_mm.col(2) = (slices_.back().geometry.origin_mm - slices_.front().geometry.origin_mm) /
                               static_cast<double>(slices_.size() - 1);
  }

  /// A reader per call: every slice has its own rescale slope and intercept.
  [[nodiscard]] itk::GDCMImageIO::Pointer reader(std::size_t slice) const {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(slices_[slice].path);
    read_header(*io, slices_[slice].path, key_, "DICOM");
    return io;
  }

  std::string folder_;
  std::string key_;
  std::vector<Slice> slices_;
  ScanGeometry geometry_;
  std::string pixel_type_;
  bool is_unsigned_ = false;
};

}  // namespace

std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key, Report& report) {
  return std::make_unique<DicomScan>(path, key, report);
}

}  // namespace reamsim::ct
