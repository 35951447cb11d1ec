// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/image_io.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <stdexcept>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

using Component = itk::IOComponentEnum;

/// Deflate compresses at most 1032 : 1. A file whose header claims more voxels is truncated.
constexpr double kMaxCompression = 1032;
constexpr double kHeaderSlackBytes = 1 << 16;

/// Least edge length of a voxel, mm, and greatest quotient of two of them: far beyond any scanner. What lies outside
/// is a damaged header; filters would need memory without limit.
constexpr double kLeastStep_mm = 1e-3;
constexpr double kGreatestStep_mm = 1e6;
constexpr double kMostElongated = 200;

/// Formats by the ending of names; `whole`: header and voxels are in one file, so that its length limits their number.
struct NamedFormat {
  const char* ending;
  const char* format;
  bool whole;
};
constexpr std::array kNamedFormats{NamedFormat{".nrrd", "NRRD", true},     NamedFormat{".nhdr", "NRRD", false},
                                   NamedFormat{".nii", "NIfTI", true},     NamedFormat{".nii.gz", "NIfTI", true},
                                   NamedFormat{".hdr", "NIfTI", false},    NamedFormat{".img", "NIfTI", false},
                                   NamedFormat{".mha", "MetaImage", true}, NamedFormat{".dcm", "DICOM", true},
                                   NamedFormat{".mhd", "MetaImage", false}};

NamedFormat format_by_name(const std::string& path) {
  const std::string name = lower_case(path);
  const auto* found =
      std::ranges::find_if(kNamedFormats, [&](const NamedFormat& f) { return name.ends_with(f.ending); });
  return found == kNamedFormats.end() ? NamedFormat{"", "", false} : *found;
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

template <typename Value>
void copy_region(const std::byte* raw, const itk::ImageIORegion& held, const IndexBox& box, int layers, int layer,
                 float* out) {
  const auto row = static_cast<std::int64_t>(held.GetSize(0)), rows = static_cast<std::int64_t>(held.GetSize(1));
  const Vec3i start = box.start - Vec3i(static_cast<int>(held.GetIndex(0)), static_cast<int>(held.GetIndex(1)),
                                        static_cast<int>(held.GetIndex(2)));
  for_each_voxel(box.size, [&](const Vec3i& voxel) {
    const Vec3i at = start + voxel;
    const std::int64_t number = (at.x() + row * (at.y() + rows * at.z())) * layers + layer;
    Value value;
    std::memcpy(&value, raw + number * static_cast<std::int64_t>(sizeof(Value)), sizeof(Value));
    *out++ = static_cast<float>(value);
  });
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
  if (!(copy_if(Values{}) || ...)) throw std::invalid_argument("pixel type");  // check_image() has checked it
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

/// MetaIO reads as many numbers as the header has dimensions, without end, and takes the header for compressed voxels
/// where these follow it and have no size.
void check_meta_image(const ForeignFile& file) {
  static const Pattern few_dimensions(R"(NDims\s*[=:]\s*[1-9]\s*)");
  static const Pattern is_compressed(R"(CompressedData\s*[=:]\s*[Tt1].*\s*)");
  static const Pattern is_local(R"(ElementDataFile\s*[=:]\s*(LOCAL|Local|local)\s*)");
  std::istringstream header(read_file_start(file.path, kHeaderStart));
  bool compressed = false;
  bool sized = false;
  for (std::string line; std::getline(header, line);) {
    compressed = compressed || is_compressed.matches(line.substr(0, kLongestLine));
    sized = sized || line.starts_with("CompressedDataSize");
    if (is_local.matches(line.substr(0, kLongestLine))) {  // voxels follow
      if (!compressed || sized) return;
      throw file.error("the MetaImage header has no CompressedDataSize",
                       "add it, or save the image without compression");
    }
    if (line.find("NDims") == std::string::npos || few_dimensions.matches(line.substr(0, kLongestLine))) continue;
    constexpr std::size_t kMostInMessage = 60;
    line.resize(std::min(line.size(), kMostInMessage));
    std::ranges::replace_if(
        line, [](char c) { return c < 0x20 || c > 0x7e; }, '?');
    throw file.error("the MetaImage header says \"" + line + "\"", "expected NDims = 3");
  }
}

/// Throws InputError when the file is shorter than its header claims.
void check_file_length(const ForeignFile& file, std::int64_t voxels, double bytes_per_voxel) {
  if (!format_by_name(file.path).whole) return;
  const double claimed = static_cast<double>(voxels) * bytes_per_voxel;
  const std::uintmax_t length = fs::file_size(file.path);
  if (claimed <= kMaxCompression * static_cast<double>(length) + kHeaderSlackBytes) return;
  throw file.error(fmt::format("the header claims {} voxels, but the file has only {} bytes", voxels, length),
                   "give a complete file");
}

/// Throws the InputError of a file that is none of the formats.
[[noreturn]] void refuse_format(const ForeignFile& file, const std::string& start) {
  // VTK's own formats, legacy and XML.
  if (start.starts_with("# vtk DataFile") || start.substr(0, 256).find("<VTKFile") != std::string::npos) {
    throw file.error(
        "a VTK file",
        "save it as NRRD, NIfTI or MetaImage (ParaView, 3D Slicer); use bone.mesh for a surface, as STL, PLY or VTP");
  }
  const std::string promised = format_by_name(file.path).format;
  for (const KnownStart& known : kKnownStarts) {
    if (promised != "NIfTI" && start.starts_with(known.bytes)) throw file.error(known.what, known.advice);
  }
  throw file.error(start.empty()      ? "the file is empty"
                   : promised.empty() ? "not a readable CT image"
                                      : "the " + promised + " header is truncated or damaged",
                   "expected a folder of DICOM slices, or an NRRD, NIfTI or MetaImage file");
}

/// "int16", "float", ...; "" for others than single real numbers.
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

/// The geometry in the header of a volume, as ITK gives it.
ScanGeometry geometry_of(const itk::ImageIOBase& io) {
  ScanGeometry geometry;
  for (unsigned axis = 0; axis < 3; ++axis) {
    geometry.dims[axis] = static_cast<int>(io.GetDimensions(axis));
    const std::vector<double> direction = io.GetDirection(axis);
    for (unsigned row = 0; row < std::min<std::size_t>(direction.size(), 3); ++row) {
      geometry.step_mm(row, axis) = direction[row] * io.GetSpacing(axis);
    }
    geometry.origin_mm[axis] = io.GetOrigin(axis);
  }
  return geometry;
}

}  // namespace

itk::ImageIOBase::Pointer open_image_io(const ForeignFile& file) {
  const QuietLibraries quiet;
  const std::string start = read_file_start(file.path, kHeaderStart);
  itk::ImageIOBase::Pointer io;
  if (start.starts_with("NRRD")) {
    check_encoding(file);
    io = itk::NrrdImageIO::New().GetPointer();
  } else if (is_meta_image(start)) {
    check_meta_image(file);
    io = itk::MetaImageIO::New().GetPointer();
  } else {
    refuse_format(file, start);
  }
  io->SetFileName(file.path);
  try {
    io->ReadImageInformation();
    if (!quiet.reports_missing_voxels()) return io;
  } catch (const std::exception&) {  // the message for both follows
  }
  throw file.error(std::string("the ") + (is_nrrd(*io) ? "NRRD" : "MetaImage") + " header cannot be read",
                   "the file is truncated or damaged");
}

ImageFacts check_image(const itk::ImageIOBase& io, const ForeignFile& file, bool allow_layers) {
  std::vector<std::int64_t> sizes;
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    sizes.push_back(static_cast<std::int64_t>(io.GetDimensions(axis)));
  }
  check_volume(sizes, file);
  const unsigned layers = io.GetNumberOfComponents();
  ImageFacts out;
  out.pixel_type = pixel_type_of(io);
  if ((layers != 1 && !allow_layers) || layers == 0 || out.pixel_type.empty()) {
    throw file.error(std::to_string(layers) + " numbers in each voxel",
                     "expected one integer or real number (HU) in each voxel; export one volume of a time series, or "
                     "one channel (3D Slicer)");
  }
  out.format = is_nrrd(io) ? "NRRD" : "MetaImage";
  out.layers = static_cast<int>(layers);
  out.bytes_per_voxel = static_cast<double>(io.GetComponentSize()) * layers;
  out.geometry = geometry_of(io);
  apply_conventions(io, out);
  if (!out.geometry.is_valid()) {
    throw file.error("voxel spacing, axes or origin are zero, not finite or degenerate",
                     fmt::format("expected a spacing above {:g} mm and three independent axes", kLeastStep_mm));
  }
  if (allow_layers) out.segments = segments_of_nrrd(metadata_of(io), out.layers);
  check_fits_in_memory(static_cast<double>(out.geometry.size()), out.bytes_per_voxel, file);
  check_file_length(file, out.geometry.size(), out.bytes_per_voxel);
  return out;
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

void check_volume(const std::vector<std::int64_t>& sizes, const ForeignFile& file) {
  std::string shape;
  bool volume = sizes.size() >= 3;
  for (std::size_t axis = 0; axis < sizes.size(); ++axis) {
    shape += (axis == 0 ? "" : "×") + std::to_string(sizes[axis]);
    const bool single = sizes[axis] == 1;
    if (axis >= 3 && !single) volume = false;
    if (axis == 2 && single) volume = false;
    if (sizes[axis] < 1 || sizes[axis] > std::numeric_limits<int>::max()) volume = false;
  }
  if (!volume) throw file.error("an image of " + shape + " pixels", "expected a volume, three axes");
}

void read_voxels(itk::ImageIOBase& io, const IndexBox& box, int layer, const ForeignFile& file, float* out) {
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
    throw file.error("the voxels exceed the memory of this machine", "use a smaller image, or a crop");
  } catch (const std::exception&) {
    throw cut_off(file);
  }
}

InputError cut_off(const ForeignFile& file) {
  return file.error("the voxels cannot be read: the file is truncated or damaged", "give a complete file");
}

QuietLibraries::QuietLibraries()
    : cerr_(std::cerr.rdbuf(captured_.rdbuf())), cout_(std::cout.rdbuf(captured_.rdbuf())) {
  std::fflush(stderr);
  stderr_ = dup(STDERR_FILENO);
  const int null_device = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (stderr_ >= 0 && null_device >= 0) dup2(null_device, STDERR_FILENO);
  if (null_device >= 0) close(null_device);
}

QuietLibraries::~QuietLibraries() {
  std::fflush(stderr);
  if (stderr_ >= 0) {
    dup2(stderr_, STDERR_FILENO);
    close(stderr_);
  }
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

bool QuietLibraries::reports_missing_voxels() const {
  constexpr std::array<const char*, 3> kMessages{"data not read completely", "Uncompress failed",
                                                 "Incomplete Pixel Data"};
  const std::string output = captured_.str();
  return std::ranges::any_of(kMessages, [&](const char* text) { return output.find(text) != std::string::npos; });
}

}  // namespace reamsim::ct
