// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace reamsim {

// The content of a file decides what it is, never the ending of its name.

enum class MeshFormat { stl_binary, stl_ascii, obj, ply };

/// A mesh file before it is read.
struct MeshFile {
  MeshFormat format = MeshFormat::stl_binary;
  std::uintmax_t bytes = 0;
};

/// What a file is by its first bytes.
enum class ContentKind { mesh, image, vdb, foreign_mesh, unknown };
ContentKind content_kind(const std::string& path);

/// Checks the size, format and header of a mesh file, whose counts the library that reads it trusts. Throws InputError:
/// no such file, another format (with its name and what converts it), a header that claims more than the file holds.
MeshFile check_mesh_file(const std::string& path);

/// The same, at a key of the scenario.
void require_mesh(const std::string& path, const std::string& key);

/// The value of 3D Slicer's `SPACE=` in the header of a mesh, in capitals ("LPS", "RAS"); several that differ with
/// " and " between them; "" without one. `start`: the first bytes of the file.
std::string stated_space(std::string_view start, MeshFormat format);

/// As many bytes of a file as hold its header.
inline constexpr std::size_t kMeshHeaderBytes = std::size_t{64} * 1024;

// A binary STL: 80 bytes of header, the number of triangles, the triangles.
inline constexpr std::size_t kStlHeaderBytes = 84;
inline constexpr std::size_t kStlTriangleBytes = 50;

/// The number of triangles in the header.
std::uint32_t stl_count(std::string_view start);
/// Some programs write one of these where they do not know the number; the length of the file then says it.
constexpr bool is_unknown_stl_count(std::uint32_t count) {
  return count == 0 || count == 0xFFFFFFFFU;
}

}  // namespace reamsim
