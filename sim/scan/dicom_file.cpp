// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom.h"

#include <fmt/core.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>
#include <gdcmTrace.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "sim/base/file.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/dicom_values.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace {

constexpr const char* kCtStorage = "1.2.840.10008.5.1.4.1.1.2";

/// Of the functional groups, the sequences that hold what a slice has at the top of its file.
const gdcm::Tag kMacros[] = {
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
  const std::string flag = values.text({0x0028, 0x2110});
  const Loss loss = loss_of_syntax(syntax);
  if (flag != "01" && loss != Loss::certain && !(loss == Loss::possible && flag.empty())) return "";
  std::string out = values.text({0x0028, 0x2114});  // method
  if (out.empty()) out = name_of_syntax(syntax).empty() ? "method unknown" : name_of_syntax(syntax);
  const std::string ratio = values.text({0x0028, 0x2112});
  return out + (ratio.empty() ? "" : ", ratio " + ratio);
}

/// The directions of rows and columns, made perpendicular, because they are written with few decimals.
SliceAxes axes_from(const std::vector<double>& cosines) {
  const Vec3 columns = Vec3(cosines[3], cosines[4], cosines[5]).stableNormalized();
  const Vec3 normal = Vec3(cosines[0], cosines[1], cosines[2]).cross(columns).stableNormalized();
  SliceAxes out;
  out.col(0) = columns.cross(normal).stableNormalized();
  out.col(1) = normal.cross(out.col(0));
  return out;
}

/// What the slice, or one of the functional groups of a frame, says about its place and its values.
void fill_place(const DicomValues& values, DicomHeader& header) {
  const std::vector<double> spacing = values.numbers({0x0028, 0x0030});
  if (!spacing.empty()) header.pixel_spacing_mm = Vec2(spacing[spacing.size() > 1 ? 1 : 0], spacing[0]);
  if (spacing.size() == 1) header.assumed = "the pixel spacing (0028,0030) is one number, taken for rows and columns";
  const gdcm::Tag position_tag(0x0020, 0x0032);
  const std::vector<double> position = values.numbers(position_tag);
  if (position.size() >= 3) {
    header.position_mm = Vec3(position[0], position[1], position[2]);
    header.position_text = values.text(position_tag);
  }
  const std::vector<double> cosines = values.numbers({0x0020, 0x0037});
  if (cosines.size() >= 6) header.axes = axes_from(cosines);
  const double thickness_mm = values.number({0x0018, 0x0050}, header.slice_spacing_mm);
  header.slice_spacing_mm = std::abs(values.number({0x0018, 0x0088}, thickness_mm));
  header.kvp = values.number({0x0018, 0x0060}, header.kvp);
  const std::vector<double> intercept = values.numbers({0x0028, 0x1052}), slope = values.numbers({0x0028, 0x1053});
  header.rescales = header.rescales || !intercept.empty() || !slope.empty();
  if (!intercept.empty()) header.intercept = intercept[0];
  if (!slope.empty()) header.slope = slope[0] == 0 ? 1 : slope[0];
  if (!slope.empty() && slope[0] == 0) header.assumed = "the rescale slope (0028,1053) is 0; 1 is taken";
  add_tags(values, header.tags);
}

/// The type of the values after their rescale.
std::string dicom_pixel_type(const DicomValues& values, const DicomHeader& header) {
  const auto is_whole = [](double x) { return x == std::floor(x); };
  if (!is_whole(header.slope) || !is_whole(header.intercept)) return "float";
  const bool is_signed = values.short_integer({0x0028, 0x0103}) == 1 || header.intercept < 0 || header.slope < 0;
  return (is_signed ? "int" : "uint") + std::to_string(values.short_integer({0x0028, 0x0100}));
}

DicomHeader header_of_file(const DicomValues& values, const std::string& path, const std::string& syntax) {
  DicomHeader header;
  header.path = path;
  header.rows = values.short_integer({0x0028, 0x0010});
  header.columns = values.short_integer({0x0028, 0x0011});
  header.series_uid = values.text({0x0020, 0x000e});
  header.instance_uid = values.text({0x0008, 0x0018});
  header.sop_class = values.text({0x0008, 0x0016});
  header.description = values.text({0x0008, 0x103e});
  header.kernel = values.text({0x0018, 0x1210});
  header.modality = values.text({0x0008, 0x0060});
  if (header.modality.empty() && header.sop_class == kCtStorage) header.modality = "CT";
  header.photometric = values.text({0x0028, 0x0004});
  header.series_number = values.integer({0x0020, 0x0011}, 0);
  header.frames = values.integer({0x0028, 0x0008}, 1);
  header.images_in_acquisition = values.integer({0x0020, 0x1002}, 0);
  const gdcm::Tag instance_number(0x0020, 0x0013);
  if (!values.numbers(instance_number).empty()) header.instance_number = values.integer(instance_number, 0);
  header.lossy = lossy_words(values, syntax);
  fill_place(values, header);
  header.pixel_type = dicom_pixel_type(values, header);
  return header;
}

void fill_from_groups(const DicomValues& groups, DicomHeader& header) {
  for (const gdcm::Tag& macro : kMacros) {
    const std::vector<DicomValues> items = groups.items(macro);
    if (!items.empty()) fill_place(items.front(), header);
  }
}

/// The frames of a file with functional groups; the file as a whole without them.
std::vector<DicomHeader> frames_of(const DicomValues& values, const DicomHeader& file) {
  const std::vector<DicomValues> frames = values.items({0x5200, 0x9230});
  if (file.position_mm || frames.empty() || frames.size() != static_cast<std::size_t>(std::max(file.frames, 1))) {
    return {file};
  }
  DicomHeader shared = file;
  const std::vector<DicomValues> of_all = values.items({0x5200, 0x9229});
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

/// Files that may crash the reader before the folder is refused.
constexpr std::size_t kMostCrashes = 20;
/// What headers may take: those of a large multi-frame file are many.
constexpr std::uint64_t kHeadersPerFileByte = 4;

/// Limits for the largest of the files, with room for `result_per_file_byte` bytes of result for each of theirs.
ReadLimits limits_for(const std::vector<std::string>& files, std::uint64_t result_per_file_byte) {
  constexpr std::uint64_t kResultPerFile = 1 << 16, kMostPerFile = 1 << 26;
  ReadLimits limits;
  std::uint64_t largest = 0;
  for (const std::string& file : files) {
    const std::uint64_t bytes = bytes_of_file(file);
    largest = std::max(largest, bytes);
    limits.result_bytes += kResultPerFile + std::min(result_per_file_byte * bytes, kMostPerFile);
  }
  limits.files = static_cast<int>(files.size());
  return limits.with(largest, 2 * largest);
}

/// The headers of all files; those of `damaged` ones are not read.
void put_headers(ResultWriter& out, const std::vector<std::string>& files, const std::vector<std::string>& damaged) {
  for (const std::string& path : files) {
    DicomFile file{DicomKind::damaged, "", {}};
    if (std::ranges::find(damaged, path) == damaged.end()) {
      out.begin_file(path);
      file = read_dicom_header(path);
    }
    out.put(file);
  }
}

/// The decoded pixels of a DICOM file.
class DicomFrames {
 public:
  /// Throws InputError: truncated, damaged, not one integer per pixel.
  explicit DicomFrames(const ForeignFile& file) {
    const QuietLibraries quiet;
    gdcm::Trace::WarningOn();  // GDCM reports missing pixels in no other way
    try {
      if (!take_plain(file)) decode(file);
      const auto pixels = static_cast<std::size_t>(dims_.cast<std::int64_t>().prod());
      if (pixels == 0 || raw_.size() < pixels * static_cast<std::size_t>(bytes_per_pixel_)) throw unreadable(file);
      if (quiet.reports_missing_voxels()) throw unreadable(file);
    } catch (const InputError&) {
      throw;
    } catch (const std::exception&) {
      throw unreadable(file);
    }
  }

  /// Columns, rows, frames.
  [[nodiscard]] const Vec3i& dims() const { return dims_; }

  /// Writes the pixels of a frame in a box (whose third axis is not used), as slope·value + intercept.
  void copy(int frame, const IndexBox& box, double slope, double intercept, float* out) const {
    const auto bytes = static_cast<std::size_t>(bytes_per_pixel_);
    for (int j = 0; j < box.size.y(); ++j) {
      const char* at = raw_.data() + bytes * index_in(dims_, {box.start.x(), box.start.y() + j, frame});
      for (int i = 0; i < box.size.x(); ++i, at += bytes) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, at, bytes);  // GDCM decodes to this machine's byte order
        bits = (bits >> shift_) & mask_;
        const double value = sign_ == 0 ? double(bits) : static_cast<std::int32_t>((bits ^ sign_) - sign_);
        *out++ = static_cast<float>(slope * value + intercept);
      }
    }
  }

 private:
  void set_format(const ForeignFile& file, int samples, int bits, int stored, int high_bit, bool is_signed) {
    if (samples != 1 || (bits != 8 && bits != 16 && bits != 32)) {
      throw file.error(fmt::format("pixels of {} values of {} bits", samples, bits),
                       "expected one integer of 8, 16 or 32 bits; export the original series");
    }
    stored = stored >= 1 && stored <= bits ? stored : bits;
    bytes_per_pixel_ = bits / 8;
    shift_ = std::clamp(high_bit + 1 - stored, 0, bits - stored);
    mask_ = stored == 32 ? ~0U : (1U << stored) - 1;
    sign_ = is_signed ? 1U << (stored - 1) : 0;
  }

  /// Takes pixels that are not compressed, of any kind of file. False: they are compressed.
  bool take_plain(const ForeignFile& file) {
    gdcm::Reader reader;
    reader.SetFileName(file.path.c_str());
    if (!reader.Read()) throw unreadable(file);
    const DicomValues values(reader.GetFile().GetDataSet());
    const gdcm::ByteValue* value = values.raw({0x7fe0, 0x0010});
    const gdcm::TransferSyntax syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    if (value == nullptr || syntax == gdcm::TransferSyntax::ExplicitVRBigEndian ||
        syntax == gdcm::TransferSyntax::ImplicitVRBigEndianPrivateGE) {
      return false;
    }
    set_format(file, std::max(1, values.short_integer({0x0028, 0x0002})), values.short_integer({0x0028, 0x0100}),
               values.short_integer({0x0028, 0x0101}), values.short_integer({0x0028, 0x0102}),
               values.short_integer({0x0028, 0x0103}) == 1);
    dims_ = Vec3i(values.short_integer({0x0028, 0x0011}), values.short_integer({0x0028, 0x0010}),
                  std::clamp(values.integer({0x0028, 0x0008}, 1), 1, 1 << 24));
    raw_.assign(value->GetPointer(), value->GetPointer() + value->GetLength());
    return true;
  }

  void decode(const ForeignFile& file) {
    gdcm::ImageReader reader;
    reader.SetFileName(file.path.c_str());
    if (!reader.Read()) throw unreadable(file);
    const gdcm::Image& image = reader.GetImage();
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    set_format(file, format.GetSamplesPerPixel(), format.GetBitsAllocated(), format.GetBitsStored(),
               format.GetHighBit(), format.GetPixelRepresentation() == 1);
    const unsigned* size = image.GetDimensions();
    dims_ = Vec3i(static_cast<int>(size[0]), static_cast<int>(size[1]),
                  image.GetNumberOfDimensions() > 2 ? static_cast<int>(size[2]) : 1);
    raw_.resize(image.GetBufferLength());
    if (!image.GetBuffer(raw_.data())) throw unreadable(file);
  }

  Vec3i dims_ = Vec3i::Zero();
  int bytes_per_pixel_ = 2;
  int shift_ = 0;  ///< of the lowest stored bit
  std::uint32_t mask_ = 0;
  std::uint32_t sign_ = 0;  ///< the sign bit after the shift; 0: unsigned
  std::vector<char> raw_;
};

void put_slices(ResultWriter& out, const std::vector<SliceSource>& slices, const IndexBox& in_slice) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  float* const first = out.array<float>(pixels * slices.size());
  const Vec3i end = in_slice.start + in_slice.size;
  std::map<std::string, std::vector<std::size_t>> slices_of;
  for (std::size_t n = 0; n < slices.size(); ++n) slices_of[slices[n].path].push_back(n);
  for (const auto& [path, numbers] : slices_of) {
    out.begin_file(path);
    const ForeignFile file{path, kScanKey};
    const DicomFrames frames(file);
    const Vec3i& dims = frames.dims();
    for (const std::size_t n : numbers) {
      const int frame = std::max(slices[n].frame, 0);
      if (end.x() > dims.x() || end.y() > dims.y() || frame >= dims.z()) {
        throw file.error(fmt::format("the file has {} frames of {}x{} pixels", dims.z(), dims.x(), dims.y()),
                         "its header claims more: give a complete file");
      }
      frames.copy(frame, in_slice, slices[n].slope, slices[n].intercept, first + n * pixels);
    }
  }
}

}  // namespace

InputError unreadable(const ForeignFile& file) {
  const std::string syntax = syntax_in_file(file.path);
  const std::string name = name_of_syntax(syntax);
  if (name.empty()) return cut_off(file);
  return file.error("the pixels cannot be decoded from " + name + " (" + syntax + ")",
                    "the file is truncated or damaged, or coded in an unusual way: " + how_to_decode(name));
}

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

std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const ForeignFile& folder) {
  std::vector<std::string> damaged;
  while (true) {
    try {
      ResultReader result = read_in_child<put_headers>(folder, limits_for(files, kHeadersPerFileByte), files, damaged);
      std::vector<DicomFile> out(files.size());
      for (DicomFile& file : out) result(file);
      return out;
    } catch (const InputError& error) {
      // A header is at most DicomKind::damaged, so an error names the file on which the child died.
      const std::string& path = error.mistakes().front().where.file;
      const bool retried = std::ranges::count(damaged, path) > 0;
      if (damaged.size() >= kMostCrashes || retried || !std::ranges::count(files, path)) throw;
      damaged.push_back(path);
    }
  }
}

bool looks_like_dicom(const std::string& path) {
  const std::string start = read_file_start(path, 132);
  if (start.size() == 132 && start.ends_with("DICM")) return true;
  const bool of_first_group = start.size() >= 4 && (start[0] == 2 || start[0] == 8) && start[1] == 0 && start[3] == 0;
  return of_first_group && start[2] != 0;
}

std::vector<std::string> files_below(const std::string& path) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(path)) return {path};
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied)) {
    std::error_code ignored;
    if (entry.is_regular_file(ignored)) files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  return files;
}

std::vector<float> read_slices(const std::vector<SliceSource>& slices, const IndexBox& in_slice) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  std::vector<std::string> files;
  double most_pixels = 0;
  for (const SliceSource& slice : slices) {
    files.push_back(slice.path);
    most_pixels = std::max(most_pixels, slice.file_pixels);
  }
  constexpr double kBytesPerPixel = 12;  // coded, decoded by frame, and decoded as a whole
  ReadLimits limits = limits_for(files, 0).with(0, static_cast<std::uint64_t>(kBytesPerPixel * most_pixels));
  limits.result_bytes += pixels * files.size() * sizeof(float);
  return read_in_child<put_slices>({files.front(), kScanKey}, limits, slices, in_slice)
      .array_of<float>(pixels * files.size());
}

}  // namespace reamsim::ct
