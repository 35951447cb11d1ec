// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace reamsim {

/// A corner in file units, in single precision, as a binary STL has it.
using StlCorner = std::array<float, 3>;
/// Takes the corners of a triangle.
using StlSink = std::function<void(const std::array<StlCorner, 3>&)>;

/// Reads the triangles of a binary STL, whose length check_mesh_file() has checked. Returns what to warn of: a number
/// of triangles that the length of the file says, bytes after the last triangle.
std::vector<std::string> read_binary_stl(std::string_view bytes, const StlSink& sink);

/// Reads the triangles of an ASCII STL by its words: keywords in any case, names of any length, several solids, any
/// blanks and ends of lines; words that it does not know are skipped to the end of their line, except within a loop.
/// A facet of more than three vertices becomes a fan. Returns what to warn of: decimal commas, a missing end. Throws
/// InputError with the line: a vertex without three numbers, a facet of fewer than three vertices, a file that ends
/// within a facet.
std::vector<std::string> read_ascii_stl(const std::string& path, std::string_view text, const StlSink& sink);

}  // namespace reamsim
