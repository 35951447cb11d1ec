// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Meshes as other programs write them (tests make the files; docs/inputs.md says what is done).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include "sim/base/error.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class OddMeshes : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = dir_.path() + "/" + name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string binary() const {
    const std::string path = dir_.path() + "/plain.stl";
    write_stl(path, mesh_);
    std::ifstream file(path, std::ios::binary);
    std::stringstream out;
    out << file.rdbuf();
    return out.str();
  }
  /// An ASCII STL with these words; each corner is moved by up to `noise_mm`.
  std::string ascii(const std::string& solid, const std::string& end, double noise_mm = 0) const {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> noise(-noise_mm, noise_mm);
    std::ostringstream out;
    out.precision(10);
    out << solid << "\n";
    for (const auto& triangle : mesh_.triangles) {
      out << "facet normal 0 0 0\n outer loop\n";
      for (const Vec3& p : mesh_.corners(triangle)) {
        out << "  vertex " << p.x() + noise(random) << " " << p.y() + noise(random) << " " << p.z() + noise(random)
            << "\n";
      }
      out << " endloop\nendfacet\n";
    }
    out << end << "\n";
    return out.str();
  }
  std::string ascii() const { return ascii("solid bone", "endsolid bone"); }
  static std::string with(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
      text.replace(at, from.size(), to);
    }
    return text;
  }
  static std::string capitals(std::string text) {
    for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
  }
  MeshContents contents(const std::string& name, const std::string& bytes) const {
    return read_mesh_contents(write(name, bytes), 1);
  }
  void expect_whole(const std::string& name, const std::string& bytes) const {
    const MeshContents read = contents(name, bytes);
    EXPECT_EQ(read.mesh.triangles.size(), mesh_.triangles.size()) << name;
    EXPECT_TRUE(diagnose(read.mesh).closed_manifold()) << name;
    EXPECT_NEAR(read.mesh.volume_mm3(), mesh_.volume_mm3(), 1e-3) << name;
  }
  std::string error_of(const std::string& name, const std::string& bytes) const {
    try {
      contents(name, bytes);
    } catch (const InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << name << " was read without an error";
    return {};
  }

  TempDir dir_;
  TriangleMesh mesh_ = sphere_mesh({10, -20, 30}, 12, 2);
};

TEST_F(OddMeshes, AsciiStlInEveryDialect) {
  const std::string plain = ascii();
  expect_whole("capitals.stl", capitals(plain));
  expect_whole("mixed.stl", with(with(plain, "facet", "Facet"), "vertex", "Vertex"));
  expect_whole("long.stl", with(plain, "solid bone", "solid " + std::string(100'000, 'n')));
  expect_whole("words.stl", with(plain, "solid bone", "solid my facet of a normal loop vertex"));
  expect_whole("nameless.stl", ascii("solid", "endsolid"));
  expect_whole("crlf.stl", with(plain, "\n", "\r\n"));
  expect_whole("cr.stl", with(plain, "\n", "\r"));
  expect_whole("one_line.stl", with(plain, "\n", " "));
  expect_whole("tabs.stl", with(with(plain, " vertex", "\t\tvertex"), "\n", "\n\n  "));
  expect_whole("bom.stl", "\xEF\xBB\xBF" + plain);
  expect_whole("apart.stl", with(with(plain, "endloop", "end loop"), "endfacet", "end facet"));
  expect_whole("no_normal.stl", with(plain, "facet normal 0 0 0", "facet"));
  expect_whole("nan_normal.stl", with(plain, "facet normal 0 0 0", "facet normal nan -nan(ind) inf"));
  expect_whole("colour.stl", with(plain, " outer", " color 0.5 0.5 0.5\n outer"));
  expect_whole("no_endfacet.stl", with(plain, "endfacet\n", ""));
  expect_whole("padded.stl", plain + std::string(100, '\0'));
  const std::size_t middle = plain.find("facet normal", plain.size() / 2);
  expect_whole("two.stl", plain.substr(0, middle) + "endsolid a\nsolid b\n" + plain.substr(middle));
}

TEST_F(OddMeshes, AsciiStlNumbers) {
  mesh_ = box_mesh({-1.5, -2.25, 0.5}, {1, 2, 3});
  const MeshContents read = contents("comma.stl", with(ascii(), ".", ","));
  EXPECT_NEAR(read.mesh.volume_mm3(), mesh_.volume_mm3(), 1e-6);
  EXPECT_THAT(read.report.warnings, Contains(HasSubstr("decimal commas")));
  expect_whole("fortran.stl", with(ascii(), "2.25", "0.225D+01"));
  expect_whole("plus.stl", with(ascii(), " 3\n", " +3.0e0\n"));
}

TEST_F(OddMeshes, AQuadrilateralFacetIsTwoTriangles) {
  const MeshContents read = contents(
      "quad.stl",
      "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid");
  EXPECT_EQ(read.mesh.triangles.size(), 2U);
}

TEST_F(OddMeshes, AsciiStlMistakesHaveTheirLine) {
  const std::string plain = ascii();
  EXPECT_THAT(error_of("cut.stl", plain.substr(0, plain.find("endloop", plain.size() / 2))),
              HasSubstr("a truncated STL: it ends within facet"));
  EXPECT_THAT(contents("no_end.stl", with(plain, "endsolid bone\n", "")).report.warnings,
              Contains(HasSubstr("may be truncated")));
  const std::string bad = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 x 0\n";
  EXPECT_THAT(error_of("letters.stl", bad), HasSubstr("letters.stl:5"));
  EXPECT_THAT(error_of("letters.stl", bad), HasSubstr("found \"x\" in a vertex; expected three numbers"));
  EXPECT_THAT(
      error_of("two.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n"),
      HasSubstr("facet 1 has 2 vertices"));
}

TEST_F(OddMeshes, CountsOfABinaryStlThatAreNone) {
  for (const std::uint32_t count : {0U, 0xFFFFFFFFU}) {
    std::string bytes = binary();
    std::memcpy(bytes.data() + 80, &count, sizeof count);
    for (const char* name : {"count.stl", "count.ply", "count"}) {
      const MeshContents read = contents(name, bytes);
      EXPECT_EQ(read.mesh.triangles.size(), mesh_.triangles.size());
      EXPECT_THAT(read.report.warnings,
                  Contains(HasSubstr("by its length it has " + std::to_string(mesh_.triangles.size()))));
    }
    EXPECT_THAT(error_of("cut.stl", bytes.substr(0, bytes.size() - 7)), HasSubstr("not that of whole triangles"));
  }
  std::string solid = binary();
  solid.replace(0, 6, "solid ");  // as SolidWorks and others write
  expect_whole("solid.stl", solid);
  EXPECT_THAT(contents("more.stl", binary() + "more").report.warnings,
              Contains(HasSubstr("4 bytes after them are not read")));
  std::string swapped = binary();
  std::reverse(swapped.begin() + 80, swapped.begin() + 84);
  EXPECT_THAT(error_of("swapped.stl", swapped), HasSubstr("big-endian"));
}

TEST_F(OddMeshes, TheContentSaysWhatAFileIs) {
  for (const char* name : {"bone.ply", "bone.obj", "bone", "bone.txt", "bone.off"}) {
    expect_whole(name, ascii());
    expect_whole(name, binary());
  }
  const std::string obj = "# a tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  EXPECT_NEAR(contents("obj.stl", obj).mesh.volume_mm3(), 1.0 / 6, 1e-6);
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 "
      "2 3\n";
  EXPECT_NEAR(contents("ply.obj", ply).mesh.volume_mm3(), 1.0 / 6, 1e-6);
}

TEST_F(OddMeshes, OtherFormatsAreNamed) {
  std::string dicom(132, '\0');
  dicom.replace(128, 4, "DICM");
  for (const auto& [bytes, said] : std::vector<std::pair<std::string, std::string>>{
           {"OFF\n4 4 0\n0 0 0\n", "a mesh in OFF; save it as STL or PLY with MeshLab"},
           {"glTF\2\0\0\0", "a mesh in glTF"},
           {"ISO-10303-21;\nHEADER;\n", "a STEP file; export it as STL"},
           {"<?xml version=\"1.0\"?>\n<!-- x -->\n<COLLADA version=\"1.4\">\n", "a scene in COLLADA"},
           {"<?xml version=\"1.0\"?>\n<!DOCTYPE GIFTI>\n<GIFTI Version=\"1.0\">\n", "a surface in GIfTI"},
           {std::string("PK\3\4\0\0", 6), "a zip archive, as 3MF is; unpack it"},
           {std::string("\x1F\x8B\x08\0", 4), "packed with gzip"},
           {"NRRD0004\ntype: short\n", "an image in NRRD; for a scan, use bone.source: ct"},
           {dicom, "a DICOM image"},
           {std::string("\xFF\xFEs\0o\0l\0", 8), "text in UTF-16"},
           {"hello\n", "its content is neither STL, OBJ, PLY nor VTP"},
           {"# vtk DataFile Version 5.1\n3D Slicer output. SPACE=RAS\nASCII\n", "its header says SPACE=RAS"}}) {
    EXPECT_THAT(error_of("bone.stl", bytes), HasSubstr(said));
    EXPECT_THAT(error_of("bone.off", bytes), HasSubstr(said));
  }
}

TEST_F(OddMeshes, SlicersSpaceIsReadFromEachHeader) {
  std::string bytes = binary();
  EXPECT_EQ(contents("none.stl", bytes).space, "");
  const std::string header = "3D Slicer output. SPACE=RAS";
  bytes.replace(0, header.size(), header);
  EXPECT_EQ(contents("ras.stl", bytes).space, "RAS");
  EXPECT_EQ(contents("ascii.stl", ascii("solid 3D Slicer output. SPACE=LPS", "endsolid")).space, "LPS");
  EXPECT_EQ(contents("small.stl", ascii("Solid x space = ras", "endsolid")).space, "RAS");
  EXPECT_EQ(contents("word.stl", ascii("solid INNERSPACE=RAS", "endsolid")).space, "");
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  EXPECT_EQ(contents("a.obj", "# 3D Slicer output. SPACE=LPS\n" + faces).space, "LPS");
  EXPECT_EQ(contents("b.obj", "# SPACE=LPS\n# SPACE=RAS\n" + faces).space, "LPS and RAS");
  const std::string ply =
      "ply\nformat ascii 1.0\ncomment SPACE=RAS\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 2 1\n";
  EXPECT_EQ(contents("c.ply", ply).space, "RAS");
}

TEST_F(OddMeshes, CornersThatDifferInTheLastDigitsAreWelded) {
  mesh_ = sphere_mesh({10, -20, 30}, 12, 3);
  const MeshContents read = contents("noisy.stl", ascii("solid", "endsolid", 2e-6));
  EXPECT_TRUE(diagnose(read.mesh).closed_manifold()) << diagnose(read.mesh).text();
  EXPECT_EQ(read.mesh.triangles.size(), mesh_.triangles.size());
  EXPECT_NEAR(read.mesh.volume_mm3(), mesh_.volume_mm3(), 0.01);
  EXPECT_THAT(read.report.notes, Contains(HasSubstr("corners of triangles were welded that differed by up to ")));
  EXPECT_THAT(contents("clean.stl", ascii()).report.notes, IsEmpty());
}

TEST_F(OddMeshes, CollapsedTrianglesAlongASeamDoNotHinderWelding) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {2, 3, 4});
  const std::array<std::int32_t, 3> first = mesh.triangles[0];
  for (std::size_t c = 0; c < 3; ++c) {  // the first triangle has corners of its own; its neighbours, collapsed ones
    mesh.triangles[0][c] = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(mesh.vertices[static_cast<std::size_t>(first[c])] + Vec3::Constant(1e-6));
    mesh.triangles.push_back({first[c], first[(c + 1) % 3], first[(c + 1) % 3]});
  }
  EXPECT_THAT(weld(mesh), HasSubstr("3 corners of triangles were welded"));
  EXPECT_TRUE(diagnose(mesh).closed_manifold()) << diagnose(mesh).text();
  EXPECT_EQ(mesh.triangles.size(), 12U);
}

TEST_F(OddMeshes, WeldingStaysUnderATenthOfTheShortestEdge) {
  mesh_ = box_mesh({0, 0, 0}, {100, 100, 1e-3});  // a plate: 10⁻⁵ of its size would be its thickness
  const MeshContents read = contents("plate.stl", ascii("solid", "endsolid", 2e-5));
  EXPECT_EQ(read.mesh.triangles.size(), 12U);
  EXPECT_TRUE(diagnose(read.mesh).closed_manifold()) << "corners 0.035 µm apart are welded, edges of 1 µm stay";
  const MeshContents apart = contents("apart.stl", ascii("solid", "endsolid", 2e-4));
  EXPECT_GT(diagnose(apart.mesh).boundary_edges, 0U);
}

TEST_F(OddMeshes, AnyBytesAreReadOrRefused) {
  std::mt19937 random(7);
  int read = 0, refused = 0;
  for (const std::string& whole : {ascii(), binary()}) {
    for (int round = 0; round < 40; ++round) {
      std::string bytes = whole.substr(0, round % 3 == 0 ? 1 + random() % whole.size() : whole.size());
      for (int flips = 0; flips < 4; ++flips) bytes[random() % bytes.size()] = static_cast<char>(random() & 255);
      try {
        for (const Vec3& p : contents("damaged.stl", bytes).mesh.vertices) EXPECT_TRUE(p.allFinite());
        ++read;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("damaged.stl"));
        ++refused;
      }
    }
  }
  EXPECT_EQ(read + refused, 80);
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace reamsim::test
