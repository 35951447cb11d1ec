// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "sim/base/error.h"
#include "sim/scan/dicom_files.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

constexpr const char* kCtStorage = "1.2.840.10008.5.1.4.1.1.2";

constexpr DicomTag kSopClass{0x0008, 0x0016};
constexpr DicomTag kSopInstance{0x0008, 0x0018};
constexpr DicomTag kModality{0x0008, 0x0060};
constexpr DicomTag kSeriesDescription{0x0008, 0x103e};
constexpr DicomTag kSliceThickness{0x0018, 0x0050};
constexpr DicomTag kKvp{0x0018, 0x0060};
constexpr DicomTag kSliceSpacing{0x0018, 0x0088};
constexpr DicomTag kKernel{0x0018, 0x1210};
constexpr DicomTag kSeriesUid{0x0020, 0x000e};
constexpr DicomTag kSeriesNumber{0x0020, 0x0011};
constexpr DicomTag kInstanceNumber{0x0020, 0x0013};
constexpr DicomTag kPosition{0x0020, 0x0032};
constexpr DicomTag kOrientation{0x0020, 0x0037};
constexpr DicomTag kImagesInAcquisition{0x0020, 0x1002};
constexpr DicomTag kPhotometric{0x0028, 0x0004};
constexpr DicomTag kFrames{0x0028, 0x0008};
constexpr DicomTag kRows{0x0028, 0x0010};
constexpr DicomTag kColumns{0x0028, 0x0011};
constexpr DicomTag kPixelSpacing{0x0028, 0x0030};
constexpr DicomTag kBitsAllocated{0x0028, 0x0100};
constexpr DicomTag kPixelRepresentation{0x0028, 0x0103};
constexpr DicomTag kIntercept{0x0028, 0x1052};
constexpr DicomTag kSlope{0x0028, 0x1053};
constexpr DicomTag kLossy{0x0028, 0x2110};
constexpr DicomTag kLossyRatio{0x0028, 0x2112};
constexpr DicomTag kLossyMethod{0x0028, 0x2114};
constexpr DicomTag kSharedGroups{0x5200, 0x9229};
constexpr DicomTag kFrameGroups{0x5200, 0x9230};

/// Of the functional groups, the sequences that hold what a slice has at the top of its file.
constexpr DicomTag kMacros[] = {
    {0x0020, 0x9111},  // frame content
    {0x0020, 0x9113},  // plane position
    {0x0020, 0x9116},  // plane orientation
    {0x0028, 0x9110},  // pixel measures
    {0x0028, 0x9145},  // pixel value transformation
    {0x0018, 0x9329},  // CT image frame type
    {0x0018, 0x9314},  // CT reconstruction
    {0x0018, 0x9325},  // CT X-ray details
    {0x0018, 0x9118},  // cardiac synchronization
    {0x0020, 0x9310},  // temporal position
    {0x0018, 0x9226},  // MR image frame type
    {0x0018, 0x9114},  // MR echo
    {0x0062, 0x000a},  // segment identification
    {0x0020, 0x9170},  // converted attributes, shared
    {0x0020, 0x9171}   // converted attributes, of a frame
};

std::string lossy_words(const DicomValues& values, const std::string& syntax) {
  const std::string flag = values.text(kLossy);
  const Loss loss = loss_of_syntax(syntax);
  if (flag != "01" && loss != Loss::certain && !(loss == Loss::possible && flag.empty())) return "";
  std::string out = values.text(kLossyMethod);
  if (out.empty()) out = name_of_syntax(syntax).empty() ? "method unknown" : name_of_syntax(syntax);
  const std::string ratio = values.text(kLossyRatio);
  return out + (ratio.empty() ? "" : ", ratio " + ratio);
}

/// What the slice, or one of the functional groups of a frame, says about its place and its values.
void fill_place(const DicomValues& values, DicomHeader& header) {
  const std::vector<double> spacing = values.numbers(kPixelSpacing);
  if (spacing.size() >= 2) header.pixel_spacing_mm = Vec2(spacing[1], spacing[0]);
  const std::vector<double> position = values.numbers(kPosition);
  if (position.size() >= 3) {
    header.position_mm = Vec3(position[0], position[1], position[2]);
    header.position_text = values.text(kPosition);
  }
  const std::vector<double> axes = values.numbers(kOrientation);
  if (axes.size() >= 6) {
    SliceAxes out;
    out.col(0) = Vec3(axes[0], axes[1], axes[2]).stableNormalized();
    out.col(1) = Vec3(axes[3], axes[4], axes[5]).stableNormalized();
    header.axes = out;
  }
  header.slice_spacing_mm =
      std::abs(values.number(kSliceSpacing, values.number(kSliceThickness, header.slice_spacing_mm)));
  header.kvp = values.number(kKvp, header.kvp);
  const std::vector<double> intercept = values.numbers(kIntercept);
  const std::vector<double> slope = values.numbers(kSlope);
  header.rescales = header.rescales || !intercept.empty() || !slope.empty();
  if (!intercept.empty()) header.intercept = intercept[0];
  if (!slope.empty()) header.slope = slope[0];
  add_tags(values, header.tags);
}

/// The type of the values after their rescale.
std::string dicom_pixel_type(const DicomValues& values, const DicomHeader& header) {
  const auto is_whole = [](double x) { return x == std::floor(x); };
  if (!is_whole(header.slope) || !is_whole(header.intercept)) return "float";
  const bool is_signed = values.short_integer(kPixelRepresentation) == 1 || header.intercept < 0 || header.slope < 0;
  return (is_signed ? "int" : "uint") + std::to_string(values.short_integer(kBitsAllocated));
}

DicomHeader header_of_file(const DicomValues& values, const std::string& path, const std::string& syntax) {
  DicomHeader header;
  header.path = path;
  header.rows = values.short_integer(kRows);
  header.columns = values.short_integer(kColumns);
  header.series_uid = values.text(kSeriesUid);
  header.instance_uid = values.text(kSopInstance);
  header.sop_class = values.text(kSopClass);
  header.description = values.text(kSeriesDescription);
  header.kernel = values.text(kKernel);
  header.modality = values.text(kModality);
  if (header.modality.empty() && header.sop_class == kCtStorage) header.modality = "CT";
  header.photometric = values.text(kPhotometric);
  header.series_number = values.integer(kSeriesNumber, 0);
  header.frames = values.integer(kFrames, 1);
  header.images_in_acquisition = values.integer(kImagesInAcquisition, 0);
  if (const std::vector<double> number = values.numbers(kInstanceNumber); !number.empty()) {
    header.instance_number = values.integer(kInstanceNumber, 0);
  }
  header.lossy = lossy_words(values, syntax);
  fill_place(values, header);
  header.pixel_type = dicom_pixel_type(values, header);
  return header;
}

void fill_from_groups(const DicomValues& groups, DicomHeader& header) {
  for (const DicomTag& macro : kMacros) {
    const std::vector<DicomValues> items = groups.items(macro);
    if (!items.empty()) fill_place(items.front(), header);
  }
}

/// The frames of a file with functional groups; the file as a whole without them.
std::vector<DicomHeader> frames_of(const DicomValues& values, const DicomHeader& file) {
  const std::vector<DicomValues> frames = values.items(kFrameGroups);
  if (file.position_mm || frames.empty() || frames.size() != static_cast<std::size_t>(std::max(file.frames, 1))) {
    return {file};
  }
  DicomHeader shared = file;
  const std::vector<DicomValues> of_all = values.items(kSharedGroups);
  if (!of_all.empty()) fill_from_groups(of_all.front(), shared);
  shared.instance_number.reset();  // the file's
  std::vector<DicomHeader> out;
  for (const DicomValues& groups : frames) {
    DicomHeader frame = shared;
    frame.frame = static_cast<int>(out.size());
    fill_from_groups(groups, frame);
    if (const std::string kernel = frame.tag("ConvolutionKernel"); !kernel.empty()) frame.kernel = kernel;
    frame.instance_uid += "#" + std::to_string(frame.frame + 1);
    frame.pixel_type = dicom_pixel_type(values, frame);
    out.push_back(std::move(frame));
  }
  return out;
}

InputError unreadable(const std::string& path, const std::string& key) {
  return {{path}, key, "the pixels cannot be read: the file is truncated or damaged", "give a complete file"};
}

}  // namespace

DicomFile read_dicom_header(const std::string& path) {
  const QuietLibraries quiet;
  const std::string syntax = syntax_in_file(path);
  if (!is_supported_syntax(syntax)) {
    const std::string name = name_of_syntax(syntax);
    return {DicomKind::unsupported, name.empty() ? syntax : name + " (" + syntax + ")", {}};
  }
  if (!looks_like_dicom(path)) return {};
  gdcm::Reader reader;
  try {
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(gdcm::Tag(0x6000, 0x0000))) return {DicomKind::damaged, "", {}};  // overlays, then pixels
    const DicomValues values(reader.GetFile().GetDataSet());
    const DicomHeader header = header_of_file(values, path, syntax);
    if (header.rows == 0 || header.columns == 0) {
      // A report has no pixels; a slice of a CT always does.
      return {header.sop_class == kCtStorage ? DicomKind::damaged : DicomKind::no_image, header.modality, {}};
    }
    return {DicomKind::image, "", frames_of(values, header)};
  } catch (const std::exception&) {
    return {DicomKind::damaged, "", {}};
  }
}

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
