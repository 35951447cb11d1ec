// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>
#include <algorithm>
#include <cstring>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

InputError unreadable(const std::string& path, const std::string& key) {
  return {{path}, key, "the pixels cannot be read: the file is truncated or damaged", "give a complete file"};
}

}  // namespace

DicomFrames::DicomFrames(const std::string& path, const std::string& key) {
  const QuietLibraries quiet;
  gdcm::Trace::WarningOn();  // GDCM reports missing pixels in no other way
  try {
    if (!take_plain(path, key)) decode(path, key);
    const std::size_t pixels =
        static_cast<std::size_t>(dims_.x()) * static_cast<std::size_t>(dims_.y()) * static_cast<std::size_t>(dims_.z());
    if (pixels == 0 || raw_.size() < pixels * static_cast<std::size_t>(bytes_per_pixel_)) throw unreadable(path, key);
    if (quiet.reports_missing_voxels()) throw unreadable(path, key);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    throw unreadable(path, key);
  }
}

void DicomFrames::set_format(const std::string& path, const std::string& key, int samples, int bits, int stored,
                             int high_bit, bool is_signed) {
  if (samples != 1 || (bits != 8 && bits != 16 && bits != 32)) {
    throw InputError({path}, key, fmt::format("pixels of {} values of {} bits", samples, bits),
                     "expected one integer of 8, 16 or 32 bits; export the original series");
  }
  stored = stored >= 1 && stored <= bits ? stored : bits;
  bytes_per_pixel_ = bits / 8;
  shift_ = std::clamp(high_bit + 1 - stored, 0, bits - stored);
  mask_ = stored == 32 ? ~0U : (1U << stored) - 1;
  sign_ = is_signed ? 1U << (stored - 1) : 0;
}

bool DicomFrames::take_plain(const std::string& path, const std::string& key) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) throw unreadable(path, key);
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  const DicomValues values(data);
  const gdcm::ByteValue* value = values.raw({0x7fe0, 0x0010});
  const gdcm::TransferSyntax syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  if (value == nullptr || syntax == gdcm::TransferSyntax::ExplicitVRBigEndian) return false;
  set_format(path, key, std::max(1, values.short_integer({0x0028, 0x0002})), values.short_integer({0x0028, 0x0100}),
             values.short_integer({0x0028, 0x0101}), values.short_integer({0x0028, 0x0102}),
             values.short_integer({0x0028, 0x0103}) == 1);
  dims_ = Vec3i(values.short_integer({0x0028, 0x0011}), values.short_integer({0x0028, 0x0010}),
                std::clamp(values.integer({0x0028, 0x0008}, 1), 1, 1 << 24));
  raw_.assign(value->GetPointer(), value->GetPointer() + value->GetLength());
  return true;
}

void DicomFrames::decode(const std::string& path, const std::string& key) {
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) throw unreadable(path, key);
  const gdcm::Image& image = reader.GetImage();
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  set_format(path, key, format.GetSamplesPerPixel(), format.GetBitsAllocated(), format.GetBitsStored(),
             format.GetHighBit(), format.GetPixelRepresentation() == 1);
  const unsigned* size = image.GetDimensions();
  dims_ = Vec3i(static_cast<int>(size[0]), static_cast<int>(size[1]),
                image.GetNumberOfDimensions() > 2 ? static_cast<int>(size[2]) : 1);
  raw_.resize(image.GetBufferLength());
  if (!image.GetBuffer(raw_.data())) throw unreadable(path, key);
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
