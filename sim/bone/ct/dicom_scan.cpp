#include <itkGDCMImageIO.h>

#include "sim/base/error.h"
#include "sim/bone/ct/dicom_series.h"
#include "sim/bone/ct/dicom_stack.h"
#include "sim/bone/ct/image_file.h"

namespace reamsim::ct {

namespace {

class DicomScan : public ScanSource {
 public:
  DicomScan(const std::string& folder, const std::string& key, const DicomChoice& choice, Report& report)
      : folder_(folder), key_(key) {
    const DicomFolder found = find_dicom_series(folder, key, report);
    const DicomSeries& series = choose_series(found, choice, folder, report);
    if (series.modality != "CT") {
      report.warn(folder + ": modality " + (series.modality.empty() ? "unknown" : series.modality) +
                  ", not CT; thresholds and densities are wrong unless its values are HU");
    }
    stack_ = stack_slices(series, found.damaged, key, report);
    name_ = series.description.empty() ? "" : " \"" + series.description + "\"";
    check_fits_in_memory(static_cast<double>(stack_.geometry.size()), sizeof(float), folder_, key_);
    const auto io = reader(0);
    pixel_type_ = pixel_type_of(*io);
    is_unsigned_ = has_unsigned_pixels(*io);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return stack_.geometry; }
  [[nodiscard]] std::string description() const override {
    return "DICOM series" + name_ + " of " + std::to_string(stack_.path.size()) + " files, " + pixel_type_;
  }
  [[nodiscard]] bool is_unsigned() const override { return is_unsigned_; }

  [[nodiscard]] Scan read(const IndexBox& box) const override {
    Scan scan{part_of(stack_.geometry, box), {}};
    scan.value.reserve(static_cast<std::size_t>(box.voxels()));
    const IndexBox in_slice{{box.start.x(), box.start.y(), 0}, {box.size.x(), box.size.y(), 1}};
    for (int k = 0; k < box.size.z(); ++k) {
      const std::size_t slice = static_cast<std::size_t>(box.start.z() + k);
      const std::vector<float> values = read_voxels(*reader(slice), in_slice, stack_.path[slice], key_);
      scan.value.insert(scan.value.end(), values.begin(), values.end());
    }
    return scan;
  }

 private:
  /// A reader per call: every slice has its own rescale slope and intercept.
  [[nodiscard]] itk::GDCMImageIO::Pointer reader(std::size_t slice) const {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(stack_.path[slice]);
    read_header(*io, stack_.path[slice], key_, "DICOM");
    return io;
  }

  std::string folder_;
  std::string key_;
  std::string name_;
  DicomStack stack_;
  std::string pixel_type_;
  bool is_unsigned_ = false;
};

}  // namespace

std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key,
                                              const DicomChoice& choice, Report& report) {
  return std::make_unique<DicomScan>(path, key, choice, report);
}

}  // namespace reamsim::ct
