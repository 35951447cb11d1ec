// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

// The content of a file decides what it is, never the ending of its name.

enum class MeshFormat { stl_binary, stl_ascii, obj, ply, vtp };

/// What a file is by its first bytes; a mesh also in a format that is not read.
enum class ContentKind { mesh, image, vdb, unknown };
ContentKind content_kind(const std::string& path);

/// Checks the size, format and header of a mesh file, whose counts the library that reads it trusts. Throws InputError:
/// no such file, another format (with its name and what converts it), a header that claims more than the file holds.
MeshFormat check_mesh_file(const std::string& path);

/// The value of 3D Slicer's `SPACE=` in the header of a mesh, in capitals ("LPS", "RAS"); several that differ with
/// " and " between them; "" without one. `start`: the first bytes of the file, or what read_vtp() returned.
std::string stated_space(std::string_view start, MeshFormat format);

/// As many bytes of a file as hold its header.
inline constexpr std::size_t kMeshHeaderBytes = std::size_t{64} * 1024;

// A binary STL: 80 bytes of header, the number of triangles, the triangles.
inline constexpr std::size_t kStlHeaderBytes = 84;
inline constexpr std::size_t kStlTriangleBytes = 50;

std::uint32_t stl_count(std::string_view start);
/// Some programs write one of these where they do not know the number; the length of the file then says it.
constexpr bool is_unknown_stl_count(std::uint32_t count) {
  return count == 0 || count == 0xFFFFFFFFU;
}

/// A corner in file units, in single precision, as a binary STL has it.
using StlCorner = std::array<float, 3>;
/// Takes the corners of a triangle.
using StlSink = std::function<void(const std::array<StlCorner, 3>&)>;

/// Reads the triangles of a binary STL, whose length check_mesh_file() has checked. Returns what to warn of: a number
/// of triangles that the length of the file says, bytes after the last triangle.
std::vector<std::string> read_binary_stl(std::string_view bytes, const StlSink& sink);

/// Reads the triangles of an ASCII STL by its words: keywords in any case, several solids, any blanks and ends of
/// lines; unknown words are skipped to the end of their line, except within a loop. A facet of more than three vertices
/// becomes a fan. Returns what to warn of: decimal commas, a missing end. Throws InputError with the line: a vertex
/// without three numbers, a facet of fewer than three vertices, a file that ends within a facet.
std::vector<std::string> read_ascii_stl(const std::string& path, std::string_view text, const StlSink& sink);

/// Reads the polygons and strips of a VTP file, VTK's XML. Returns its field data on the frame, "SPACE=LPS", or
/// "SPACE=". Throws InputError: a damaged or truncated file, cells of missing points, a compression other than zlib's.
std::string read_vtp(const std::string& path, std::string_view bytes, const StlSink& sink);

struct MeshContents {
  TriangleMesh mesh;   ///< in mm; vertices merged, and welded (weld()) where the surface has holes
  std::string space;   ///< the frame that the header states: "LPS", "RAS", another; "" without one
  Diagnostics report;  ///< what was welded; warnings of numbers of triangles that the header has wrong, and the like
};

/// Reads a mesh in a child process, and multiplies by `scale` (file units to mm), whatever its frame.
/// `key`: that of the scenario, if it names the file. Throws InputError: no such file, another format (with how to
/// convert it), unreadable or truncated, no triangle, NaN or infinite coordinate.
MeshContents read_mesh_contents(const std::string& path, double scale, const std::string& key = "");

TriangleMesh read_mesh(const std::string& path, double scale);

/// The mesh file of a part that has a frame of its own, and the keys that name it.
struct PartFile {
  std::string path;
  double scale = 1;  ///< mm per file unit
  std::string key;
  std::string scale_key;
  std::string part;        ///< "tool"
  double least_mm = 0.01;  ///< along each axis

  [[nodiscard]] InputError error(const std::string& found, const std::string& expected) const {
    return {SourceLocation{path, 0, 0}, key, found, expected};
  }
};

/// Reads a closed surface (mm, in the frame of the part whatever its header says) and turns it outwards. Throws
/// InputError: a surface with holes, a size that is not supported.
TriangleMesh read_closed_part(const PartFile& file, Diagnostics& report);

/// Writes a binary STL (mm). Throws RunError when the file cannot be written.
void write_stl(const std::string& path, const TriangleMesh& mesh, const std::string& space = "");

}  // namespace reamsim
