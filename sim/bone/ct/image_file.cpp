#include "sim/bone/ct/image_file.h"

#include <fmt/core.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <nifti1_io.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/bone/ct/dicom_probe.h"
#include "sim/bone/ct/quiet.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

using Component = itk::IOComponentEnum;

/// Deflate compresses at most 1032 : 1. A file whose header claims more voxels is truncated.
constexpr double kMaxCompression = 1032;
constexpr double kHeaderSlackBytes = 1 << 16;
constexpr const char* kDicom = "DICOM";

std::string lower_file_name(const std::string& path) {
  std::string name = fs::path(path).filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

std::string lower_extension(const std::string& path) {
  const std::string name = lower_file_name(path);
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

/// One of the values of a voxel.
struct Layer {
  int index = 0;
  int count = 1;
};

template <typename Value>
void copy_region(const std::byte* raw, const itk::ImageIORegion& held, const IndexBox& box, const Layer& layer,
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
        const std::int64_t number = (first + i) * layer.count + layer.index;
        std::memcpy(&value, raw + number * static_cast<std::int64_t>(sizeof(Value)), sizeof(Value));
        *out++ = static_cast<float>(value);
      }
    }
  }
}

/// Copies with the first of `Values` that is the type of the components.
template <typename... Values>
void copy_as_float(const itk::ImageIOBase& io, const std::byte* raw, const itk::ImageIORegion& held,
                   const IndexBox& box, const Layer& layer, float* out) {
  const auto copy_if = [&]<typename Value>(Value) {
    if (io.GetComponentType() != itk::ImageIOBase::MapPixelType<Value>::CType) return false;
    copy_region<Value>(raw, held, box, layer, out);
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

InputError cut_off(const std::string& path, const std::string& key) {
  return {{path}, key, "the voxels cannot be read: the file is truncated or damaged", "give a complete file"};
}

/// Creates the reader for a file without ITK's global list of factories, and sets `format`.
itk::ImageIOBase::Pointer open_image_io(const std::string& path, const std::string& key, std::string& format) {
  const QuietLibraries quiet;
  const std::pair<std::string, itk::ImageIOBase::Pointer> readers[] = {
      {"NRRD", itk::NrrdImageIO::New().GetPointer()},
      {"NIfTI", itk::NiftiImageIO::New().GetPointer()},
      {"MetaImage", itk::MetaImageIO::New().GetPointer()},
      {kDicom, itk::GDCMImageIO::New().GetPointer()}};
  for (const auto& [name, io] : readers) {
    if (name == kDicom) check_dicom_in_child({path}, key);
    if (!can_read(*io, path)) continue;
    format = name;
    io->SetFileName(path);
    return io;
  }
  const std::string promised = format_by_name(path);
  if (is_vtk(path)) {
    throw InputError(
        {path}, key, "a VTK file",
        "save it as NRRD, NIfTI or MetaImage (ParaView, 3D Slicer); a surface goes to bone.mesh, as STL or PLY");
  }
  const std::string found = fs::file_size(path) == 0 ? "the file is empty"
                            : promised.empty()       ? "not a readable CT image"
                                                     : "the " + promised + " header is truncated or damaged";
  throw InputError({path}, key, found, "expected a folder of DICOM slices, or an NRRD, NIfTI or MetaImage file");
}

/// Whether the file of a NIfTI header (or its .img), compressed or not, contains all its voxels. ITK itself fills
/// missing voxels with uninitialized memory.
bool nifti_is_complete(const std::string& path) {
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> header(nifti_image_read(path.c_str(), 0),
                                                                         &nifti_image_free);
  if (!header || header->iname == nullptr || header->nbyper <= 0 || header->iname_offset < 0) return false;
  const double claimed = static_cast<double>(header->iname_offset) + static_cast<double>(header->nvox) * header->nbyper;
  // gzread() also reads files that are not compressed.
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(header->iname, "rb"), &gzclose);
  if (!file) return false;
  std::vector<char> chunk(1 << 20);
  double read = 0;
  while (read < claimed) {
    const int bytes = gzread(file.get(), chunk.data(), static_cast<unsigned>(chunk.size()));
    if (bytes <= 0) return false;
    read += bytes;
  }
  return true;
}

/// An NRRD, NIfTI or MetaImage file.
class FileScan : public LabelSource {
 public:
  FileScan(const std::string& path, const std::string& key, bool allow_layers) : path_(path), key_(key) {
    io_ = open_image_io(path, key, format_);
    read_header(*io_, path, key, format_);
    if (format_ == kDicom) refuse_single_dicom();
    geometry_ = geometry_of(*io_, path, key, false, allow_layers);
    check_fits_in_memory(static_cast<double>(geometry_.size()), bytes_per_voxel(), path, key);
    check_file_length();
    const QuietLibraries quiet;
    if (format_ == "NIfTI" && !nifti_is_complete(path)) throw cut_off(path, key);
  }

  [[nodiscard]] const ScanGeometry& geometry() const override { return geometry_; }
  [[nodiscard]] std::string description() const override { return format_ + ", " + pixel_type_of(*io_); }
  [[nodiscard]] bool is_unsigned() const override { return pixel_type_of(*io_).starts_with("uint"); }
  [[nodiscard]] Scan read(const IndexBox& box) const override { return read_layer(box, 0); }

  [[nodiscard]] int layers() const override { return static_cast<int>(io_->GetNumberOfComponents()); }
  [[nodiscard]] bool has_whole_numbers() const override {
    return io_->GetComponentType() != Component::FLOAT && io_->GetComponentType() != Component::DOUBLE;
  }
  [[nodiscard]] Scan read_layer(const IndexBox& box, int layer) const override {
    return {part_of(geometry_, box), read_voxels(*io_, box, path_, key_, layer)};
  }
  [[nodiscard]] std::map<std::string, std::string> metadata() const override {
    const itk::MetaDataDictionary& dictionary = io_->GetMetaDataDictionary();
    std::map<std::string, std::string> out;
    for (const std::string& name : dictionary.GetKeys()) {
      std::string value;
      if (itk::ExposeMetaData<std::string>(dictionary, name, value)) out[name] = value;
    }
    return out;
  }

 private:
  [[nodiscard]] double bytes_per_voxel() const {
    return static_cast<double>(io_->GetComponentSize()) * io_->GetNumberOfComponents();
  }

  [[noreturn]] void refuse_single_dicom() const {
    if (io_->GetNumberOfDimensions() > 2 && io_->GetDimensions(2) > 1) {
      throw InputError({path_}, key_, "a multi-frame DICOM file",
                       "convert it to NRRD or NIfTI (3D Slicer, dcm2niix), or export single slices");
    }
    throw InputError({path_}, key_, "a single DICOM slice", "give the folder of the series");
  }

  void check_file_length() const {
    if (!contains_its_voxels(path_)) return;
    const double claimed = static_cast<double>(geometry_.size()) * bytes_per_voxel();
    const double length = static_cast<double>(fs::file_size(path_));
    if (claimed <= kMaxCompression * length + kHeaderSlackBytes) return;
    throw InputError({path_}, key_,
                     "the header claims " + std::to_string(geometry_.size()) + " voxels, but the file has only " +
                         std::to_string(fs::file_size(path_)) + " bytes",
                     "give a complete file");
  }

  std::string path_;
  std::string key_;
  std::string format_;
  itk::ImageIOBase::Pointer io_;
  ScanGeometry geometry_;
};

/// The kind of an existing path. Throws InputError where there is none.
fs::file_status checked_status(const std::string& path, const std::string& key, const char* expected) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError({path}, key, "no such file or folder", expected);
  if (!fs::is_directory(status) && !fs::is_regular_file(status)) {
    throw InputError({path}, key, "neither a file nor a folder", expected);
  }
  return status;
}

}  // namespace

void read_header(itk::ImageIOBase& io, const std::string& path, const std::string& key, const std::string& format) {
  const QuietLibraries quiet;
  try {
    io.ReadImageInformation();
    if (quiet.reports_missing_voxels()) throw std::length_error("header");
  } catch (const std::exception&) {
    throw InputError({path}, key, "the " + format + " header cannot be read", "the file is truncated or damaged");
  }
}

ScanGeometry geometry_of(const itk::ImageIOBase& io, const std::string& path, const std::string& key, bool allow_slice,
                         bool allow_layers) {
  const unsigned dimensions = io.GetNumberOfDimensions();
  std::string shape;
  bool volume = dimensions >= (allow_slice ? 2U : 3U);
  for (unsigned axis = 0; axis < dimensions; ++axis) {
    shape += (axis == 0 ? "" : "×") + std::to_string(io.GetDimensions(axis));
    const bool single = io.GetDimensions(axis) == 1;
    if (axis >= 3 && !single) volume = false;
    if (axis == 2 && single && !allow_slice) volume = false;
    if (io.GetDimensions(axis) == 0 || io.GetDimensions(axis) > std::numeric_limits<int>::max()) volume = false;
  }
  if (!volume) throw InputError({path}, key, "an image of " + shape + " pixels", "expected a volume, three axes");
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
  if (!geometry.step_mm.allFinite() || !geometry.origin_mm.allFinite() ||
      !(std::abs(geometry.step_mm.determinant()) > 1e-12) || geometry.step_mm.cwiseAbs().maxCoeff() > 1e6) {
    throw InputError({path}, key, "voxel spacing, axes or origin are zero, not finite or degenerate",
                     "expected a spacing above 0 mm and three independent axes");
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

std::vector<float> read_voxels(itk::ImageIOBase& io, const IndexBox& box, const std::string& path,
                               const std::string& key, int layer) {
  const QuietLibraries quiet;
  io.SetUseStreamedReading(true);
  try {
    const itk::ImageIORegion held = io.GenerateStreamableReadRegionFromRequestedRegion(io_region(io, box));
    // Not initialized, so that a header with false dimensions uses no memory before the file proves to be truncated.
    const auto raw = std::make_unique_for_overwrite<std::byte[]>(held.GetNumberOfPixels() * io.GetComponentSize() *
                                                                 io.GetNumberOfComponents());
    io.SetIORegion(held);
    io.Read(raw.get());
    if (quiet.reports_missing_voxels()) throw std::length_error("voxels");
    std::vector<float> out(static_cast<std::size_t>(box.voxels()));
    const Layer wanted{layer, static_cast<int>(io.GetNumberOfComponents())};
    copy_as_float<unsigned char, signed char, unsigned short, short, unsigned, int, unsigned long, long,
                  unsigned long long, long long, float, double>(io, raw.get(), held, box, wanted, out.data());
    return out;
  } catch (const std::bad_alloc&) {
    throw InputError({path}, key, "the voxels exceed the memory of this machine", "use a smaller image, or a crop");
  } catch (const std::exception&) {
    throw cut_off(path, key);
  }
}

void check_fits_in_memory(double voxels, double bytes_per_voxel, const std::string& path, const std::string& key) {
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (voxels * bytes_per_voxel <= 0.5 * memory) return;
  const std::string text =
      fmt::format("{:.3g} voxels need {:.3g} GB, more than half of this machine's memory ({:.3g} GB)", voxels,
                  voxels * bytes_per_voxel / 1e9, memory / 1e9);
  throw InputError({path}, key, text, "use fewer voxels, or check that the header is not damaged");
}

std::unique_ptr<ScanSource> open_scan(const std::string& path, const std::string& key, const DicomChoice& choice,
                                      Report& report) {
  const bool folder = fs::is_directory(checked_status(path, key, "give a CT image"));
  try {
    if (folder) return open_dicom_folder(path, key, choice, report);
    // DICOMDIR is the index file beside the folders of a study.
    if (lower_file_name(path) == "dicomdir")
      return open_dicom_folder(fs::path(path).parent_path().string(), key, choice, report);
    auto scan = std::make_unique<FileScan>(path, key, false);
    if (choice.series.empty()) return scan;
    throw InputError({path}, "bone.ct.series", "given for a file that is not a DICOM folder", "remove it");
  } catch (const fs::filesystem_error&) {
    throw InputError({path}, key, "cannot be opened", "check its permissions");
  }
}

std::unique_ptr<LabelSource> open_labels(const std::string& path, const std::string& key) {
  const char* expected = "give a label map: NRRD, NIfTI or MetaImage";
  if (fs::is_directory(checked_status(path, key, expected))) throw InputError({path}, key, "a folder", expected);
  try {
    return std::make_unique<FileScan>(path, key, true);
  } catch (const fs::filesystem_error&) {
    throw InputError({path}, key, "cannot be opened", "check its permissions");
  }
}

}  // namespace reamsim::ct
