// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>

#include "sim/base/text.h"
#include "sim/scan/image_io.h"

namespace reamsim::ct {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBytes1 = 348, kBytes2 = 540;  // of the headers of NIfTI-1 and NIfTI-2

/// A file that zlib unpacks where it is compressed, whatever its name.
class PackedFile {
 public:
  explicit PackedFile(const std::string& path) : file_(gzopen(path.c_str(), "rb"), &gzclose) {
    constexpr unsigned kBuffer = 1 << 18;
    if (file_) gzbuffer(file_.get(), kBuffer);
  }
  /// Returns the number of bytes read.
  std::size_t read(void* to, std::size_t bytes) { return file_ ? gzfread(to, 1, bytes, file_.get()) : 0; }
  /// Goes forward.
  bool seek(std::int64_t to) { return file_ && gzseek(file_.get(), to, SEEK_SET) == to; }

 private:
  std::unique_ptr<gzFile_s, decltype(&gzclose)> file_;
};

/// Numbers at offsets of a file.
class Fields {
 public:
  Fields(const void* first, bool swapped) : first_(static_cast<const char*>(first)), swapped_(swapped) {}

  template <class T>
  [[nodiscard]] T at(std::size_t offset) const {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), first_ + offset, sizeof(T));
    if (swapped_) std::ranges::reverse(raw);
    return std::bit_cast<T>(raw);
  }
  /// Several of stored type T in a row, as type To.
  template <class T, class To>
  void take(std::size_t offset, To* to, std::size_t count) const {
    for (std::size_t n = 0; n < count; ++n) to[n] = static_cast<To>(at<T>(offset + n * sizeof(T)));
  }

 private:
  const char* first_;
  bool swapped_;
};

/// Offsets of the fields, which NIfTI-2 has in another order and in wider types.
struct Layout {
  std::size_t datatype, dim, pixdim, vox_offset, slope, intercept, qform_code, sform_code, quaternion, q_offset, srow,
      units;
};
constexpr Layout kLayout1{70, 40, 76, 108, 112, 116, 252, 254, 256, 268, 280, 123};
constexpr Layout kLayout2{12, 16, 104, 168, 176, 184, 344, 348, 352, 376, 400, 500};

template <class Size, class Real, class Offset, class Code, class Units>
void take_fields(const Fields& in, const Layout& at, NiftiHeader& out) {
  out.datatype = in.at<std::int16_t>(at.datatype);
  in.take<Size>(at.dim, out.dim.data(), out.dim.size());
  in.take<Real>(at.pixdim, out.pixdim.data(), out.pixdim.size());
  const auto offset = static_cast<double>(in.at<Offset>(at.vox_offset));
  constexpr double kMost = 1e15;
  out.offset = offset >= 0 && offset < kMost ? static_cast<std::int64_t>(offset) : -1;
  out.slope = static_cast<double>(in.at<Real>(at.slope));
  out.intercept = static_cast<double>(in.at<Real>(at.intercept));
  out.qform_code = static_cast<int>(in.at<Code>(at.qform_code));
  out.sform_code = static_cast<int>(in.at<Code>(at.sform_code));
  in.take<Real>(at.quaternion, out.quaternion.data(), 3);
  in.take<Real>(at.q_offset, out.q_offset.data(), 3);
  std::array<double, 12> rows{};
  in.take<Real>(at.srow, rows.data(), rows.size());
  out.srow = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows.data());
  constexpr int kLengths = 7;
  out.units = static_cast<int>(in.at<Units>(at.units)) & kLengths;
}

std::string lower_ending(const std::string& path) {
  return lower_case(fs::path(path).extension().string());
}

/// NAME.hdr of NAME.img and the other way round, also where both are compressed; the path itself for other names.
std::string partner_of(const std::string& path, const std::string& from, const std::string& to) {
  const bool packed = lower_ending(path) == ".gz";
  const fs::path stem = packed ? fs::path(path).replace_extension() : fs::path(path);
  if (lower_ending(stem.string()) != from) return path;
  for (const std::string& ending : {to, to + ".gz"}) {
    const std::string partner = fs::path(stem).replace_extension(ending).string();
    if (fs::exists(partner)) return partner;
  }
  return path;
}

/// The texts of the extensions that follow the header of a single file.
std::vector<std::string> extensions_of(PackedFile& file, bool swapped, std::int64_t offset, std::int64_t place) {
  std::vector<std::string> out;
  std::string head(4, '\0');
  if (file.read(head.data(), head.size()) != head.size() || head[0] == 0) return out;
  place += static_cast<std::int64_t>(head.size());
  constexpr std::int64_t kHead = 8;  // size and code, which the size includes
  head.resize(kHead);
  while (place + kHead <= offset && file.read(head.data(), kHead) == kHead) {
    const std::int64_t size = Fields(head.data(), swapped).at<std::int32_t>(0);
    if (size < kHead || place + size > offset) break;
    std::string text(static_cast<std::size_t>(size - kHead), '\0');
    if (file.read(text.data(), text.size()) != text.size()) break;
    out.push_back(std::move(text));
    place += size;
  }
  return out;
}

/// Fields, and the order of their bytes, of the first bytes of a file; nullopt for another format.
std::optional<NiftiHeader> parsed(const std::string& bytes) {
  for (const bool swapped : {false, true}) {
    const Fields in(bytes.data(), swapped);
    NiftiHeader out;
    out.swapped = swapped;
    const auto size = bytes.size() >= 4 ? in.at<std::int32_t>(0) : 0;
    if (size == kBytes1 && bytes.size() >= kBytes1) {
      take_fields<std::int16_t, float, float, std::int16_t, char>(in, kLayout1, out);
      const std::string magic = bytes.substr(344, 3);
      out.is_analyze = magic != "n+1" && magic != "ni1";
    } else if (size == kBytes2 && bytes.size() >= kBytes2 &&
               (bytes.substr(4, 3) == "n+2" || bytes.substr(4, 3) == "ni2")) {
      take_fields<std::int64_t, double, std::int64_t, std::int32_t, std::int32_t>(in, kLayout2, out);
    } else {
      continue;
    }
    return out.dim[0] >= 1 && out.dim[0] <= 7 ? std::optional(out) : std::nullopt;
  }
  return std::nullopt;
}

/// Converts stored numbers of type T.
template <class T>
void convert(const NiftiHeader& header, const std::byte* raw, std::int64_t count, float* out) {
  const Fields stored(raw, header.swapped);
  for (std::int64_t n = 0; n < count; ++n) {
    const T value = stored.at<T>(static_cast<std::size_t>(n) * sizeof(T));
    out[n] = header.is_scaled() ? static_cast<float>(static_cast<double>(value) * header.slope + header.intercept)
                                : static_cast<float>(value);
  }
}

/// A type of values.
struct ValueType {
  int code;
  int bytes;
  const char* name;
  void (*convert)(const NiftiHeader&, const std::byte* raw, std::int64_t count, float* out);
};
template <class T>
constexpr ValueType type_with(int code, const char* name) {
  return {code, sizeof(T), name, convert<T>};
}
constexpr std::array kTypes{type_with<std::uint8_t>(2, "uint8"),     type_with<std::int16_t>(4, "int16"),
                            type_with<std::int32_t>(8, "int32"),     type_with<float>(16, "float"),
                            type_with<double>(64, "double"),         type_with<std::int8_t>(256, "int8"),
                            type_with<std::uint16_t>(512, "uint16"), type_with<std::uint32_t>(768, "uint32"),
                            type_with<std::int64_t>(1024, "int64"),  type_with<std::uint64_t>(1280, "uint64")};

const ValueType* value_type(int code) {
  const auto* found = std::ranges::find(kTypes, code, &ValueType::code);
  return found == kTypes.end() ? nullptr : found;
}

/// Voxels along an axis, 1 for an axis that the header does not count.
std::int64_t size_of(const NiftiHeader& header, std::size_t axis) {
  return static_cast<std::int64_t>(axis) <= header.dim[0] ? header.dim[axis] : 1;
}

}  // namespace

std::optional<NiftiHeader> read_nifti_header(const ForeignFile& given) {
  const std::string header_file = partner_of(given.path, ".img", ".hdr");
  std::string bytes(kBytes2, '\0');
  PackedFile file(header_file);
  const std::size_t first = file.read(bytes.data(), kBytes1);
  const bool second = first == kBytes1 && !parsed(bytes.substr(0, kBytes1));
  bytes.resize(second ? first + file.read(bytes.data() + kBytes1, kBytes2 - kBytes1) : first);
  std::optional<NiftiHeader> out = parsed(bytes);
  if (!out) return out;
  const char kind = bytes[second ? 5 : 345];
  const bool single = !out->is_analyze && kind == '+';
  out->voxel_file = single ? header_file : partner_of(header_file, ".hdr", ".img");
  const auto header_bytes = static_cast<std::int64_t>(bytes.size());
  if (!single && out->voxel_file == header_file) {
    throw given.error("the voxels are in a file .img of the same name, which is missing", "put it beside");
  }
  if (out->offset < (single ? header_bytes : 0)) {
    throw given.error("the NIfTI header says that the voxels begin within it", "the file is damaged");
  }
  if (const ValueType* type = value_type(out->datatype)) {
    out->type = out->is_scaled() ? "float" : type->name;
    out->bytes_of_value = type->bytes;
  }
  if (single) out->extensions = extensions_of(file, out->swapped, out->offset, header_bytes);
  return out;
}

bool is_complete(const NiftiHeader& header) {
  PackedFile file(header.voxel_file);
  double voxels = header.bytes_of_value;
  for (std::size_t axis = 1; axis <= 7; ++axis) voxels *= static_cast<double>(size_of(header, axis));
  const double claimed = static_cast<double>(header.offset) + voxels;
  std::vector<char> chunk(1 << 20);
  double found = 0;
  while (found < claimed) {
    const std::size_t got = file.read(chunk.data(), chunk.size());
    found += static_cast<double>(got);
    if (got < chunk.size()) break;
  }
  return found >= claimed;
}

void read_nifti_voxels(const NiftiHeader& header, const IndexBox& box, int layer, const ForeignFile& given,
                       float* out) {
  const std::int64_t nx = size_of(header, 1), ny = size_of(header, 2), nz = size_of(header, 3);
  const ValueType* type = value_type(header.datatype);
  const std::int64_t bytes = type->bytes, row = box.size.x();
  PackedFile file(header.voxel_file);
  std::vector<std::byte> raw(static_cast<std::size_t>(row * bytes));
  for (int k = 0; k < box.size.z(); ++k) {
    for (int j = 0; j < box.size.y(); ++j) {
      const std::int64_t voxel = box.start.x() + nx * (box.start.y() + j + ny * (box.start.z() + k + nz * layer));
      if (!file.seek(header.offset + voxel * bytes) || file.read(raw.data(), raw.size()) != raw.size()) {
        throw cut_off(given);
      }
      type->convert(header, raw.data(), row, out);
      out += row;
    }
  }
}

}  // namespace reamsim::ct
