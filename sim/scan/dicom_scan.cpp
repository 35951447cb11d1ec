// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_stack.h"
#include "sim/scan/image_io.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

class DicomScan : public ScanSource {
 public:
  DicomScan(const std::string& folder, const std::string& key, const DicomChoice& choice, Diagnostics& report)
      : key_(key) {
    const SeriesChoice chosen = parse_series_choice(choice.series, folder);
    const DicomFolder found = find_dicom_series(folder, key, report);
    const DicomSeries& series = choose_series(found, chosen, choice.any_modality, report);
    if (series.modality != "CT") {
      report.warn(folder + ": modality " + (series.modality.empty() ? "unknown" : series.modality) +
                  ", not CT; thresholds and densities are wrong unless its values are HU");
    }
    stack_ = stack_slices(series, chosen, found, key, choice.resample, report);
    name_ = series.description.empty() ? "" : " \"" + series.description + "\"";
    check_fits_in_memory(static_cast<double>(stack_.geometry.size()), sizeof(float), folder, key_);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return stack_.geometry; }
  [[nodiscard]] std::string description() const override {
    const std::size_t slices = stack_.slices.size();
    std::string out =
        "DICOM series" + name_ + " of " + std::to_string(stack_.files) + (stack_.files == 1 ? " file, " : " files, ");
    if (static_cast<std::size_t>(stack_.files) != slices) out += std::to_string(slices) + " frames, ";
    return out + stack_.pixel_type;
  }
  [[nodiscard]] double kvp() const override { return stack_.kvp; }

  [[nodiscard]] Scan read(const IndexBox& box) const override {
    const IndexBox in_slice{{box.start.x(), box.start.y(), 0}, {box.size.x(), box.size.y(), 1}};
    const auto slices = [&](std::size_t first, std::size_t last) {
      const auto begin = stack_.slices.begin();
      return read_slices({begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last) + 1},
                         in_slice, key_);
    };
    const auto first = static_cast<std::size_t>(box.start.z());
    const std::size_t last = first + static_cast<std::size_t>(box.size.z()) - 1;
    const ScanGeometry part = part_of(stack_.geometry, box);
    if (stack_.blends.empty()) return {part, slices(first, last)};
    const std::size_t lowest = stack_.blends[first].below;
    const std::vector<float> source = slices(lowest, stack_.blends[last].below + 1);
    return {part, blended(source, first, last, lowest)};
  }

 private:
  /// Slices `first` to `last`, interpolated between those of `source`, the first of which is slice `lowest`.
  [[nodiscard]] std::vector<float> blended(const std::vector<float>& source, std::size_t first, std::size_t last,
                                           std::size_t lowest) const {
    const std::size_t slices = stack_.blends[last].below + 2 - lowest;
    const std::size_t pixels = source.size() / slices;
    std::vector<float> out;
    out.reserve(pixels * (last - first + 1));
    for (std::size_t k = first; k <= last; ++k) {
      const SliceBlend& blend = stack_.blends[k];
      const float* low = source.data() + (blend.below - lowest) * pixels;
      const float* high = low + pixels;
      for (std::size_t n = 0; n < pixels; ++n) {
        const double value = (1 - blend.weight) * double{low[n]} + blend.weight * double{high[n]};
        out.push_back(static_cast<float>(value));
      }
    }
    return out;
  }

  std::string key_;
  std::string name_;
  DicomStack stack_;
};

}  // namespace

std::unique_ptr<ScanSource> open_dicom(const std::string& path, const std::string& key, const DicomChoice& choice,
                                       Diagnostics& report) {
  return std::make_unique<DicomScan>(path, key, choice, report);
}

}  // namespace reamsim::ct
