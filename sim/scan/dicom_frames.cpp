// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_frames.h"

#include <gdcmImageReader.h>
#include <algorithm>
#include <cstring>

#include "sim/base/error.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

InputError damaged(const std::string& path, const std::string& key) {
  return {{path}, key, "the pixels cannot be read: the file is truncated or damaged", "give a complete file"};
}

}  // namespace

DicomFrames::DicomFrames(const std::string& path, const std::string& key) {
  const QuietLibraries quiet;
  gdcm::ImageReader reader;
  try {
    reader.SetFileName(path.c_str());
    if (!reader.Read()) throw damaged(path, key);
    const gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    const int bits = format.GetBitsAllocated();
    if (format.GetSamplesPerPixel() != 1 || (bits != 8 && bits != 16 && bits != 32)) {
      throw InputError(
          {path}, key,
          "pixels of " + std::to_string(format.GetSamplesPerPixel()) + " values of " + std::to_string(bits) + " bits",
          "expected one integer of 8, 16 or 32 bits; export the original series");
    }
    const unsigned* size = image.GetDimensions();
    dims_ = Vec3i(static_cast<int>(size[0]), static_cast<int>(size[1]),
                  image.GetNumberOfDimensions() > 2 ? static_cast<int>(size[2]) : 1);
    bytes_per_pixel_ = bits / 8;
    const int stored = std::clamp<int>(format.GetBitsStored(), 1, bits);
    shift_ = std::clamp(format.GetHighBit() + 1 - stored, 0, bits - stored);
    mask_ = stored == 32 ? ~0U : (1U << stored) - 1;
    if (format.GetPixelRepresentation() == 1) sign_ = 1U << (stored - 1);
    raw_.resize(image.GetBufferLength());
    const std::size_t pixels =
        static_cast<std::size_t>(dims_.x()) * static_cast<std::size_t>(dims_.y()) * static_cast<std::size_t>(dims_.z());
    if (raw_.size() < pixels * static_cast<std::size_t>(bytes_per_pixel_)) throw damaged(path, key);
    if (!image.GetBuffer(raw_.data()) || quiet.reports_missing_voxels()) throw damaged(path, key);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    throw damaged(path, key);
  }
}

double DicomFrames::value_at(std::size_t pixel) const {
  const char* at = raw_.data() + pixel * static_cast<std::size_t>(bytes_per_pixel_);
  std::uint32_t value = 0;
  std::memcpy(&value, at, static_cast<std::size_t>(bytes_per_pixel_));  // GDCM decodes to this machine's byte order
  value = (value >> shift_) & mask_;
  if (sign_ == 0) return value;
  return static_cast<std::int32_t>((value ^ sign_) - sign_);
}

void DicomFrames::copy(int frame, const IndexBox& box, double slope, double intercept, float* out) const {
  for (int j = 0; j < box.size.y(); ++j) {
    const std::size_t first = index_in(dims_, {box.start.x(), box.start.y() + j, frame});
    for (int i = 0; i < box.size.x(); ++i) {
      *out++ = static_cast<float>(slope * value_at(first + static_cast<std::size_t>(i)) + intercept);
    }
  }
}

}  // namespace reamsim::ct
