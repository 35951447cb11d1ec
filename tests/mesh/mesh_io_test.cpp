// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "sim/base/error.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class MeshIo : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = dir_.path() + "/" + name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string box_stl() const {
    const std::string path = dir_.path() + "/box.stl";
    write_stl(path, box_mesh({-1, -2, -3}, {1, 2, 3}));
    return path;
  }
  /// The message of the InputError that reading this file throws; fails the test when it throws none.
  static std::string error_of(const std::string& path, double scale = 1) {
    try {
      read_mesh(path, scale);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path));
      EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
      return error.what();
    }
    ADD_FAILURE() << path << " was read without an error";
    return {};
  }

  TempDir dir_;
};

TEST_F(MeshIo, VtkFilesAreRefusedWithTheConversion) {
  const std::string legacy =
      "# vtk DataFile Version 3.0\nbone\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
  const std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\">\n";
  // By the name, also in capitals, and by the content, whatever the name.
  const std::vector<std::pair<std::string, std::string>> files{{"bone.vtk", legacy}, {"bone.vtp", xml},
                                                               {"BONE.VTP", xml},    {"bone.vtu", xml},
                                                               {"bone.stl", legacy}, {"bone.ply", xml}};
  for (const auto& [name, bytes] : files) {
    const std::string text = error_of(write(name, bytes));
    EXPECT_THAT(text, HasSubstr("a VTK file; save its surface as VTP in 3D Slicer")) << name;
    EXPECT_THAT(text, HasSubstr("ParaView")) << name;
    EXPECT_THAT(text, HasSubstr("pyvista.read(")) << name;
  }
}

TEST_F(MeshIo, StlKeepsTheSurfaceAndJoinsItsVertices) {
  const TriangleMesh mesh = read_mesh(box_stl(), 1);
  EXPECT_EQ(mesh.vertices.size(), 8U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_NEAR(mesh.volume_mm3(), 2 * 4 * 6, 1e-12);
  EXPECT_EQ(mesh.bounds().min, Vec3(-1, -2, -3));
  EXPECT_EQ(mesh.bounds().max, Vec3(1, 2, 3));
}

TEST_F(MeshIo, ScaleTurnsFileUnitsIntoMillimetres) {
  EXPECT_NEAR(read_mesh(box_stl(), 10).volume_mm3(), 48e3, 1e-9);
}

TEST_F(MeshIo, WrittenTwiceTheSameBytes) {
  const std::string first = file_bytes(box_stl());
  EXPECT_EQ(first, file_bytes(box_stl()));
  EXPECT_EQ(first.size(), 84U + 12 * 50);
}

TEST_F(MeshIo, ReadsAsciiStlObjAndPly) {
  const std::string obj =
      write("tetra.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_NEAR(read_mesh(obj, 1).volume_mm3(), 1.0 / 6, 1e-12);
  const std::string ply = write("tetra.ply",
                                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                                "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
                                "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  EXPECT_NEAR(read_mesh(ply, 1).volume_mm3(), 1.0 / 6, 1e-12);
  const std::string stl = write("flat.stl",
                                "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                                "endloop\nendfacet\nendsolid one\n");
  EXPECT_EQ(read_mesh(stl, 1).triangles.size(), 1U);
}

TEST_F(MeshIo, QuadsBecomeTriangles) {
  const std::string path = write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_EQ(read_mesh(path, 1).triangles.size(), 2U);
}

TEST_F(MeshIo, SaysWhatIsWrongWithTheFile) {
  EXPECT_THAT(error_of(dir_.path() + "/none.stl"), HasSubstr("no such file"));
  std::filesystem::create_directory(dir_.path() + "/folder.stl");
  EXPECT_THAT(error_of(dir_.path() + "/folder.stl"), HasSubstr("a folder"));
  EXPECT_THAT(error_of(write("empty.stl", "")), HasSubstr("empty"));
  EXPECT_THAT(error_of(write("mesh.blend", "x")), HasSubstr(".blend"));
  EXPECT_THAT(error_of(write("noise.ply", "this is no mesh")), HasSubstr("PLY"));
  EXPECT_THAT(error_of(write("points.obj", "v 0 0 0\nv 1 0 0\n")), HasSubstr("mesh"));
  EXPECT_THAT(error_of(box_stl(), 0), HasSubstr("scale"));
  EXPECT_THAT(error_of(box_stl(), NAN), HasSubstr("scale"));
}

TEST_F(MeshIo, StlOfZeroTriangles) {
  EXPECT_THAT(error_of(write("none.stl", std::string(84, '\0'))), HasSubstr("0 triangles"));
}

TEST_F(MeshIo, NanAndInfinity) {
  std::string bytes = file_bytes(box_stl());
  for (const float value : {NAN, INFINITY}) {
    std::memcpy(bytes.data() + 84 + 5 * 50 + 12, &value, sizeof value);
    EXPECT_THAT(error_of(write("nan.stl", bytes)), HasSubstr("triangle 6"));
  }
}

TEST_F(MeshIo, HeadersThatClaimTooMuch) {
  std::string bytes = file_bytes(box_stl());
  const std::uint32_t many = 4000000000U;
  std::memcpy(bytes.data() + 80, &many, sizeof many);
  EXPECT_THAT(error_of(write("many.stl", bytes)), HasSubstr("4000000000 triangles, the file holds 12"));
  EXPECT_THAT(error_of(write("many.ply",
                             "ply\nformat ascii 1.0\nelement vertex 1000000000000\nproperty float x\n"
                             "end_header\n0\n")),
              HasSubstr("claims more"));
}

TEST_F(MeshIo, EveryTruncationOfAnStlIsAnError) {
  const std::string whole = file_bytes(box_stl());
  for (std::size_t length = 1; length < whole.size(); length += 7) {
    EXPECT_NE(error_of(write("cut.stl", whole.substr(0, length))), "") << length << " bytes";
  }
}

TEST_F(MeshIo, DamagedFilesNeverCrash) {
  constexpr unsigned kSeed = 20;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.stl", file_bytes(box_stl())},
      {"a.ply", text},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"}};
  for (const auto& [name, whole] : files) {
    for (int round = 0; round < 150; ++round) {
      std::string bytes = whole.substr(0, round % 3 == 0 ? 1 + random() % whole.size() : whole.size());
      for (int flips = 0; flips < 3; ++flips) bytes[random() % bytes.size()] = static_cast<char>(random() & 255);
      try {
        const TriangleMesh mesh = read_mesh(write(name, bytes), 1);
        for (const auto& triangle : mesh.triangles) {
          for (const std::int32_t v : triangle) ASSERT_LT(static_cast<std::size_t>(v), mesh.vertices.size());
        }
      } catch (const InputError&) {  // as good
      }
    }
  }
}

TEST_F(MeshIo, AFaceWithoutVertices) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0\n";
  EXPECT_THAT(error_of(write("face.ply", text)), HasSubstr("face 2 has no vertices"));
}

TEST_F(MeshIo, WritingWhereNothingCanBeWritten) {
  EXPECT_THROW(write_stl(dir_.path() + "/none/box.stl", box_mesh({0, 0, 0}, {1, 1, 1})), RunError);
}

}  // namespace
}  // namespace reamsim::test
