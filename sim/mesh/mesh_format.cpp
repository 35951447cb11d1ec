// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/file.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{2} << 30;
constexpr const char* kExpected = "expected a mesh in STL, OBJ, PLY or VTP";

std::string capitals(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return out;
}

/// A format that is not read, by the bytes at its beginning.
struct ForeignFormat {
  std::string_view begins;  ///< in capitals; text, whose case does not count
  std::string_view name;
  std::string_view advice;
  ContentKind kind = ContentKind::mesh;
};

constexpr std::string_view kSaveByMeshLab = "save it as STL or PLY with MeshLab or Blender";
constexpr std::string_view kSaveByCad = "export it as STL from the CAD program, or with FreeCAD";
constexpr std::string_view kSaveByPyVista =
    "save its surface as VTP in 3D Slicer, which states the frame, or as STL or PLY, and set bone.mesh.frame: in "
    "ParaView, or with PyVista: pyvista.read(\"bone.vtk\").extract_surface().triangulate().save(\"bone.stl\")";
constexpr std::string_view kSaveByGmsh = "save its surface as STL with Gmsh or meshio";
constexpr std::string_view kUseCt = "for a scan, use bone.source: ct";
constexpr std::string_view kUnpack = "unpack it first";

constexpr std::string_view kVtk = "<VTKFILE";
constexpr std::array kForeignTexts{
    ForeignFormat{"# VTK DATAFILE", "a VTK file", kSaveByPyVista},
    ForeignFormat{kVtk, "a VTK file", kSaveByPyVista},
    ForeignFormat{"OFF", "a mesh in OFF", kSaveByMeshLab},
    ForeignFormat{"COFF", "a mesh in OFF", kSaveByMeshLab},
    ForeignFormat{"NOFF", "a mesh in OFF", kSaveByMeshLab},
    ForeignFormat{"CNOFF", "a mesh in OFF", kSaveByMeshLab},
    ForeignFormat{"STOFF", "a mesh in OFF", kSaveByMeshLab},
    ForeignFormat{"GLTF", "a mesh in glTF", kSaveByMeshLab},
    ForeignFormat{"#VRML", "a scene in VRML", kSaveByMeshLab},
    ForeignFormat{"<X3D", "a scene in X3D", kSaveByMeshLab},
    ForeignFormat{"<COLLADA", "a scene in COLLADA", kSaveByMeshLab},
    ForeignFormat{"KAYDARA FBX", "a scene in FBX", "save it as STL or PLY with Blender"},
    ForeignFormat{"<GIFTI", "a surface in GIfTI",
                  "save it as STL with nibabel and meshio, or with Connectome Workbench"},
    ForeignFormat{"# AMIRAMESH", "a mesh in AmiraMesh", "save it as STL in Amira"},
    ForeignFormat{"# HYPERSURFACE", "a surface in HyperSurface", "save it as STL in Amira"},
    ForeignFormat{"$MESHFORMAT", "a mesh in Gmsh's format", kSaveByGmsh},
    ForeignFormat{"MESHVERSIONFORMATTED", "a mesh in Medit's format", kSaveByGmsh},
    ForeignFormat{"*HEADING", "an input file of Abaqus", kSaveByGmsh},
    ForeignFormat{"*NODE", "an input file of Abaqus", kSaveByGmsh},
    ForeignFormat{"ISO-10303-21", "a STEP file", kSaveByCad},
    ForeignFormat{"DBRA-", "a BREP file of Open CASCADE", kSaveByCad},
    ForeignFormat{"#DESCRIPTOR", "a JCAMP file", kSaveByMeshLab},
    ForeignFormat{"<?XML", "an XML file", kSaveByMeshLab, ContentKind::unknown},
    ForeignFormat{"NRRD0", "an image in NRRD", kUseCt, ContentKind::image},
    ForeignFormat{"OBJECTTYPE", "an image in MetaImage", kUseCt, ContentKind::image},
    ForeignFormat{"NDIMS", "an image in MetaImage", kUseCt, ContentKind::image}};

/// Formats whose first bytes are no text.
constexpr std::array kForeignBytes{
    ForeignFormat{{"PK\x03\x04", 4}, "a zip archive, as 3MF is", kUnpack, ContentKind::unknown},
    ForeignFormat{{"\x1F\x8B", 2}, "packed with gzip", kUnpack, ContentKind::unknown},
    ForeignFormat{{"BZh", 3}, "packed with bzip2", kUnpack, ContentKind::unknown},
    ForeignFormat{{"\xFD\x37zXZ", 5}, "packed with xz", kUnpack, ContentKind::unknown},
    ForeignFormat{{"\xFF\xFE", 2}, "text in UTF-16", "save it as plain text", ContentKind::unknown},
    ForeignFormat{{"\xFE\xFF", 2}, "text in UTF-16", "save it as plain text", ContentKind::unknown},
    ForeignFormat{{"\xFF\xFF\xFE", 3}, "a surface of FreeSurfer", "save it as STL with mris_convert"},
    ForeignFormat{{" BDV\0\0\0\0", 8}, "a VDB file", "use bone.source: vdb", ContentKind::vdb}};

/// The text at the beginning, without a byte order mark and blanks.
std::string_view trimmed(std::string_view start) {
  if (start.starts_with("\xEF\xBB\xBF")) start.remove_prefix(3);
  const std::size_t first = start.find_first_not_of(" \t\r\n\f\v");
  return first == std::string_view::npos ? std::string_view() : start.substr(first);
}

/// Skips the declaration of an XML file, its comments and its document type.
std::string_view xml_root(std::string_view text) {
  while (text.starts_with("<?") || text.starts_with("<!")) {
    const std::size_t end = text.find('>');
    if (end == std::string_view::npos) return text;
    const std::string_view rest = trimmed(text.substr(end + 1));
    if (rest.empty()) return text;
    text = rest;
  }
  return text;
}

std::optional<ForeignFormat> foreign_format(std::string_view start) {
  for (const ForeignFormat& format : kForeignBytes) {
    if (start.starts_with(format.begins)) return format;
  }
  const auto has = [&](std::size_t at, std::string_view text) {
    return start.size() >= at && start.substr(at).starts_with(text);
  };
  if (has(128, "DICM")) return ForeignFormat{"", "a DICOM image", kUseCt, ContentKind::image};
  if (start.size() >= 348 && (has(344, "n+1") || has(344, "ni1") || has(4, "n+2") || has(4, "ni2")))
    return ForeignFormat{"", "an image in NIfTI", kUseCt, ContentKind::image};
  const std::string text = capitals(xml_root(trimmed(start)).substr(0, 256));
  if (text.starts_with(kVtk) && text.find("POLYDATA") < std::min(text.find("PPOLYDATA"), text.find('>')))
    return std::nullopt;
  for (const ForeignFormat& format : kForeignTexts) {
    if (!text.starts_with(format.begins)) continue;
    // "OFF" is a word by itself.
    const bool word_ends = text.size() == format.begins.size() ||
                           std::isalpha(static_cast<unsigned char>(text[format.begins.size()])) == 0;
    if (word_ends || format.begins.size() > 5) return format;
  }
  return std::nullopt;
}

bool is_text(std::string_view start) {
  constexpr std::size_t kLooked = 4096;
  start = start.substr(0, kLooked);
  while (start.ends_with('\0')) start.remove_suffix(1);  // padding
  if (start.empty()) return false;
  return std::ranges::none_of(start, [](unsigned char c) { return c < ' ' && std::isspace(c) == 0; });
}

/// The next line of `text`, which is taken from it; any ending of lines.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

std::string_view first_word(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.substr(0, text.find_first_of(" \t\r\n\f\v"));
}

/// Whether lines begin with the words of an OBJ, and one of them with a vertex.
bool is_obj(std::string_view text) {
  constexpr std::array<std::string_view, 14> kWords{"v", "vn", "vt",     "vp",     "f", "l",  "p",
                                                    "o", "g",  "mtllib", "usemtl", "s", "mg", "vertex_color"};
  while (!text.empty()) {
    const std::string_view word = first_word(take_line(text));
    if (word == "v") return true;
    const bool skipped = word.empty() || word.starts_with('#');
    if (!skipped && std::ranges::find(kWords, word) == kWords.end()) return false;
  }
  return false;
}

/// Whether a triangle of a binary STL has finite coordinates and a normal of length 0 or 1.
bool is_plausible_triangle(std::string_view bytes) {
  constexpr float kLargest = 1e7F;
  std::array<float, 12> value{};
  std::memcpy(value.data(), bytes.data(), sizeof value);
  const bool finite = std::ranges::all_of(value, [](float v) { return std::abs(v) < kLargest; });
  const float length = std::hypot(value[0], value[1], value[2]);
  return finite && (length == 0 || std::abs(length - 1) < 0.1F);
}

bool looks_like_binary_stl(std::string_view start) {
  constexpr std::size_t kLookedAt = 16;
  if (start.size() < kStlHeaderBytes + kStlTriangleBytes) return false;
  start.remove_prefix(kStlHeaderBytes);
  for (std::size_t n = 0; n < kLookedAt && start.size() >= kStlTriangleBytes; ++n) {
    if (!is_plausible_triangle(start)) return false;
    start.remove_prefix(kStlTriangleBytes);
  }
  return true;
}

std::uintmax_t stl_bytes(std::uint32_t triangles) {
  return kStlHeaderBytes + std::uintmax_t{kStlTriangleBytes} * triangles;
}

bool has_length_of_stl(std::string_view start, std::uintmax_t bytes) {
  return start.size() >= kStlHeaderBytes && stl_count(start) > 0 && bytes == stl_bytes(stl_count(start));
}

/// Of a file that is no STL by its length, and of no foreign format.
std::optional<MeshFormat> mesh_format(std::string_view start) {
  const std::string_view text = trimmed(start);
  const std::string word = capitals(first_word(text));
  if (word == "PLY") return MeshFormat::ply;
  if (capitals(xml_root(text).substr(0, kVtk.size())) == kVtk) return MeshFormat::vtp;  // of a surface
  if (is_text(start)) {
    if (word == "SOLID" || word == "FACET") return MeshFormat::stl_ascii;
    return is_obj(text) ? std::optional(MeshFormat::obj) : std::nullopt;
  }
  if (looks_like_binary_stl(start)) return MeshFormat::stl_binary;
  return std::nullopt;
}

std::uintmax_t checked_size(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string reason = unreachable_reason(path);
  if (!reason.empty()) refuse_file(path, "cannot be read (" + reason + ")", "expected a readable mesh file");
  if (!fs::exists(status)) refuse_file(path, "no such file", kExpected);
  if (fs::is_directory(status)) refuse_file(path, "a folder", kExpected);
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || !std::ifstream(path).good()) refuse_file(path, "cannot be read", "expected a readable mesh file");
  if (size == 0) refuse_file(path, "an empty file", kExpected);
  if (size > kMaxFileBytes) refuse_file(path, "a file of more than 2 GiB", "expected a mesh of at most 2 GiB");
  return size;
}

/// Checks the number of triangles in the header of a binary STL.
void check_stl(const std::string& path, std::string_view start, std::uintmax_t size) {
  const std::uint32_t count = stl_count(start);
  const std::uintmax_t held = (size - kStlHeaderBytes) / kStlTriangleBytes;
  if (is_unknown_stl_count(count)) {
    if (held == 0) refuse_file(path, "an STL of 0 triangles", "expected a surface");
    if ((size - kStlHeaderBytes) % kStlTriangleBytes == 0) return;
    refuse_file(path,
                "its header claims " + std::to_string(count) + " triangles, and its length, " + std::to_string(size) +
                    " bytes, is not that of whole triangles",
                "export the STL again");
  }
  if (size >= stl_bytes(count)) return;
  if (size == stl_bytes(__builtin_bswap32(count))) {
    refuse_file(path, "a binary STL with the byte order of another machine (big-endian)", "export the STL again");
  }
  refuse_file(path,
              "a truncated STL: its header claims " + std::to_string(count) + " triangles, the file holds " +
                  std::to_string(held),
              "expected " + std::to_string(stl_bytes(count)) + " bytes");
}

/// Checks the counts in a PLY header, for which assimp reserves memory.
void check_ply(const std::string& path, std::string_view start, std::uintmax_t size) {
  while (!start.empty()) {
    std::istringstream words{std::string(take_line(start))};
    std::string keyword;
    std::string name;
    words >> keyword;
    if (keyword == "end_header") return;
    if (keyword != "element") continue;
    std::uintmax_t count = 0;
    if (!(words >> name >> count) || count > size) {
      refuse_file(path, "a truncated PLY: its header claims more elements \"" + name + "\" than the file can hold",
                  "expected a complete PLY file");
    }
  }
  refuse_file(path, "a PLY header without \"end_header\"", "expected a complete PLY file");
}

MeshFormat checked_format(const std::string& path, std::string_view start, std::uintmax_t size) {
  if (has_length_of_stl(start, size)) return MeshFormat::stl_binary;
  if (const auto foreign = foreign_format(start)) {
    const std::string space = stated_space(start, MeshFormat::stl_binary);
    refuse_file(path, std::string(foreign->name),
                std::string(foreign->advice) + (space.empty() ? "" : "; its header says SPACE=" + space));
  }
  if (const auto format = mesh_format(start)) return *format;
  // An STL cut short within its header has no triangle by which it could be known.
  if (capitals(fs::path(path).extension().string()) == ".STL" && !is_text(start)) {
    if (size < kStlHeaderBytes)
      refuse_file(path, "a truncated STL of " + std::to_string(size) + " bytes", "expected 84 or more");
    return MeshFormat::stl_binary;
  }
  refuse_file(path, "its content is neither STL, OBJ, PLY nor VTP",
              std::string(kExpected) + "; MeshLab and Blender convert others");
}

/// The part of a file in which programs state the frame.
std::string header_text(std::string_view start, MeshFormat format) {
  if (format == MeshFormat::stl_binary || format == MeshFormat::vtp) return capitals(start.substr(0, 80));
  std::string out;
  while (!start.empty()) {
    const std::string line = capitals(take_line(start));
    const std::string word = capitals(first_word(line));
    if (format == MeshFormat::stl_ascii && word == "FACET") break;
    if (format == MeshFormat::ply && word == "END_HEADER") break;
    const bool comment = format == MeshFormat::stl_ascii ? word == "SOLID"
                         : format == MeshFormat::ply     ? word == "COMMENT" || word == "OBJ_INFO"
                                                         : word.starts_with('#');
    if (comment) out += line + "\n";
  }
  return out;
}

}  // namespace

std::uint32_t stl_count(std::string_view start) {
  std::uint32_t count = 0;
  std::memcpy(&count, start.data() + kStlHeaderBytes - sizeof count, sizeof count);
  return count;
}

std::string stated_space(std::string_view start, MeshFormat format) {
  constexpr std::string_view kKey = "SPACE";
  const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  const std::string text = header_text(start, format);
  std::string out;
  for (std::size_t at = text.find(kKey); at != std::string::npos; at = text.find(kKey, at + 1)) {
    if (at > 0 && is_letter(text[at - 1])) continue;
    std::size_t value = text.find_first_not_of(" \t", at + kKey.size());
    if (value == std::string::npos || (text[value] != '=' && text[value] != ':')) continue;
    value = text.find_first_not_of(" \t", value + 1);
    std::string space;
    while (value < text.size() && (is_letter(text[value]) || text[value] == '-')) space += text[value++];
    if (space.empty() || space == out) continue;
    out += (out.empty() ? "" : " and ") + space;
  }
  return out;
}

ContentKind content_kind(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return ContentKind::unknown;
  const std::uintmax_t size = fs::file_size(path, error);
  const std::string start = read_file_start(path, kMeshHeaderBytes);
  if (error || start.empty()) return ContentKind::unknown;
  if (has_length_of_stl(start, size)) return ContentKind::mesh;
  if (const auto foreign = foreign_format(start)) return foreign->kind;
  return mesh_format(start) ? ContentKind::mesh : ContentKind::unknown;
}

MeshFormat check_mesh_file(const std::string& path) {
  const std::uintmax_t size = checked_size(path);
  const std::string start = read_file_start(path, kMeshHeaderBytes);
  const MeshFormat format = checked_format(path, start, size);
  if (format == MeshFormat::stl_binary) check_stl(path, start, size);
  if (format == MeshFormat::ply) check_ply(path, start, size);
  return format;
}

}  // namespace reamsim
