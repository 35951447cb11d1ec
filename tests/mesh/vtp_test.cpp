// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// VTP files in each encoding that VTK's writer has, written here after its documentation of the format.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "sim/base/error.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

std::string base64(const std::string& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * static_cast<unsigned>(k)) & 63U];
  }
  return out;
}

/// How a file is written.
struct Encoding {
  std::string format = "ascii";  ///< or "binary", "raw" or "base64", which are appended
  bool zlib = false;
  bool wide = true;  ///< 64-bit headers, Float64 and Int64, rather than 32 bits
  bool big_endian = false;
  std::string compressor = zlib ? "vtkZLibDataCompressor" : "";
  std::string space = "RAS";
};

class VtpWriter {
 public:
  explicit VtpWriter(Encoding encoding) : encoding_(std::move(encoding)) {}

  void add_piece(const TriangleMesh& mesh) {
    std::vector<double> points, corners, ends;
    for (const Vec3& v : mesh.vertices) points.insert(points.end(), v.data(), v.data() + 3);
    for (const MeshTriangle& t : mesh.triangles) {
      corners.insert(corners.end(), t.begin(), t.end());
      ends.push_back(static_cast<double>(corners.size()));
    }
    add_piece(points, "Polys", corners, ends);
  }
  void add_piece(const std::vector<double>& points, const std::string& kind, const std::vector<double>& corners,
                 const std::vector<double>& ends) {
    xml_ += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"1\" NumberOf{}=\"{}\">\n", points.size() / 3,
                        kind, ends.size());
    xml_ += "<PointData Scalars=\"s\">" + array<float>("s", std::vector<double>(points.size() / 3)) + "</PointData>\n";
    xml_ += "<Points>" + reals("Points", points) + "</Points>\n";
    xml_ += "<Verts>" + whole("connectivity", {0}) + whole("offsets", {1}) + "</Verts>\n";
    xml_ += "<" + kind + ">" + whole("connectivity", corners) + whole("offsets", ends) + "</" + kind + ">\n</Piece>\n";
  }
  std::string text() {
    std::string field;
    if (!encoding_.space.empty()) {
      std::vector<double> letters(encoding_.space.begin(), encoding_.space.end());
      letters.push_back(0);
      field = "<FieldData>" + array<std::uint8_t>("SPACE", letters, "Array") + "</FieldData>\n";
    }
    return fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" header_type=\"{}\"{}>\n"
        "<PolyData>\n{}{}</PolyData>\n{}</VTKFile>\n",
        encoding_.big_endian ? "BigEndian" : "LittleEndian", encoding_.wide ? "UInt64" : "UInt32",
        encoding_.compressor.empty() ? "" : " compressor=\"" + encoding_.compressor + "\"", field, xml_,
        appended_.empty()
            ? ""
            : "<AppendedData encoding=\"" + encoding_.format + "\">\n_" + appended_ + "\n</AppendedData>\n");
  }

 private:
  std::string reals(const std::string& name, const std::vector<double>& values) {
    return encoding_.wide ? array<double>(name, values) : array<float>(name, values);
  }
  std::string whole(const std::string& name, const std::vector<double>& values) {
    return encoding_.wide ? array<std::int64_t>(name, values) : array<std::int32_t>(name, values);
  }
  template <class Number>
  std::string bytes_of(const std::vector<double>& values) const {
    std::string out;
    for (const double value : values) {
      const auto number = static_cast<Number>(value);
      std::string one(reinterpret_cast<const char*>(&number), sizeof number);
      if (encoding_.big_endian) std::ranges::reverse(one);
      out += one;
    }
    return out;
  }
  std::string header(const std::vector<double>& words) const {
    return encoding_.wide ? bytes_of<std::uint64_t>(words) : bytes_of<std::uint32_t>(words);
  }
  std::string with_header(const std::string& bytes) const {
    const auto encoded = [this](const std::string& all) { return encoding_.format == "raw" ? all : base64(all); };
    if (encoding_.compressor.empty()) return encoded(header({static_cast<double>(bytes.size())}) + bytes);
    constexpr std::size_t kBlock = 240;
    std::vector<double> words{0, kBlock, static_cast<double>(bytes.size() % kBlock)};
    std::string blocks;
    for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
      const std::string block = bytes.substr(at, kBlock);
      uLongf size = compressBound(block.size());
      std::string packed(size, '\0');
      compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(block.data()),
               block.size());
      ++words[0];
      words.push_back(static_cast<double>(size));
      blocks += packed.substr(0, size);
    }
    return encoded(header(words)) + encoded(blocks);
  }
  template <class Number>
  std::string array(const std::string& name, const std::vector<double>& values, const std::string& tag = "DataArray") {
    const std::string type =
        tag == "Array" ? "String"
                       : fmt::format("{}{}", std::is_integral_v<Number> ? "Int" : "Float", 8 * sizeof(Number));
    const std::string begin = fmt::format(R"(<{} type="{}" Name="{}" NumberOfComponents="{}" format=")", tag, type,
                                          name, name == "Points" ? 3 : 1);
    const std::string key = R"(<InformationKey name="L2_NORM_RANGE"><Value index="0">1</Value></InformationKey>)";
    const std::string end = key + "</" + tag + ">\n";
    if (encoding_.format == "binary")
      return begin + "binary\">\n  " + with_header(bytes_of<Number>(values)) + "\n" + end;
    if (encoding_.format != "ascii") {
      const std::size_t offset = appended_.size();
      appended_ += with_header(bytes_of<Number>(values));
      return begin + fmt::format("appended\" offset=\"{}\"/>\n", offset);
    }
    std::string out = begin + "ascii\">\n";
    for (const double value : values) out += fmt::format(" {:.9g}", value);
    return out + "\n" + end;
  }

  Encoding encoding_;
  std::string xml_;
  std::string appended_;
};

class Vtp : public ::testing::Test {
 protected:
  MeshContents read(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
    return read_mesh_contents(path_, 1);
  }
  std::string error_of(const std::string& bytes) const {
    try {
      read(bytes);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_));
      EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
      return error.what();
    }
    ADD_FAILURE() << "read without an error";
    return {};
  }
  static std::string file_of(const TriangleMesh& mesh, const Encoding& encoding) {
    VtpWriter writer(encoding);
    writer.add_piece(mesh);
    return writer.text();
  }
  static std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  static std::vector<Encoding> encodings() {
    std::vector<Encoding> out{{.format = "ascii"}, {.format = "ascii", .wide = false}};
    for (const char* format : {"binary", "raw", "base64"}) {
      for (const bool zlib : {false, true}) {
        for (const bool wide : {false, true}) {
          for (const bool big_endian : {false, true})
            out.push_back({.format = format, .zlib = zlib, .wide = wide, .big_endian = big_endian});
        }
      }
    }
    return out;
  }
  /// Without a child process, many of which would take minutes.
  void read_here(const std::string& bytes) const {
    read_vtp(path_, bytes, [](const std::array<StlCorner, 3>&) {});
  }

  TempDir dir_;
  std::string path_ = dir_.path() + "/bone.vtp";
  TriangleMesh sphere_ = sphere_mesh({10, -20, 30}, 12, 1);
  TriangleMesh box_ = box_mesh({0, 0, 0}, {1, 2, 3});
};

TEST_F(Vtp, EveryEncodingIsReadAlike) {
  for (const Encoding& encoding : encodings()) {
    SCOPED_TRACE(fmt::format("{} zlib {} wide {} big-endian {}", encoding.format, encoding.zlib, encoding.wide,
                             encoding.big_endian));
    const MeshContents contents = read(file_of(sphere_, encoding));
    EXPECT_EQ(contents.mesh.triangles.size(), sphere_.triangles.size());
    EXPECT_TRUE(diagnose(contents.mesh).closed_manifold());
    EXPECT_NEAR(contents.mesh.volume_mm3(), sphere_.volume_mm3(), 1e-2);
    EXPECT_EQ(contents.space, "RAS");
  }
}

TEST_F(Vtp, TheFieldDataStateTheFrame) {
  for (const char* format : {"ascii", "binary", "raw"}) {
    EXPECT_EQ(read(file_of(box_, {.format = format, .space = "LPS"})).space, "LPS");
    EXPECT_EQ(read(file_of(box_, {.format = format, .space = ""})).space, "");
  }
  EXPECT_EQ(read(with(file_of(box_, {}), "Name=\"SPACE\"", "Name=\"SPACING\"")).space, "");
}

TEST_F(Vtp, PiecesStripsAndPolygons) {
  const std::vector<double> points{0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
  VtpWriter strips({.format = "raw"});
  strips.add_piece(points, "Strips", {0, 1, 3, 2, 0, 1}, {6});  // a tetrahedron
  const TriangleMesh tetrahedron = read(strips.text()).mesh;
  EXPECT_EQ(tetrahedron.triangles.size(), 4U);
  EXPECT_TRUE(diagnose(tetrahedron).closed_manifold()) << diagnose(tetrahedron).text();
  EXPECT_NEAR(std::abs(tetrahedron.volume_mm3()), 1, 1e-6);

  VtpWriter pieces({.format = "binary", .zlib = true});
  pieces.add_piece(box_);
  pieces.add_piece(points, "Polys", {0, 1, 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, {2, 5, 8, 11, 14});  // a line first
  EXPECT_EQ(read(pieces.text()).mesh.triangles.size(), 16U);
  EXPECT_NEAR(read(pieces.text()).mesh.volume_mm3(), 6 + 1, 1e-6);

  VtpWriter pentagon({});
  pentagon.add_piece({0, 0, 0, 2, 0, 0, 3, 1, 0, 1, 2, 0, 0, 1, 0}, "Polys", {0, 1, 2, 3, 4}, {5});
  EXPECT_EQ(read(pentagon.text()).mesh.triangles.size(), 3U);
}

TEST_F(Vtp, WhatIsNotReadIsNamed) {
  for (const char* name : {"vtkLZ4DataCompressor", "vtkLZMADataCompressor"}) {
    EXPECT_THAT(error_of(file_of(box_, {.format = "binary", .compressor = name})),
                HasSubstr(std::string("compressed by ") + name + "; save it uncompressed"));
    EXPECT_EQ(read(file_of(box_, {.compressor = name})).mesh.triangles.size(), 12U) << "text is not compressed";
  }
  const std::string text = file_of(box_, {});
  for (const char* type : {"UnstructuredGrid", "PPolyData"})
    EXPECT_THAT(error_of(with(text, "PolyData", type)), HasSubstr("a VTK file; save its surface as VTP in 3D Slicer"));
  EXPECT_THAT(error_of(with(text, "Float64\" Name=\"Points", "Bit\" Name=\"Points")), HasSubstr("of type Bit"));
  EXPECT_THAT(error_of(with(text, "Float64\" Name=\"Points", "Flo\nat\" Name=\"Points")),
              HasSubstr("of type Flo\\x0aat"));
  EXPECT_THAT(error_of(with(text, "<Polys>", "<Lines>")), HasSubstr(path_ + ":"));
}

TEST_F(Vtp, SizesBeyondTheFileAreRefusedBeforeMemoryIsTaken) {
  const std::string raw = file_of(box_, {.format = "raw", .wide = false, .space = ""});
  const std::size_t data = raw.find('_', raw.find("<AppendedData")) + 1;
  const std::string packed = file_of(box_, {.format = "raw", .zlib = true, .space = ""});
  const std::size_t table = packed.find('_', packed.find("<AppendedData")) + 1;
  for (const std::size_t at : {std::size_t{0}, std::size_t{36}}) {  // the scalars, which are not read, and the points
    std::string bytes = raw;
    bytes.replace(data + at, 4, "\xFF\xFF\xFF\xFF");
    if (at > 0) {
      EXPECT_THAT(error_of(bytes), HasSubstr("the length of an array is 4294967295, at most "));
    } else {
      EXPECT_EQ(read(bytes).mesh.triangles.size(), 12U);
    }
  }
  const std::size_t points = packed.find("Name=\"Points\"");
  const std::size_t start = table + std::stoul(packed.substr(packed.find("offset=\"", points) + 8));
  for (std::size_t word = 0; word < 4; ++word) {
    for (const char* value : {"\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF", "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x7F"}) {
      std::string bytes = packed;
      bytes.replace(start + 8 * word, 8, value, 8);
      if (word == 1) bytes.replace(start + 16, 8, 8, '\0');  // the last block as large as the others
      EXPECT_THAT(error_of(bytes), HasSubstr(" is possible; ")) << word;
    }
  }
  EXPECT_THAT(error_of(with(raw, "offset=\"36\"", "offset=\"99999999999999999999\"")), HasSubstr("an offset is 1e+20"));
  EXPECT_THAT(error_of(with(raw, "offset=\"36\"", "offset=\"-2\"")), HasSubstr("an offset is -1"));
}

TEST_F(Vtp, CellsThatDoNotFit) {
  const std::vector<double> points{0, 0, 0, 1, 0, 0, 0, 2, 0};
  for (const auto& [corners, ends, said] :
       std::vector<std::tuple<std::vector<double>, std::vector<double>, std::string>>{
           {{0, 1, 3}, {3}, "the point of a cell is 3, at most 2 is possible"},
           {{0, 1, -1}, {3}, "the point of a cell is -1"},
           {{0, 1, 2}, {4}, "the length of a cell is 4, at most 3"},
           {{0, 1, 2}, {3, 0}, "the length of a cell is -3"}}) {
    VtpWriter writer({});
    writer.add_piece(points, "Polys", corners, ends);
    EXPECT_THAT(error_of(writer.text()), HasSubstr(said));
  }
  const std::string text = file_of(box_, {});
  EXPECT_THAT(error_of(with(text, "NumberOfPolys=\"12\"", "NumberOfPolys=\"13\"")), HasSubstr("of 13 Polys has 12"));
  VtpWriter none({});
  none.add_piece(points, "Polys", {}, {});
  EXPECT_THAT(error_of(none.text()), HasSubstr("a mesh of 0 triangles"));
  VtpWriter infinite({.format = "raw"});
  infinite.add_piece({0, 0, 0, 1, 0, 0, 0, 1e300, 0}, "Polys", {0, 1, 2}, {3});
  EXPECT_THAT(error_of(infinite.text()), HasSubstr("NaN or infinite"));
}

TEST_F(Vtp, EveryTruncationIsAnError) {
  for (const Encoding& encoding : encodings()) {
    const std::string whole = file_of(box_, encoding);
    for (std::size_t length = 0; length + std::string(">\n").size() < whole.size(); ++length) {
      EXPECT_THROW(read_here(whole.substr(0, length)), InputError) << encoding.format << length;
    }
    EXPECT_THAT(error_of(whole.substr(0, whole.size() / 2)), HasSubstr("the VTP file is damaged or truncated"));
  }
}

TEST_F(Vtp, AnyByteMayBeDamaged) {
  std::mt19937 random(31);
  for (const Encoding& encoding : encodings()) {
    const std::string whole = file_of(box_, encoding);
    int refused = 0;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(random() & 255);
      try {
        read_here(bytes);
      } catch (const InputError&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, 100) << encoding.format;
  }
}

}  // namespace
}  // namespace reamsim::test
