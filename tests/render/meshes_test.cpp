// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "render/pictures/figures.h"
#include "render/pictures/overlay.h"
#include "render/surface/bone_surface.h"
#include "sim/base/error.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_io.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

namespace fs = std::filesystem;
using test::file_bytes;

constexpr double kVolumeTolerance = 0.005;  // of what summary.json says is left

/// What assimp finds in a glb: the mesh as it stands, without the node's turn.
struct LoadedGlb {
  TriangleMesh mesh;
  std::vector<Eigen::Vector3f> colors;
  std::vector<Vec3> normals;
  Mat3 turn = Mat3::Zero();
};

Vec3 vec3(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

LoadedGlb load_glb(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  LoadedGlb out;
  if (scene == nullptr || scene->mNumMeshes != 1) {
    ADD_FAILURE() << path << ": " << importer.GetErrorString();
    return out;
  }
  const aiMesh& mesh = *scene->mMeshes[0];
  EXPECT_TRUE(mesh.HasVertexColors(0) && mesh.HasNormals());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    out.mesh.vertices.push_back(vec3(mesh.mVertices[i]));
    const aiColor4D& c = mesh.mColors[0][i];
    out.colors.emplace_back(c.r, c.g, c.b);
    out.normals.push_back(vec3(mesh.mNormals[i]));
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const unsigned* t = mesh.mFaces[i].mIndices;
    out.mesh.triangles.push_back(
        {static_cast<std::int32_t>(t[0]), static_cast<std::int32_t>(t[1]), static_cast<std::int32_t>(t[2])});
  }
  const aiNode* node = scene->mRootNode;
  while (node->mNumMeshes == 0 && node->mNumChildren == 1) node = node->mChildren[0];
  const aiMatrix4x4& m = node->mTransformation;
  out.turn << m.a1, m.a2, m.a3, m.b1, m.b2, m.b3, m.c1, m.c2, m.c3;
  return out;
}

void expect_solid(const TriangleMesh& mesh, double volume_mm3) {
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_TRUE(found.closed_manifold()) << found.text();
  EXPECT_NEAR(found.volume_mm3, volume_mm3, kVolumeTolerance * volume_mm3);
}

/// The floats of a glb's accessor `attribute`: one or three for each vertex.
std::vector<float> floats(const std::string& path, const std::string& attribute) {
  const std::string bytes = file_bytes(path);
  std::uint32_t json_bytes = 0;
  std::memcpy(&json_bytes, bytes.data() + 12, sizeof json_bytes);
  const auto json = nlohmann::json::parse(bytes.substr(20, json_bytes));
  const auto& accessor = json["accessors"][json["meshes"][0]["primitives"][0]["attributes"][attribute].get<int>()];
  const auto& view = json["bufferViews"][accessor["bufferView"].get<int>()];
  std::vector<float> out(accessor["count"].get<std::size_t>() * (accessor["type"] == "VEC3" ? 3 : 1));
  std::memcpy(out.data(), bytes.data() + 20 + json_bytes + 8 + view["byteOffset"].get<std::size_t>(),
              out.size() * sizeof(float));
  return out;
}

/// The depth of each loaded vertex. assimp 5.4 does not keep the order of the file.
std::vector<float> depths_mm(const std::string& path, const TriangleMesh& loaded) {
  const std::vector<float> positions = floats(path, "POSITION"), depths = floats(path, "_DEPTH_MM");
  EXPECT_EQ(positions.size(), 3 * depths.size());
  EXPECT_EQ(loaded.vertices.size(), depths.size());
  std::map<std::array<float, 3>, float> depth_at;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    depth_at[{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}] = depths[i];
  }
  std::vector<float> out;
  for (const Vec3& v : loaded.vertices) {
    out.push_back(depth_at.at({static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())}));
  }
  return out;
}

class Meshes : public ::testing::Test {
 protected:
  /// A small run's results, meshed; what it said is in report_.
  void mesh_results(const FixtureOptions& options) {
    truth_ = write_results(dir_.path(), options);
    left_mm3_ = read_stored_bone(dir_.path() + "/reamed.vdb").voxmap.bone_mm3();
    write_meshes(dir_.path(), 0, report_);
  }
  std::string stl() const { return dir_.path() + "/reamed.stl"; }
  std::string glb() const { return dir_.path() + "/reamed.glb"; }

  test::TempDir dir_;
  FixtureTruth truth_;
  double left_mm3_ = 0;
  Diagnostics report_;
};

TEST_F(Meshes, AreClosedFaceOutwardsAndHoldTheBonesVolume) {
  for (const bool whole_voxels : {false, true}) {
    SCOPED_TRACE(whole_voxels);
    mesh_results({.voxel_mm = 0.6, .frames = 20, .every = 10, .whole_voxels = whole_voxels});
    const LoadedGlb loaded = load_glb(glb());
    expect_solid(loaded.mesh, left_mm3_);
    const TriangleMesh printed = read_mesh(stl(), 1);
    expect_solid(printed, left_mm3_);
    EXPECT_EQ(printed.triangles.size(), loaded.mesh.triangles.size());
    EXPECT_THAT(report_.warnings, ::testing::IsEmpty());
    // Normals agree with the triangles that they shade.
    for (std::size_t i = 0; i < loaded.mesh.triangles.size(); i += 101) {
      const auto& t = loaded.mesh.triangles[i];
      const Vec3& a = loaded.mesh.vertices[static_cast<std::size_t>(t[0])];
      const Vec3 face = (loaded.mesh.vertices[static_cast<std::size_t>(t[1])] - a)
                            .cross(loaded.mesh.vertices[static_cast<std::size_t>(t[2])] - a);
      if (face.norm() < 1e-3) continue;
      EXPECT_GT(face.normalized().dot(loaded.normals[static_cast<std::size_t>(t[0])]), 0) << i;
    }
  }
}

TEST_F(Meshes, LieWhereTheBoneLiesInMillimetres) {
  mesh_results({.voxel_mm = 0.6, .frames = 20, .every = 10});
  const LoadedGlb loaded = load_glb(glb());
  // The reamed floor, below the tool's lowest point.
  const Vec3 floor = truth_.bone_from_glenoid * Vec3(0, 0, -truth_.deepest_mm);
  double nearest_mm = 1e9;
  for (const Vec3& v : loaded.mesh.vertices) nearest_mm = std::min(nearest_mm, (v - floor).norm());
  EXPECT_LT(nearest_mm, 0.6);
  // +z of the bone is up in a viewer: +y of glTF.
  EXPECT_TRUE((loaded.turn * Vec3::UnitZ()).isApprox(Vec3::UnitY(), 1e-6)) << loaded.turn;
  EXPECT_TRUE((loaded.turn * Vec3::UnitX()).isApprox(Vec3::UnitX(), 1e-6)) << loaded.turn;
}

TEST_F(Meshes, CarryTheDepthAsColourAndAsNumbers) {
  constexpr double kTop_mm = 3;
  mesh_results({.voxel_mm = 0.6, .frames = 20, .every = 10});
  write_meshes(dir_.path(), kTop_mm, report_);
  const LoadedGlb loaded = load_glb(glb());
  const std::vector<float> depth_mm = depths_mm(glb(), loaded.mesh);
  const Rigid glenoid_from_bone = truth_.bone_from_glenoid.inverse();
  int floor = 0;
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    const Vec3 p = glenoid_from_bone * loaded.mesh.vertices[i];
    if (p.z() < -8) {
      EXPECT_LT(depth_mm[i], 0.2) << p.transpose();
      EXPECT_GT(loaded.colors[i].x(), loaded.colors[i].z()) << "bone is warm";
    }
    // The middle of the face, away from its rim: the unreamed face is z = r²/64, the reamed one r²/58 − depth.
    if (p.head<2>().norm() > 5 || p.z() < -5) continue;
    ++floor;
    const double expected_mm = truth_.deepest_mm + p.head<2>().squaredNorm() * (1 / 64.0 - 1 / 58.0);
    EXPECT_NEAR(depth_mm[i], expected_mm, 0.3) << p.transpose();
    const Eigen::Vector3f map = depth_colors().at(depth_mm[i] / kTop_mm);
    const Eigen::Vector3f shown = loaded.colors[i].unaryExpr(
        [](float c) { return c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1 / 2.4F) - 0.055F; });
    EXPECT_LT((shown - map).cwiseAbs().maxCoeff(), 0.01F) << p.transpose();
  }
  EXPECT_GT(floor, 100);
}

TEST_F(Meshes, AreTheSameBytesEveryTime) {
  mesh_results({.voxel_mm = 0.8, .frames = 10, .every = 5});
  const std::string first_glb = file_bytes(glb());
  const std::string first_stl = file_bytes(stl());
  write_meshes(dir_.path(), 0, report_);
  EXPECT_TRUE(file_bytes(glb()) == first_glb);
  EXPECT_TRUE(file_bytes(stl()) == first_stl);
}

TEST_F(Meshes, BoneThatTheLatticeCutsIsClosedThere) {
  VoxelGrid grid;
  grid.voxel_mm = 0.5;
  grid.dims = Vec3i(24, 20, 17);
  FilledVoxmap voxmap(grid);
  for (int i = 0; i < grid.dims.prod(); ++i) {
    voxmap.grade.set({i % 24, i / 24 % 20, i / 480}, 200);
  }
  write_bone_vdb(dir_.path() + "/reamed.vdb", voxmap, {}, {});
  const UnreamedSurface unreamed(voxmap, voxmap.fill, voxmap.fill);
  const ReamedMesh reamed = make_reamed_mesh(dir_.path() + "/reamed.vdb", {voxmap, voxmap.fill}, unreamed, false);
  expect_solid(reamed.mesh, voxmap.bone_mm3());
  EXPECT_NEAR(diagnose(reamed.mesh).volume_mm3, 24 * 20 * 17 * 0.125, 0.001 * 24 * 20 * 17 * 0.125);
}

// A block of which a corner is removed, between voxels: two convex edges, and a concave one, rounded or not.
class NotchedBlock : public Meshes {
 protected:
  static constexpr double kWall = 20.3, kFloor = 14.4, kTop = 24.2;  // voxels: removed is x > kWall, z > kFloor

  /// Its mesh, in voxels. `radius`: of the fillet between wall and floor.
  TriangleMesh mesh(double radius, bool whole_voxels = false) {
    VoxelGrid grid;
    grid.voxel_mm = 0.5;
    grid.dims = Vec3i(40, 36, 30);
    FilledVoxmap voxmap(grid);
    const auto part = [](double from, double to, int voxel) {
      return std::clamp(to, double(voxel), voxel + 1.0) - std::clamp(from, double(voxel), voxel + 1.0);
    };
    const auto set_fill = [&](bool reamed) {
      for (int i = 0; i < grid.dims.prod(); ++i) {
        const Vec3i voxel(i % 40, i / 40 % 36, i / (40 * 36));
        const double along_y = part(5, 31, voxel.y());
        const double whole = part(5, 35, voxel.x()) * part(5, kTop, voxel.z());
        const double lost = part(kWall, 35, voxel.x()) * part(kFloor, kTop, voxel.z()) - fillet(voxel, radius);
        voxmap.grade.set(voxel, whole * along_y > 0 ? 200 : 0);
        const double fill = along_y * (whole - (reamed ? lost : 0));
        voxmap.fill.set(voxel, static_cast<std::uint16_t>(std::lround(fill * FillBricks::kWhole)));
      }
    };
    set_fill(false);
    const FillBricks before = voxmap.fill;
    set_fill(true);
    write_bone_vdb(dir_.path() + "/reamed.vdb", voxmap, {}, {});
    const UnreamedSurface unreamed(voxmap, before, voxmap.fill);
    const BoneView bone(voxmap, voxmap.fill);
    TriangleMesh out = make_reamed_mesh(dir_.path() + "/reamed.vdb", bone, unreamed, whole_voxels).mesh;
    EXPECT_TRUE(diagnose(out).closed_manifold());
    for (Vec3& p : out.vertices) p = (p - grid.origin_mm) / grid.voxel_mm;
    return out;
  }
  /// The part of a voxel in the fillet, by 32² samples.
  static double fillet(const Vec3i& voxel, double radius) {
    int inside = 0;
    for (int i = 0; i < 32 * 32; ++i) {
      const double x = voxel.x() + (i % 32 + 0.5) / 32 - kWall, z = voxel.z() + (i / 32 + 0.5) / 32 - kFloor;
      const bool near = x > 0 && z > 0 && x < radius && z < radius;
      inside += near && std::hypot(radius - x, radius - z) > radius ? 1 : 0;
    }
    return inside / (32.0 * 32);
  }
  /// Whether a vertex is within two voxels of the notch's faces, away from its ends.
  static bool is_near(const Vec3& p) {
    return p.x() > kWall - 2 && p.x() < 30 && p.y() > 10 && p.y() < 26 && p.z() > kFloor - 2;
  }
};

TEST_F(NotchedBlock, HasSharpEdges) {
  int at_concave = 0, at_convex = 0;
  for (const Vec3& p : mesh(0).vertices) {
    if (!is_near(p)) continue;
    const double from_wall = p.z() > kFloor ? std::abs(p.x() - kWall) : 1e9;
    const double from_floor = p.x() > kWall - 0.1 ? std::abs(p.z() - kFloor) : 1e9;
    const double from_top = p.x() < kWall + 0.1 ? std::abs(p.z() - kTop) : 1e9;
    EXPECT_LT(std::min({from_wall, from_floor, from_top}), 0.01) << p.transpose();
    at_concave += std::hypot(p.x() - kWall, p.z() - kFloor) < 0.01 ? 1 : 0;
    at_convex += std::hypot(p.x() - kWall, p.z() - kTop) < 0.01 ? 1 : 0;
  }
  EXPECT_GT(at_concave, 10);
  EXPECT_GT(at_convex, 10);
}

TEST_F(NotchedBlock, KeepsAFillet) {
  for (const double radius : {2.0, 3.0, 6.0}) {
    const auto largest_error = [&](bool whole_voxels) {
      double largest = 0;
      for (const Vec3& p : mesh(radius, whole_voxels).vertices) {
        const double x = p.x() - kWall - radius, z = p.z() - kFloor - radius;
        if (is_near(p) && x < 0 && z < 0) largest = std::max(largest, std::abs(std::hypot(x, z) - radius));
      }
      return largest;
    };
    const double smooth = largest_error(true), sharp = largest_error(false);
    EXPECT_LT(sharp, smooth + 0.02) << radius;  // the level at which the mesh encloses the volume differs
    EXPECT_LT(smooth, 0.4) << radius;
  }
}

TEST_F(NotchedBlock, StaysSmoothWhereVoxelsWereRemovedWhole) {
  double nearest = 1e9;
  for (const Vec3& p : mesh(0, true).vertices) {
    if (is_near(p)) nearest = std::min(nearest, std::hypot(p.x() - kWall, p.z() - kTop));
  }
  EXPECT_GT(nearest, 0.1);
}

TEST_F(Meshes, WithoutBoneLeftThereAreNoneAndTheReportSaysSo) {
  mesh_results({.voxel_mm = 0.8, .frames = 10, .every = 5});
  FilledVoxmap voxmap = read_stored_bone(dir_.path() + "/reamed.vdb").voxmap;
  voxmap.grade.for_each_brick(
      [&](const Vec3i& coord, const GradeBricks::Brick&) { voxmap.fill.put(coord, FillBricks::Brick{}); });
  write_bone_vdb(dir_.path() + "/reamed.vdb", voxmap, {}, {});
  write_meshes(dir_.path(), 0, report_);
  EXPECT_FALSE(fs::exists(glb()));
  EXPECT_FALSE(fs::exists(stl()));
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_THAT(report_.warnings[0], ::testing::HasSubstr("no bone remains"));
}

TEST_F(Meshes, DamagedResultsAndFullDisksAreNamed) {
  EXPECT_THROW(write_meshes(dir_.path(), 0, report_), InputError);
  write_results(dir_.path(), {.voxel_mm = 0.8, .frames = 10, .every = 5});
  fs::create_directory(glb());
  EXPECT_THROW(write_meshes(dir_.path(), 0, report_), RunError);
}

}  // namespace
}  // namespace reamsim
