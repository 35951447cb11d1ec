// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_files.h"

#include <gdcmReader.h>
#include <itkGDCMImageIO.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <set>

#include "sim/base/error.h"
#include "sim/isolation/read_in_child.h"
#include "sim/scan/image_io.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// Files that may crash the reader before the folder is refused.
constexpr std::size_t kMostCrashes = 20;

ReadLimits limits_for(const std::vector<std::string>& files) {
  std::uint64_t largest = 0;
  for (const std::string& file : files) largest = std::max(largest, bytes_of_file(file));
  constexpr std::uint64_t kResultPerFile = 1 << 16;
  ReadLimits limits = ReadLimits().with(largest, 2 * largest);
  limits.result_bytes += kResultPerFile * files.size();
  limits.files = static_cast<int>(files.size());
  return limits;
}

/// The headers of all files; those of `damaged` ones are not read.
void put_headers(ResultWriter& out, const std::vector<std::string>& files, const std::vector<std::string>& damaged) {
  for (const std::string& path : files) {
    DicomFile file{DicomKind::damaged, {}};
    if (std::ranges::find(damaged, path) == damaged.end()) {
      out.begin_file(path);
      file.kind = read_dicom_header(path, file.header);
    }
    put_dicom_file(out, file);
  }
}

/// Reads the headers of all files but the `damaged` ones.
std::vector<DicomFile> read_headers_but(const std::set<std::string>& damaged, const std::vector<std::string>& files,
                                        const std::string& folder, const std::string& key) {
  const std::vector<std::string> unread(damaged.begin(), damaged.end());
  ChildResult result = read_in_child<put_headers>({folder, key}, limits_for(files), files, unread);
  std::vector<DicomFile> out(files.size());
  for (DicomFile& file : out) file = take_dicom_file(result.reader());
  return out;
}

itk::GDCMImageIO::Pointer open_slice(const std::string& path, const std::string& key) {
  auto io = itk::GDCMImageIO::New();
  const QuietLibraries quiet;
  try {
    io->SetFileName(path);
    io->ReadImageInformation();
  } catch (const std::exception&) {
    throw InputError({path}, key, "the slice cannot be read: it is truncated or damaged", "give a complete file");
  }
  if (quiet.reports_missing_voxels()) throw InputError({path}, key, "the slice is truncated", "give a complete file");
  return io;
}

void put_slice_facts(ResultWriter& out, const std::vector<std::string>& files, const std::string& key) {
  for (const std::string& path : files) {
    out.begin_file(path);
    const itk::GDCMImageIO::Pointer io = open_slice(path, key);
    put_geometry(out, geometry_of(*io, path, key, true));
    out.put(pixel_type_of(*io));
  }
}

void put_slices(ResultWriter& out, const std::vector<std::string>& files, const PlainBox& box, const std::string& key) {
  const IndexBox in_slice = box.get();
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  float* place = out.array<float>(pixels * files.size());
  for (const std::string& path : files) {
    out.begin_file(path);
    const itk::GDCMImageIO::Pointer io = open_slice(path, key);
    const Vec3i dims = geometry_of(*io, path, key, true).dims;
    if (((in_slice.start + in_slice.size).array() > dims.array()).any()) {
      throw InputError({path}, key, "the slice has changed while it was read", "start again");
    }
    // Each slice has its own rescale slope and intercept, so it has its own reader.
    read_voxels(*io, in_slice, 0, path, key, place);
    place += pixels;
  }
}

}  // namespace

std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key) {
  std::set<std::string> damaged;
  while (true) {
    try {
      return read_headers_but(damaged, files, folder, key);
    } catch (const InputError& error) {
      // A header is at most DicomKind::damaged, so an error names the file on which the child died.
      const std::string& path = error.mistakes().front().where.file;
      if (damaged.size() >= kMostCrashes || !damaged.insert(path).second || !std::ranges::count(files, path)) throw;
    }
  }
}

std::vector<SliceFacts> read_slice_facts(const std::vector<std::string>& files, const std::string& key) {
  if (files.empty()) return {};
  ChildResult result = read_in_child<put_slice_facts>({files.front(), key}, limits_for(files), files, key);
  std::vector<SliceFacts> out(files.size());
  for (SliceFacts& slice : out) {
    slice.geometry = take_geometry(result.reader());
    slice.pixel_type = result.reader().text();
  }
  return out;
}

std::vector<float> read_slices(const std::vector<std::string>& files, const IndexBox& in_slice,
                               const std::string& key) {
  const auto pixels = static_cast<std::size_t>(in_slice.voxels());
  ReadLimits limits = limits_for(files);
  limits.result_bytes += pixels * files.size() * sizeof(float);
  ChildResult result = read_in_child<put_slices>({files.front(), key}, limits, files, PlainBox(in_slice), key);
  std::vector<float> out = result.reader().array<float>();
  if (out.size() != pixels * files.size()) result.reader().fail();
  return out;
}

namespace {

class DicomValues {
 public:
  explicit DicomValues(const gdcm::DataSet& data) : data_(data) {}

  [[nodiscard]] std::string bytes(std::uint16_t group, std::uint16_t element) const {
    const gdcm::Tag tag(group, element);
    if (!data_.FindDataElement(tag)) return "";
    const gdcm::ByteValue* value = data_.GetDataElement(tag).GetByteValue();
    return value == nullptr ? "" : std::string(value->GetPointer(), value->GetLength());
  }

  [[nodiscard]] std::string text(std::uint16_t group, std::uint16_t element) const {
    std::string out = bytes(group, element);
    for (char& c : out) c = c == '\0' ? ' ' : (c < 0x20 || c > 0x7e) ? '?' : c;
    const std::size_t first = out.find_first_not_of(' ');
    if (first == std::string::npos) return "";
    return out.substr(first, out.find_last_not_of(' ') - first + 1);
  }

  /// The numbers of a text "a\b\c"; empty if one of them is invalid.
  [[nodiscard]] std::vector<double> numbers(std::uint16_t group, std::uint16_t element) const {
    const std::string list = text(group, element);
    std::vector<double> out;
    for (std::size_t at = 0; at < list.size();) {
      const std::size_t end = std::min(list.find('\\', at), list.size());
      const std::string item = list.substr(at, end - at);
      char* rest = nullptr;
      const double number = std::strtod(item.c_str(), &rest);
      if (rest == item.c_str() || !std::isfinite(number)) return {};
      out.push_back(number);
      at = end + 1;
    }
    return out;
  }

  [[nodiscard]] int integer(std::uint16_t group, std::uint16_t element, int fallback) const {
    const std::vector<double> all = numbers(group, element);
    return all.empty() || std::abs(all[0]) > 1e9 ? fallback : static_cast<int>(all[0]);
  }

  /// A 16-bit number, in the byte order of this machine.
  [[nodiscard]] int short_integer(std::uint16_t group, std::uint16_t element) const {
    const std::string raw = bytes(group, element);
    std::uint16_t out = 0;
    if (raw.size() >= sizeof out) std::memcpy(&out, raw.data(), sizeof out);
    return out;
  }

 private:
  const gdcm::DataSet& data_;
};

constexpr const char* kCtStorage = "1.2.840.10008.5.1.4.1.1.2";

void fill_header(const DicomValues& values, DicomHeader& header) {
  header.series_uid = values.text(0x0020, 0x000e);
  header.instance_uid = values.text(0x0008, 0x0018);
  header.description = values.text(0x0008, 0x103e);
  header.kernel = values.text(0x0018, 0x1210);
  header.modality = values.text(0x0008, 0x0060);
  if (header.modality.empty() && values.text(0x0008, 0x0016) == kCtStorage) header.modality = "CT";
  header.photometric = values.text(0x0028, 0x0004);
  header.series_number = values.integer(0x0020, 0x0011, 0);
  header.frames = values.integer(0x0028, 0x0008, 1);
  header.rescales = !values.numbers(0x0028, 0x1052).empty() || !values.numbers(0x0028, 0x1053).empty();
  const std::vector<double> kvp = values.numbers(0x0018, 0x0060);
  if (!kvp.empty()) header.kvp = kvp[0];
  const std::vector<double> spacing = values.numbers(0x0028, 0x0030);
  if (spacing.size() >= 2) header.pixel_spacing_mm = Vec2(spacing[1], spacing[0]);
  const std::vector<double> position = values.numbers(0x0020, 0x0032);
  if (position.size() >= 3) header.position_mm = Vec3(position[0], position[1], position[2]);
  const std::vector<double> axes = values.numbers(0x0020, 0x0037);
  if (axes.size() >= 6) {
    header.normal = Vec3(axes[0], axes[1], axes[2]).cross(Vec3(axes[3], axes[4], axes[5])).stableNormalized();
  }
}

bool is_dicom(const std::string& path) {
  try {
    return itk::GDCMImageIO::New()->CanReadFile(path.c_str());
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

DicomKind read_dicom_header(const std::string& path, DicomHeader& header) {
  const QuietLibraries quiet;
  if (!is_dicom(path)) return DicomKind::other;
  gdcm::Reader reader;
  try {
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(gdcm::Tag(0x6000, 0x0000))) return DicomKind::damaged;  // overlays, then pixels
  } catch (const std::exception&) {
    return DicomKind::damaged;
  }
  const DicomValues values(reader.GetFile().GetDataSet());
  header.path = path;
  header.rows = values.short_integer(0x0028, 0x0010);
  header.columns = values.short_integer(0x0028, 0x0011);
  if (header.rows == 0 || header.columns == 0) {
    // A report has no pixels; a slice of a CT always does.
    return values.text(0x0008, 0x0016) == kCtStorage ? DicomKind::damaged : DicomKind::no_image;
  }
  fill_header(values, header);
  return DicomKind::image;
}

}  // namespace reamsim::ct
