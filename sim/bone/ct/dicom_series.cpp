#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/bone/ct/image_file.h"
#include "sim/bone/ct/quiet.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

/// Neighbouring slices may differ from the mean distance by this share before a slice counts as missing.
constexpr double kSpacingTolerance = 0.05;
/// Rows and columns of all slices must be parallel within this (direction cosines times mm).
constexpr double kAxisTolerance_mm = 1e-3;

struct Slice {
  std::string path;
  ScanGeometry geometry;  ///< the file's own; z from its header, which need not be the distance to the next slice
  double height_mm = 0;   ///< of its origin along the slice normal
};

struct Series {
  std::string uid;
  std::vector<std::string> files;
};

/// The series with the most slices. Several in a folder are usual (a scout, another kernel), so this is a warning.
Series choose_series(const std::string& folder, const std::string& key, Report& report) {
  std::vector<Series> all;
  try {
    const QuietLibraries quiet;
    const auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetInputDirectory(folder);
    for (const std::string& uid : names->GetSeriesUIDs()) all.push_back({uid, names->GetFileNames(uid)});
  } catch (const std::exception&) {
    throw InputError({folder}, key, "the folder cannot be read as DICOM", "expected a folder of DICOM slices");
  }
  std::erase_if(all, [](const Series& series) { return series.files.empty(); });
  if (all.empty()) throw InputError({folder}, key, "no DICOM image in this folder", "expected one DICOM series");
  const auto most = std::max_element(all.begin(), all.end(),
                                     [](const Series& a, const Series& b) { return a.files.size() < b.files.size(); });
  if (all.size() > 1) {
    report.warn(folder + ": " + std::to_string(all.size()) + " DICOM series; the one with the most slices is used (" +
                std::to_string(most->files.size()) + " slices)");
  }
  return *most;
}

Slice read_slice_header(const std::string& file, const std::string& key) {
  const auto io = itk::GDCMImageIO::New();
  io->SetFileName(file);
  read_header(*io, file, key, "DICOM");
  return {file, geometry_of(*io, file, key, true), 0};
}

/// Slices in the order of their position along the normal of the first, which must be evenly spaced.
void sort_slices(std::vector<Slice>& slices, const std::string& folder, const std::string& key) {
  const ScanGeometry first = slices.front().geometry;
  const Vec3 normal = first.step_mm.col(0).cross(first.step_mm.col(1)).normalized();
  for (Slice& slice : slices) {
    const ScanGeometry& own = slice.geometry;
    const bool parallel =
        (own.step_mm.leftCols<2>() - first.step_mm.leftCols<2>()).cwiseAbs().maxCoeff() < kAxisTolerance_mm;
    if (!parallel || own.dims != first.dims || own.dims.z() != 1) {
      throw InputError({slice.path}, key,
                       "this slice differs from " + slices.front().path + " in size, spacing or axes",
                       "expected the slices of one volume only");
    }
    slice.height_mm = normal.dot(own.origin_mm);
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
    const Series series = choose_series(folder, key, report);
    for (const std::string& file : series.files) slices_.push_back(read_slice_header(file, key));
    geometry_ = slices_.front().geometry;
    if (slices_.size() == 1 && geometry_.dims.z() == 1) {
      throw InputError({folder}, key, "one DICOM slice", "expected the slices of a volume, at least two");
    }
    if (slices_.size() > 1) stack_slices();
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
    check_fits_in_memory(static_cast<double>(geometry_.size()), sizeof(float), folder_, key_);
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
