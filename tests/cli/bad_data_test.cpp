// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// A bone section that takes scan `file`, with more keys of bone.ct.
std::string ct_bone(const std::string& file, const std::string& keys = "") {
  return with_bone("  source: ct\n  voxel_mm: 1\n  ct: {path: " + file + keys + "}\n");
}

std::string mesh_bone(const std::string& file) {
  return with_bone("  source: mesh\n  voxel_mm: 1\n  mesh: {path: " + file + "}\n");
}

std::string with_tool(const std::string& file) {
  return with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", file);
}

class BadData : public CliTest {
 protected:
  /// The same mistake is found in a bone and in a tool.
  void expect_mesh_refused(const std::string& file, const std::string& bytes,
                           std::initializer_list<const char*> words) const {
    write(file, bytes);
    expect_refused(run(mesh_bone(file)), 2, words);
    expect_refused(run(with_tool(file)), 2, words);
  }
};

TEST_F(BadData, TheScansAndTheCubeAreFine) {
  write("scan.nrrd", block_nrrd());
  expect_done(run(ct_bone("scan.nrrd"), {"--set", "motion.plunge.entry_mm=[10, 10, 15]"}));
  write("scan.nii", block_nifti());
  expect_done(run(ct_bone("scan.nii"), {"--overwrite"}));
  write("cube.stl", cube_stl(10));
  expect_done(run(mesh_bone("cube.stl"), {"--overwrite"}));
}

TEST_F(BadData, BoneAbsentFromTheCrop) {
  write("scan.nrrd", block_nrrd());
  expect_refused(run(ct_bone("scan.nrrd", ", crop_min_mm: [0, 0, 0], crop_max_mm: [3, 3, 3]")), 2,
                 {"scan.nrrd", "bone"});
  expect_refused(run(ct_bone("scan.nrrd", ", crop_min_mm: [50, 50, 50], crop_max_mm: [60, 60, 60]")), 2,
                 {"scan.nrrd", "crop"});
  expect_refused(run(ct_bone("scan.nrrd", ", threshold_hu: 5000")), 2, {"scan.nrrd", "threshold_hu"});
}

TEST_F(BadData, WarningsBeforeAnErrorArePrintedWithIt) {
  write("scan.nrrd", with(block_nrrd(), "space: left-posterior-superior", "space dimension: 3"));
  write("s.yaml", ct_bone("scan.nrrd", ", crop_min_mm: [50, 50, 50], crop_max_mm: [60, 60, 60]"));
  const std::vector<std::vector<std::string>> commands{{"run", "s.yaml", "-o", "out"},
                                                       {"check", "s.yaml"},
                                                       {"check", "s.yaml", "--json"},
                                                       {"import", "s.yaml", "-o", "bone.vdb"},
                                                       {"preview", "s.yaml", "-o", "page.html"},
                                                       {"init", "scan.nrrd", "-o", "first.yaml"}};
  for (const std::vector<std::string>& command : commands) {
    const ProgramResult result = reamsim({.arguments = command, .environment = {}, .folder = "", .interrupt_when = {}});
    SCOPED_TRACE(command.front());
    EXPECT_EQ(result.status, 2) << result.out << result.err;
    const std::size_t warning = result.err.find("the header does not say how the axes lie in the body");
    EXPECT_LT(warning, result.err.find("reamsim: error: ")) << result.err;
    EXPECT_EQ(warning, result.err.rfind("the header does not say how the axes lie in the body"))
        << "once: " << result.err;
  }
}

TEST_F(BadData, SeedOutsideBone) {
  write("scan.nrrd", block_nrrd());
  expect_refused(run(ct_bone("scan.nrrd", ", seed_mm: [1, 1, 1]")), 2, {"seed_mm"});
  expect_refused(run(ct_bone("scan.nrrd", ", seed_mm: [500, 1, 1]")), 2, {"seed_mm"});
}

TEST_F(BadData, MeshOpen) {
  expect_mesh_refused("open.stl", cube_stl(10, 1), {"open.stl", "3"});
}

TEST_F(BadData, MeshNonManifold) {
  // Two cubes that share one edge: four triangles meet there.
  std::string obj;
  for (const int shift : {0, 1}) {
    for (int corner = 0; corner < 8; ++corner) {
      obj += "v " + std::to_string(10 * ((corner & 1) + shift)) + " " +
             std::to_string(10 * ((corner >> 1 & 1) + shift)) + " " + std::to_string(10 * (corner >> 2)) + "\n";
    }
  }
  for (const int first : {1, 9}) {
    for (const char* face : {"021", "123", "456", "576", "014", "154", "263", "367", "042", "246", "135", "375"}) {
      obj += "f";
      for (int i = 0; i < 3; ++i) obj += " " + std::to_string(first + face[i] - '0');
      obj += "\n";
    }
  }
  write("edge.obj", obj);
  expect_refused(run(with_tool("edge.obj")), 2, {"edge.obj", "non-manifold"});
  expect_done(run(mesh_bone("edge.obj")));  // what is inside is clear
}

TEST_F(BadData, MeshDegenerate) {
  std::string stl = "solid flat\n";
  for (int i = 0; i < 4; ++i) {
    stl += "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 2 0 0\nendloop\nendfacet\n";
  }
  expect_mesh_refused("flat.stl", stl + "endsolid\n", {"flat.stl"});
}

TEST_F(BadData, MeshOfAnotherFormatIsSaidAtItsKey) {
  for (const char* file : {"part.step", "cube", "cube.stl"}) {
    write(file, "ISO-10303-21;\nHEADER;\n");
    expect_refused(run(mesh_bone(file)), 2, {"s.yaml:", "bone.mesh.path: ", file, "a STEP file; export it as STL"});
    expect_refused(run(with_tool(file)), 2, {"s.yaml:", "tool.mesh: ", file, "a STEP file; export it as STL"});
  }
}

TEST_F(BadData, AMeshUnderAnyNameIsAMesh) {
  write("cube.ply", cube_stl(10));
  expect_done(run(mesh_bone("cube.ply")));
}

TEST_F(BadData, MeshWithNaN) {
  expect_mesh_refused("nan.stl", with(cube_stl(10), "vertex 10 0 0", "vertex nan 0 0"), {"nan.stl"});
}

TEST_F(BadData, MeshWithoutTriangles) {
  expect_mesh_refused("none.stl", "solid none\nendsolid none\n", {"none.stl"});
  expect_mesh_refused("zero.stl", binary_stl(0, 0), {"zero.stl"});
  expect_mesh_refused("empty.stl", "", {"empty.stl"});
}

TEST_F(BadData, MeshOfUnknownKind) {
  expect_mesh_refused("mesh.txt", "hello\n", {"mesh.txt"});
}

TEST_F(BadData, VtkIsRefusedWithTheConversion) {
  const std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\">\n";
  expect_mesh_refused("bone.vtu", xml, {"bone.vtu", "VTK", "STL or PLY", "ParaView"});
  expect_refused(run(ct_bone("bone.vtu")), 2, {"bone.vtu", "VTK", "NRRD"});
  const ProgramResult imported = reamsim(
      {.arguments = {"import", "bone.vtu", "-o", "b.vdb"}, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_refused(imported, 2, {"bone.vtu", "STL or PLY"});
  EXPECT_FALSE(exists("b.vdb"));
}

TEST_F(BadData, MeshInTheWrongUnit) {
  write("scapula.stl", cube_stl(0.153));
  const std::string glenoid =
      "  side: left\n  glenoid: {center_mm: [0, 0, 0], normal: [0, 0, 1], superior: [0, 1, 0]}\n";
  const std::string mesh = with_bone("  source: mesh\n  voxel_mm: 1\n  mesh: {path: scapula.stl}\n" + glenoid);
  expect_refused(run(mesh), 2, {"scapula.stl", "set bone.mesh.scale: 1000 if the file is in metres"});
}

TEST_F(BadData, LabelMaps) {
  write("scan.nrrd", block_nrrd());
  write("labels.nrrd", block_nrrd());
  // The block's values are labels of a kind: 1000 is the bone.
  expect_done(run(ct_bone("scan.nrrd", ", label_map: {path: labels.nrrd, label: 1000}"),
                  {"--set", "motion.plunge.entry_mm=[10, 10, 15]"}));
  std::filesystem::remove_all(path("out"));
  expect_refused(run(ct_bone("scan.nrrd", ", label_map: {path: labels.nrrd, label: 7}")), 2,
                 {"labels.nrrd", "bone.ct.label_map.label", "no voxel in the crop has label 7"});
  expect_refused(run(ct_bone("scan.nrrd", ", label_map: {path: labels.nrrd, label: [scapula_left]}")), 2,
                 {"labels.nrrd", "'scapula_left'", "names no segments"});
  write("away.nrrd", with(block_nrrd(), "space origin: (0,0,0)", "space origin: (9,90,9)"));
  expect_refused(run(ct_bone("scan.nrrd", ", label_map: {path: away.nrrd, label: 1000}")), 2,
                 {"away.nrrd", "does not overlap the image", "(8.5, 89.5, 8.5)", "(-0.5, -0.5, -0.5)"});
}

TEST_F(BadData, TruncatedStl) {
  const std::string text = cube_stl(10);
  expect_mesh_refused("half.stl", text.substr(0, text.size() / 2), {"half.stl"});
  expect_mesh_refused("binary.stl", binary_stl(20, 40), {"binary.stl"});
}

TEST_F(BadData, StlThatClaimsFourBillionTriangles) {
  expect_mesh_refused("huge.stl", binary_stl(20, 4'000'000'000U), {"huge.stl"});
}

TEST_F(BadData, TruncatedNrrd) {
  write("half.nrrd", block_nrrd().substr(0, 4000));
  expect_refused(run(ct_bone("half.nrrd")), 2, {"half.nrrd"});
  write("header.nrrd", block_nrrd().substr(0, 30));
  expect_refused(run(ct_bone("header.nrrd")), 2, {"header.nrrd"});
  write("none.nrrd", "");
  expect_refused(run(ct_bone("none.nrrd")), 2, {"none.nrrd"});
}

TEST_F(BadData, TruncatedNifti) {
  write("half.nii", block_nifti().substr(0, 4000));
  expect_refused(run(ct_bone("half.nii")), 2, {"half.nii"});
  write("header.nii", block_nifti().substr(0, 100));
  expect_refused(run(ct_bone("header.nii")), 2, {"header.nii"});
}

TEST_F(BadData, HeaderThatClaimsATrillionVoxels) {
  write("huge.nrrd", nrrd_header(10000) + std::string(1000, '\0'));
  expect_refused(run(ct_bone("huge.nrrd")), 2, {"huge.nrrd"});
  write("huge.nii", nifti_header(30000) + std::string(1000, '\0'));
  expect_refused(run(ct_bone("huge.nii")), 2, {"huge.nii"});
}

TEST_F(BadData, NoScanAtAll) {
  std::filesystem::create_directory(path("empty"));
  expect_refused(run(ct_bone("empty")), 2, {"empty", "DICOM"});
  write("scan.txt", "hello\n");
  expect_refused(run(ct_bone("scan.txt")), 2, {"scan.txt"});
}

TEST_F(BadData, Vdb) {
  write("s.yaml", kSmall);
  const ProgramResult made = reamsim(
      {.arguments = {"import", "s.yaml", "-o", "bone.vdb"}, .environment = {}, .folder = "", .interrupt_when = {}});
  ASSERT_EQ(made.status, 0) << made.err;
  const auto vdb_bone = [](const std::string& file) {
    return with_bone("  source: vdb\n  voxel_mm: 0.5\n  vdb: {path: " + file + "}\n");
  };
  expect_done(run(vdb_bone("bone.vdb")));
  std::filesystem::remove_all(path("out"));
  const std::string bytes = read("bone.vdb");
  for (const double share : {0.0, 0.01, 0.3, 0.6, 0.9, 0.99}) {
    write("half.vdb", bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    expect_refused(run(vdb_bone("half.vdb")), 2, {"half.vdb"});
  }
  write("text.vdb", "hello\n");
  expect_refused(run(vdb_bone("text.vdb")), 2, {"text.vdb"});
}

}  // namespace
}  // namespace reamsim::test
