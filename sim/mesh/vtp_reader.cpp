// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <openssl/evp.h>
#include <zlib.h>
#include <algorithm>
#include <bit>
#include <boost/property_tree/xml_parser.hpp>
#include <map>
#include <numeric>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/mesh/mesh_io.h"

namespace reamsim {

namespace {

constexpr const char* kSaveAgain = "the VTP file is damaged or truncated: save it again";
using Tree = boost::property_tree::ptree;
/// Of any type, also indices and sizes: integers are exact up to 2^53, above every limit.
using Numbers = std::vector<double>;

template <class Number>
Numbers numbers_of(const std::string& bytes, bool swap) {
  Numbers out(bytes.size() / sizeof(Number));
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::array<char, sizeof(Number)> one{};
    std::copy_n(bytes.data() + i * sizeof one, sizeof one, one.begin());
    if (swap) std::ranges::reverse(one);
    out[i] = static_cast<double>(std::bit_cast<Number>(one));
  }
  return out;
}

const std::map<std::string, Numbers (*)(const std::string&, bool)> kTypes{
    {"Float32", numbers_of<float>},      {"Float64", numbers_of<double>},       {"Int32", numbers_of<std::int32_t>},
    {"Int64", numbers_of<std::int64_t>}, {"UInt32", numbers_of<std::uint32_t>}, {"UInt64", numbers_of<std::uint64_t>},
    {"String", numbers_of<std::uint8_t>}};

const Tree kNone;

struct VtpFile {
  std::string path;
  Tree tree = {};
  bool swap = false, appended_base64 = false;
  std::string_view appended = {};

  /// Sends the triangles to `sink`. Returns the field data that state the frame.
  std::string read(std::string_view bytes, const StlSink& sink) {
    const std::size_t end = bytes.rfind("</VTKFile"), tag = std::min(bytes.find("<AppendedData"), end);
    if (end == std::string_view::npos) fail("a VTP file without its end");
    std::istringstream xml(std::string(bytes.substr(0, tag)) + "</VTKFile>");  // raw data are no XML
    boost::property_tree::read_xml(xml, tree, boost::property_tree::xml_parser::no_comments);
    swap = tree.get("VTKFile.<xmlattr>.byte_order", "") == "BigEndian";
    const std::size_t first = std::min(bytes.find('_', tag), end);
    appended = bytes.substr(first, end - first);
    appended_base64 = bytes.substr(tag, first - tag).find("raw") == std::string_view::npos;
    const Tree& contents = tree.get_child("VTKFile.PolyData", kNone);
    for (const auto& [name, piece] : contents) {
      const Numbers points = array(piece.get_child("Points", kNone), "");
      for (const char* kind : {"Polys", "Strips"}) read_cells(piece, kind, points, sink);
    }
    std::string space = "SPACE=";
    for (const double c : array(contents.get_child("FieldData", kNone), "SPACE"))
      space += static_cast<char>(checked("a character of SPACE", c, 127));
    return space;
  }

  [[noreturn]] void fail(const std::string& found, const std::string& expected = kSaveAgain) const {
    refuse_file(path, printable(found.substr(0, 100)), expected);
  }

  /// A size or an index, from 0 to `most`.
  std::size_t checked(const char* name, double number, auto most) const {
    if (number >= 0 && number <= static_cast<double>(most)) return static_cast<std::size_t>(number);
    fail(fmt::format("{} is {:.15g}, at most {} is possible", name, number, most));
  }

  /// The first data array of this name, or of any for ""; no numbers without one.
  Numbers array(const Tree& parent, const std::string& name) const {
    for (const auto& [kind, node] : parent) {
      if (!kind.ends_with("Array") || (!name.empty() && node.get("<xmlattr>.Name", "") != name)) continue;
      const auto type = kTypes.find(node.get("<xmlattr>.type", ""));
      if (type == kTypes.end()) fail("numbers of type " + node.get("<xmlattr>.type", ""), "expected Float32 or Int64");
      std::string text = node.data();
      const std::string format = node.get("<xmlattr>.format", "ascii");
      if (format == "ascii") {
        std::istringstream in(text);
        const Numbers out(std::istream_iterator<double>(in), {});
        if (!in.eof()) fail(fmt::format("no number after {} in an array", out.size()));
        return out;
      }
      std::erase_if(text, [](unsigned char c) { return std::isspace(c) != 0; });
      if (format == "binary") return type->second(unpacked(text, true), swap);
      const std::size_t at = checked("an offset", node.get("<xmlattr>.offset", -1.0) + 1, appended.size());
      return type->second(unpacked(appended.substr(at), appended_base64), swap);
    }
    return {};
  }

  /// Takes `count` bytes from the data; in base64 with the padding after them.
  std::string take(std::string_view& data, bool base64, std::size_t count) const {
    const std::size_t held = base64 ? (count + 2) / 3 * 4 : count;
    std::string text(data.substr(0, checked("the length of an array", static_cast<double>(held), data.size())));
    data.remove_prefix(held);
    if (!base64) return text;
    std::string out(held / 4 * 3, '\0');
    const int length = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                                       reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(held));
    if (length != static_cast<int>(out.size())) fail("an array is no base64");
    return out.substr(0, count);
  }

  /// The bytes of the array at the beginning of `data`.
  std::string unpacked(std::string_view data, bool base64) const {
    const bool wide = tree.get("VTKFile.<xmlattr>.header_type", "") == "UInt64";
    const std::size_t word = wide ? 8 : 4;
    const auto header = [&](std::string_view& from, std::size_t words) {
      return kTypes.at(wide ? "UInt64" : "UInt32")(take(from, base64, words * word), swap);
    };
    std::string_view rest = data;
    const std::size_t length = checked("the length of an array", header(rest, 1)[0], data.size());
    const std::string compressor = tree.get("VTKFile.<xmlattr>.compressor", "");
    if (compressor.empty()) return take(data, base64, word + length).substr(word);
    if (compressor != "vtkZLibDataCompressor")
      fail("compressed by " + compressor, "save it uncompressed, or as STL or PLY, in ParaView or 3D Slicer");
    if (length == 0) return {};
    // Words: the number of blocks, the bytes of each, those of the last if it is smaller, those of each when
    // compressed.
    const Numbers sizes = header(data, 3 + length);
    const double sum = std::accumulate(sizes.begin() + 3, sizes.end(), 0.0);
    const std::string packed = take(data, base64, checked("the length of an array", sum, data.size()));
    const double whole = sizes[1] * static_cast<double>(sizes[2] == 0 ? length : length - 1) + sizes[2];
    std::string out(checked("the length of an array", whole, 1032 * sum), '\0');  // zlib's limit
    const auto* from = reinterpret_cast<const Bytef*>(packed.data());
    uLongf to = 0;
    for (std::size_t b = 3; b < sizes.size(); from += static_cast<uLong>(sizes[b++])) {
      uLongf bytes = out.size() - to;
      if (uncompress(reinterpret_cast<Bytef*>(out.data() + to), &bytes, from, static_cast<uLong>(sizes[b])) != Z_OK)
        fail("a block is not zlib's");
      to += bytes;
    }
    return out.substr(0, to);
  }

  /// Triangles of "Polys", each a fan, or "Strips".
  void read_cells(const Tree& piece, const std::string& kind, const Numbers& points, const StlSink& sink) const {
    const Numbers corners = array(piece.get_child(kind, kNone), "connectivity"),
                  ends = array(piece.get_child(kind, kNone), "offsets");
    const auto stated = piece.get("<xmlattr>.NumberOf" + kind, ends.size());
    if (stated != ends.size()) fail(fmt::format("a piece of {} {} has {}", stated, kind, ends.size()));
    const auto corner = [&, last = std::ssize(points) / 3 - 1](std::size_t i) {
      const double* point = &points[3 * checked("the point of a cell", corners[i], last)];
      return StlCorner{static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2])};
    };
    for (std::size_t first = 0, end = 0, cell = 0; cell < ends.size(); ++cell, first = end) {
      end += checked("the length of a cell", ends[cell] - static_cast<double>(first), corners.size() - first);
      for (std::size_t i = first; i + 2 < end; ++i) {
        const std::size_t odd = kind == "Strips" ? (i - first) % 2 : 0;
        sink({corner(kind == "Strips" ? i + odd : first), corner(i + 1 - odd), corner(i + 2)});
      }
    }
  }
};

}  // namespace

std::string read_vtp(const std::string& path, std::string_view bytes, const StlSink& sink) try {
  return VtpFile{.path = path}.read(bytes, sink);
} catch (const boost::property_tree::xml_parser_error& error) {
  throw InputError({path, static_cast<int>(error.line()), 0}, "", "no XML: " + error.message(), kSaveAgain);
}

}  // namespace reamsim
