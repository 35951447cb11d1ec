// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/image_io.h"

#include <fmt/core.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scan/label_map.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

constexpr const char* kDicom = "DICOM";
using Component = itk::IOComponentEnum;

/// Deflate compresses at most 1032 : 1. A file whose header claims more voxels is truncated.
constexpr double kMaxCompression = 1032;
constexpr double kHeaderSlackBytes = 1 << 16;

/// Least edge length of a voxel, mm, and greatest quotient of two of them: far beyond any scanner. What lies outside
/// is a damaged header; filters would need memory without limit.
constexpr double kLeastStep_mm = 1e-3;
constexpr double kGreatestStep_mm = 1e6;
constexpr double kMostElongated = 200;

std::string lower_extension(const std::string& path) {
  const std::string name = lower_case(fs::path(path).filename().string());
  return name.ends_with(".nii.gz") ? ".nii.gz" : fs::path(name).extension().string();
}

/// For files whose content is too damaged to tell the format.
std::string format_by_name(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".nrrd" || extension == ".nhdr") return "NRRD";
  if (extension == ".nii" || extension == ".nii.gz" || extension == ".hdr" || extension == ".img") return "NIfTI";
  if (extension == ".mha" || extension == ".mhd") return "MetaImage";
  if (extension == ".dcm") return kDicom;
  return "";
}

constexpr std::size_t kHeaderStart = 1 << 16;

/// Lines "Key = value", the first of which names the object or its dimensions.
bool is_meta_image(const std::string& start) {
  const bool begins = start.starts_with("ObjectType") || start.starts_with("NDims") || start.starts_with("Comment");
  return begins && start.find("NDims") != std::string::npos;
}

/// What the first bytes of a file say, for a file of no format that is read.
struct KnownStart {
  std::string_view bytes;
  const char* what;
  const char* advice;
};
constexpr const char* kUnpack = "unpack it";
constexpr const char* kAsMesh = "use bone.mesh for a surface";
constexpr std::array kKnownStarts{
    KnownStart{"\x1f\x8b", "compressed with gzip, and no NIfTI", kUnpack},
    KnownStart{"BZh", "compressed with bzip2", kUnpack},
    KnownStart{"PK\x03\x04", "a ZIP archive", kUnpack},
    KnownStart{"\xfd"
               "7zXZ",
               "compressed with xz", kUnpack},
    KnownStart{"7z\xbc\xaf", "a 7z archive", kUnpack},
    KnownStart{"\x89HDF", "an HDF5 or MINC 2 file", "convert it to NRRD or NIfTI (3D Slicer)"},
    KnownStart{"CDF", "a MINC 1 file", "convert it to NIfTI (mnc2nii)"},
    KnownStart{"\x89PNG", "a PNG picture", "give the scan itself"},
    KnownStart{"\xff\xd8\xff", "a JPEG picture", "give the scan itself"},
    KnownStart{"solid", "an STL mesh", kAsMesh},
    KnownStart{"ply", "a PLY mesh", kAsMesh},
    KnownStart{"OFF", "an OFF mesh", kAsMesh}};

/// Formats with header and voxels in one file, so that its length limits the number of voxels.
bool contains_its_voxels(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".nrrd" || extension == ".nii" || extension == ".nii.gz" || extension == ".mha" ||
         extension == ".dcm";
}

/// VTK's own formats, legacy and XML.
bool is_vtk(const std::string& path) {
  const std::string start = read_file_start(path, 256);
  return start.starts_with("# vtk DataFile") || start.find("<VTKFile") != std::string::npos;
}

bool can_read(itk::ImageIOBase& io, const std::string& path) {
  try {
    return io.CanReadFile(path.c_str());
  } catch (const std::exception&) {
    return false;
  }
}

template <typename Value>
void copy_region(const std::byte* raw, const itk::ImageIORegion& held, const IndexBox& box, int layers, int layer,
                 float* out) {
  const auto start = [&](unsigned axis) { return axis < held.GetImageDimension() ? held.GetIndex(axis) : 0; };
  const std::int64_t row = static_cast<std::int64_t>(held.GetSize(0));
  const std::int64_t rows = held.GetImageDimension() > 1 ? static_cast<std::int64_t>(held.GetSize(1)) : 1;
  for (int k = 0; k < box.size.z(); ++k) {
    for (int j = 0; j < box.size.y(); ++j) {
      const std::int64_t first =
          (box.start.x() - start(0)) + row * ((box.start.y() + j - start(1)) + rows * (box.start.z() + k - start(2)));
      for (int i = 0; i < box.size.x(); ++i) {
        Value value;
        const std::int64_t number = (first + i) * layers + layer;
        std::memcpy(&value, raw + number * static_cast<std::int64_t>(sizeof(Value)), sizeof(Value));
        *out++ = static_cast<float>(value);
      }
    }
  }
}

/// Copies with the first of `Values` that is the type of the components.
template <typename... Values>
void copy_as_float(const itk::ImageIOBase& io, const std::byte* raw, const itk::ImageIORegion& held,
                   const IndexBox& box, int layer, float* out) {
  const auto copy_if = [&]<typename Value>(Value) {
    if (io.GetComponentType() != itk::ImageIOBase::MapPixelType<Value>::CType) return false;
    copy_region<Value>(raw, held, box, static_cast<int>(io.GetNumberOfComponents()), layer, out);
    return true;
  };
  if (!(copy_if(Values{}) || ...)) throw std::invalid_argument("pixel type");  // geometry_of() has checked it
}

itk::ImageIORegion io_region(const itk::ImageIOBase& io, const IndexBox& box) {
  itk::ImageIORegion region(io.GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    region.SetIndex(axis, axis < 3 ? box.start[axis] : 0);
    region.SetSize(axis, axis < 3 ? static_cast<itk::SizeValueType>(box.size[axis]) : 1);
  }
  return region;
}

/// Key-value metadata of an NRRD.
std::map<std::string, std::string> metadata_of(const itk::ImageIOBase& io) {
  const itk::MetaDataDictionary& dictionary = io.GetMetaDataDictionary();
  std::map<std::string, std::string> out;
  for (const std::string& name : dictionary.GetKeys()) {
    std::string value;
    if (itk::ExposeMetaData<std::string>(dictionary, name, value)) out[name] = value;
  }
  return out;
}

constexpr std::size_t kLongestLine = 200;

/// The beginning of a line of a damaged file, for a message.
std::string printable_start(const std::string& line) {
  constexpr std::size_t kMost = 60;
  std::string out = line.substr(0, kMost);
  for (char& c : out) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return out;
}

/// MetaIO reads as many numbers as the header has dimensions, without end, and takes the header for compressed voxels
/// where these follow it and have no size.
void check_meta_image(const std::string& path, const std::string& key) {
  static const Pattern few_dimensions(R"(NDims\s*[=:]\s*[1-9]\s*)");
  static const Pattern is_compressed(R"(CompressedData\s*[=:]\s*[Tt1].*\s*)");
  static const Pattern is_local(R"(ElementDataFile\s*[=:]\s*(LOCAL|Local|local)\s*)");
  std::istringstream header(read_file_start(path, 1 << 16));
  bool compressed = false;
  bool sized = false;
  for (std::string line; std::getline(header, line);) {
    compressed = compressed || is_compressed.matches(line.substr(0, kLongestLine));
    sized = sized || line.starts_with("CompressedDataSize");
    if (is_local.matches(line.substr(0, kLongestLine))) {  // voxels follow
      if (!compressed || sized) return;
      throw InputError({path}, key, "the MetaImage header has no CompressedDataSize",
                       "add it, or save the image without compression");
    }
    if (line.find("NDims") == std::string::npos || few_dimensions.matches(line.substr(0, kLongestLine))) continue;
    throw InputError({path}, key, "the MetaImage header says \"" + printable_start(line) + "\"", "expected NDims = 3");
  }
}

/// Throws InputError when the file is shorter than its header claims.
void check_file_length(const std::string& path, const std::string& key, std::int64_t voxels, double bytes_per_voxel) {
  if (!contains_its_voxels(path)) return;
  const double claimed = static_cast<double>(voxels) * bytes_per_voxel;
  const std::uintmax_t length = fs::file_size(path);
  if (claimed <= kMaxCompression * static_cast<double>(length) + kHeaderSlackBytes) return;
  throw InputError({path}, key,
                   "the header claims " + std::to_string(voxels) + " voxels, but the file has only " +
                       std::to_string(length) + " bytes",
                   "give a complete file");
}

/// Throws the InputError of a file that is none of the formats.
[[noreturn]] void refuse_format(const std::string& path, const std::string& key, const std::string& start) {
  if (is_vtk(path)) {
    throw InputError(
        {path}, key, "a VTK file",
        "save it as NRRD, NIfTI or MetaImage (ParaView, 3D Slicer); use bone.mesh for a surface, as STL or PLY");
  }
  const std::string promised = format_by_name(path);
  for (const KnownStart& known : kKnownStarts) {
    if (promised != "NIfTI" && start.starts_with(known.bytes)) throw InputError({path}, key, known.what, known.advice);
  }
  const std::string found = start.empty()      ? "the file is empty"
                            : promised.empty() ? "not a readable CT image"
                                               : "the " + promised + " header is truncated or damaged";
  throw InputError({path}, key, found, "expected a folder of DICOM slices, or an NRRD, NIfTI or MetaImage file");
}

[[noreturn]] void refuse_single_dicom(const itk::ImageIOBase& io, const std::string& path, const std::string& key) {
  if (io.GetNumberOfDimensions() > 2 && io.GetDimensions(2) > 1) {
    throw InputError({path}, key, "a multi-frame DICOM file",
                     "convert it to NRRD or NIfTI (3D Slicer, dcm2niix), or export single slices");
  }
  throw InputError({path}, key, "a single DICOM slice", "give the folder of the series");
}

}  // namespace

itk::ImageIOBase::Pointer open_image_io(const std::string& path, const std::string& key, std::string& format) {
  const QuietLibraries quiet;
  const std::string start = read_file_start(path, kHeaderStart);
  itk::ImageIOBase::Pointer io;
  if (start.starts_with("NRRD")) {
    check_encoding(path, key);
    format = "NRRD";
    io = itk::NrrdImageIO::New().GetPointer();
  } else if (is_meta_image(start)) {
    check_meta_image(path, key);
    format = "MetaImage";
    io = itk::MetaImageIO::New().GetPointer();
  } else if (const auto dicom = itk::GDCMImageIO::New(); can_read(*dicom, path)) {
    format = kDicom;
    io = dicom.GetPointer();
  } else {
    refuse_format(path, key, start);
  }
  io->SetFileName(path);
  return io;
}

ImageFacts check_image(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format,
                       bool allow_layers) {
  read_header(io, path, key, format);
  if (format == kDicom) refuse_single_dicom(io, path, key);
  ImageFacts out;
  out.format = format;
  out.geometry = geometry_of(io, path, key, false, allow_layers);
  out.pixel_type = pixel_type_of(io);
  out.layers = static_cast<int>(io.GetNumberOfComponents());
  out.bytes_per_voxel = static_cast<double>(io.GetComponentSize()) * io.GetNumberOfComponents();
  describe_header(io, out);
  if (allow_layers) out.segments = segments_of_nrrd(metadata_of(io), out.layers);
  check_fits_in_memory(static_cast<double>(out.geometry.size()), out.bytes_per_voxel, path, key);
  check_file_length(path, key, out.geometry.size(), out.bytes_per_voxel);
  return out;
}

void read_header(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format) {
  const QuietLibraries quiet;
  try {
    io.ReadImageInformation();
    if (quiet.reports_missing_voxels()) throw std::length_error("header");
  } catch (const std::exception&) {
    throw InputError({path}, key, "the " + format + " header cannot be read", "the file is truncated or damaged");
  }
}

bool ScanGeometry::is_valid() const {
  if (!step_mm.allFinite() || !origin_mm.allFinite()) return false;
  if ((dims.array() < 1).any()) return false;
  const Vec3 edge = spacing_mm();
  constexpr double kLeastVolume = 1e-3;  // of the box with these edges; less: the axes lie in a plane
  return edge.minCoeff() >= kLeastStep_mm && edge.maxCoeff() <= kGreatestStep_mm &&
         edge.maxCoeff() <= kMostElongated * edge.minCoeff() &&
         std::abs(step_mm.determinant()) >= kLeastVolume * edge.prod();
}

void check_volume(const std::vector<std::int64_t>& sizes, bool allow_slice, const std::string& path,
                  const std::string& key) {
  std::string shape;
  bool volume = sizes.size() >= (allow_slice ? 2U : 3U);
  for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
    shape += (axis == 0 ? "" : "×") + std::to_string(sizes[axis]);
    const bool single = sizes[axis] == 1;
    if (axis >= 3 && !single) volume = false;
    if (axis == 2 && single && !allow_slice) volume = false;
    if (sizes[axis] < 1 || sizes[axis] > std::numeric_limits<int>::max()) volume = false;
  }
  if (!volume) throw InputError({path}, key, "an image of " + shape + " pixels", "expected a volume, three axes");
}

ScanGeometry geometry_of(const itk::ImageIOBase& io, const std::string& path, const std::string& key, bool allow_slice,
                         bool allow_layers) {
  const unsigned dimensions = io.GetNumberOfDimensions();
  std::vector<std::int64_t> sizes;
  for (unsigned axis = 0; axis < dimensions; ++axis) sizes.push_back(static_cast<std::int64_t>(io.GetDimensions(axis)));
  check_volume(sizes, allow_slice, path, key);
  const bool several = io.GetNumberOfComponents() != 1 && !allow_layers;
  if (several || io.GetNumberOfComponents() == 0 || pixel_type_of(io).empty()) {
    throw InputError({path}, key, std::to_string(io.GetNumberOfComponents()) + " numbers in each voxel",
                     "expected one integer or real number (HU) in each voxel");
  }
  ScanGeometry geometry;
  geometry.dims = Vec3i::Ones();
  for (unsigned axis = 0; axis < std::min(dimensions, 3U); ++axis) {
    geometry.dims[axis] = static_cast<int>(io.GetDimensions(axis));
    const std::vector<double> direction = io.GetDirection(axis);
    for (unsigned row = 0; row < std::min<std::size_t>(direction.size(), 3); ++row) {
      geometry.step_mm(row, axis) = direction[row] * io.GetSpacing(axis);
    }
    geometry.origin_mm[axis] = io.GetOrigin(axis);
  }
  geometry = apply_format_conventions(io, geometry);
  if (!geometry.is_valid()) {
    throw InputError({path}, key, "voxel spacing, axes or origin are zero, not finite or degenerate",
                     fmt::format("expected a spacing above {:g} mm and three independent axes", kLeastStep_mm));
  }
  return geometry;
}

std::string pixel_type_of(const itk::ImageIOBase& io) {
  constexpr std::array kUnsigned{Component::UCHAR, Component::USHORT, Component::UINT, Component::ULONG,
                                 Component::ULONGLONG};
  constexpr std::array kSigned{Component::CHAR, Component::SHORT, Component::INT, Component::LONG, Component::LONGLONG};
  const Component type = io.GetComponentType();
  const std::string bits = std::to_string(8 * io.GetComponentSize());
  if (std::ranges::count(kUnsigned, type) > 0) return "uint" + bits;
  if (std::ranges::count(kSigned, type) > 0) return "int" + bits;
  return type == Component::FLOAT ? "float" : type == Component::DOUBLE ? "double" : "";
}

void read_voxels(itk::ImageIOBase& io, const IndexBox& box, int layer, const std::string& path, const std::string& key,
                 float* out) {
  const QuietLibraries quiet;
  auto* meta = dynamic_cast<itk::MetaImageIO*>(&io);
  // ITK loses voxels of a part of a compressed MetaImage.
  io.SetUseStreamedReading(meta == nullptr || !meta->GetMetaImagePointer()->CompressedData());
  try {
    const itk::ImageIORegion held = io.GenerateStreamableReadRegionFromRequestedRegion(io_region(io, box));
    // Not initialized, so that a header with false dimensions uses no memory before the file proves to be truncated.
    const auto raw = std::make_unique_for_overwrite<std::byte[]>(held.GetNumberOfPixels() * io.GetComponentSize() *
                                                                 io.GetNumberOfComponents());
    io.SetIORegion(held);
    io.Read(raw.get());
    if (quiet.reports_missing_voxels()) throw std::length_error("voxels");
    copy_as_float<unsigned char, signed char, unsigned short, short, unsigned, int, unsigned long, long,
                  unsigned long long, long long, float, double>(io, raw.get(), held, box, layer, out);
  } catch (const std::bad_alloc&) {
    throw InputError({path}, key, "the voxels exceed the memory of this machine", "use a smaller image, or a crop");
  } catch (const std::exception&) {
    throw cut_off(path, key);
  }
}

InputError cut_off(const std::string& path, const std::string& key) {
  return {{path}, key, "the voxels cannot be read: the file is truncated or damaged", "give a complete file"};
}

}  // namespace reamsim::ct
