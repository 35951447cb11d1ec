// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <set>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/file.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{2} << 30;

[[noreturn]] void refuse(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "", found, expected);
}

[[noreturn]] void refuse_vtk(const std::string& path) {
  refuse(path, "a VTK file",
         "save its surface as STL or PLY: in ParaView with File > Save Data, or in Python with PyVista: "
         "pyvista.read(\"bone.vtp\").extract_surface().triangulate().save(\"bone.stl\")");
}

/// "stl", "obj" or "ply".
std::string checked_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::set<std::string> vtk{".vtk", ".vtp", ".vtu", ".vts", ".vtr", ".vti", ".vtm", ".pvtp", ".pvtu"};
  if (vtk.contains(extension) && fs::is_regular_file(path)) refuse_vtk(path);
  if (extension != ".stl" && extension != ".obj" && extension != ".ply") {
    refuse(path, "the extension \"" + extension + "\"", "expected a mesh in .stl, .obj or .ply");
  }
  return extension.substr(1);
}

std::uintmax_t checked_size(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const std::string reason = unreachable_reason(path);
  if (!reason.empty()) refuse(path, "cannot be read (" + reason + ")", "expected a readable mesh file");
  if (!fs::exists(status)) refuse(path, "no such file", "expected a mesh in .stl, .obj or .ply");
  if (fs::is_directory(status)) refuse(path, "a folder", "expected a mesh in .stl, .obj or .ply");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || !std::ifstream(path).good()) refuse(path, "cannot be read", "expected a readable mesh file");
  if (size == 0) refuse(path, "an empty file", "expected a mesh in .stl, .obj or .ply");
  if (size > kMaxFileBytes) refuse(path, "a file of more than 2 GiB", "expected a mesh of at most 2 GiB");
  return size;
}

/// Detects VTK's legacy and XML formats by the content of the file.
void check_is_not_vtk(const std::string& path) {
  const std::string start = read_file_start(path, 256);
  if (start.starts_with("# vtk DataFile") || start.find("<VTKFile") != std::string::npos) refuse_vtk(path);
}

/// Binary unless it begins like an ASCII STL ("solid ... facet").
bool stl_is_binary(const std::string& start) {
  const std::size_t first = start.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || start.compare(first, 5, "solid") != 0) return true;
  return start.find("facet") == std::string::npos && start.find("endsolid") == std::string::npos;
}

/// Checks the number of triangles in the header of a binary STL, which assimp trusts.
void check_stl(const std::string& path, std::uintmax_t size) {
  const std::string start = read_file_start(path, 1024);
  if (!stl_is_binary(start)) return;
  if (size < kStlHeaderBytes)
    refuse(path, "a truncated STL of " + std::to_string(size) + " bytes", "expected 84 or more");
  std::uint32_t count = 0;
  std::memcpy(&count, start.data() + 80, sizeof count);
  const std::uintmax_t needed = kStlHeaderBytes + std::uintmax_t{kStlTriangleBytes} * count;
  if (count == 0) refuse(path, "an STL of 0 triangles", "expected a surface");
  if (size < needed) {
    refuse(path,
           "a truncated STL: its header claims " + std::to_string(count) + " triangles, the file holds " +
               std::to_string((size - kStlHeaderBytes) / kStlTriangleBytes),
           "expected " + std::to_string(needed) + " bytes");
  }
}

/// Checks the counts in a PLY header, for which assimp reserves memory.
void check_ply(const std::string& path, std::uintmax_t size) {
  std::istringstream header(read_file_start(path, std::size_t{64} * 1024));
  std::string line;
  bool ended = false;
  std::getline(header, line);
  if (line.rfind("ply", 0) != 0) refuse(path, "no PLY header", "expected a file that begins with \"ply\"");
  while (!ended && std::getline(header, line)) {
    std::istringstream words(line);
    std::string keyword;
    std::string name;
    words >> keyword;
    ended = keyword == "end_header";
    if (keyword != "element") continue;
    std::uintmax_t count = 0;
    if (!(words >> name >> count) || count > size) {
      refuse(path, "a truncated PLY: its header claims more elements \"" + name + "\" than the file can hold",
             "expected a complete PLY file");
    }
  }
  if (header.bad()) throw std::bad_alloc();  // std::getline() swallows it
  if (!ended) refuse(path, "a PLY header without \"end_header\"", "expected a complete PLY file");
}

}  // namespace

void require_mesh_name(const std::string& path, const std::string& key) {
  try {
    checked_extension(path);
  } catch (const InputError& error) {
    throw InputError({}, key, error.what(), "");
  }
}

MeshFile check_mesh_file(const std::string& path) {
  const std::string extension = checked_extension(path);
  const std::uintmax_t size = checked_size(path);
  check_is_not_vtk(path);
  if (extension == "stl") check_stl(path, size);
  if (extension == "ply") check_ply(path, size);
  return {.extension = extension, .bytes = size};
}

}  // namespace reamsim
