// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The shipped reamers: made again they are the committed bytes; they are closed and have the sizes of assets/README.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "sim/mesh/mesh_check.h"
#include "sim/tool/profile.h"
#include "tests/support/temp_dir.h"
#include "tests/tool/reamer_files.h"

namespace reamsim::test {
namespace {

/// STL coordinates are 32-bit: below 32 mm they are exact to 1 µm.
constexpr double kStlMm = 1e-6 + 1e-6;

struct Expected {
  std::string name;
  double radius_mm;
  double height_mm;
};

class Reamer : public testing::TestWithParam<Expected> {
 protected:
  TriangleMesh mesh_ = reamer(GetParam().name);
};

INSTANTIATE_TEST_SUITE_P(Assets, Reamer,
                         testing::Values(Expected{"convex", 15, 30}, Expected{"convex_edges", 15, 30},
                                         Expected{"flat", 13.5, 27}, Expected{"hemispherical", 14, 34}),
                         [](const auto& expected) { return expected.param.name; });

TEST_P(Reamer, IsClosedAndFacesOutwards) {
  const MeshDiagnosis diagnosis = diagnose(mesh_);
  EXPECT_TRUE(diagnosis.closed_manifold()) << diagnosis.text();
  EXPECT_EQ(diagnosis.degenerate_triangles, 0u);
  EXPECT_EQ(diagnosis.components, 1u);
  EXPECT_GT(diagnosis.volume_mm3, 0);
}

TEST_P(Reamer, HasTheDocumentedSize) {
  double radius = 0, lowest = 1e9, highest = -1e9;
  for (const Vec3& p : mesh_.vertices) {
    radius = std::max(radius, radius_of(p));
    lowest = std::min(lowest, p.z());
    highest = std::max(highest, p.z());
  }
  EXPECT_NEAR(radius, GetParam().radius_mm, kStlMm);
  EXPECT_NEAR(highest, GetParam().height_mm, kStlMm);
  EXPECT_GE(lowest, 0);
  EXPECT_LT(lowest, 0.06) << "the cutting surface begins where the cannula ends";
}

TEST_P(Reamer, IsBoredThroughForTheGuidePin) {
  double narrowest = 1e9, bore_bottom = 1e9, bore_top = -1e9;
  for (const Vec3& p : mesh_.vertices) narrowest = std::min(narrowest, radius_of(p));
  EXPECT_NEAR(narrowest, 1.25, kStlMm);
  for (const Vec3& p : mesh_.vertices) {
    if (radius_of(p) > 1.25 + kStlMm) continue;
    bore_bottom = std::min(bore_bottom, p.z());
    bore_top = std::max(bore_top, p.z());
  }
  EXPECT_LT(bore_bottom, 0.06);
  EXPECT_NEAR(bore_top, GetParam().height_mm, kStlMm);
}

TEST_P(Reamer, StaysWellBelowAMegabyte) {
  EXPECT_LT(std::filesystem::file_size(reamer_path(GetParam().name)), 850'000u);
}

/// Vertices of the cutting face: those below `top`, off the bore's wall or on its lower edge.
std::vector<Vec3> face_points(const TriangleMesh& mesh, double top_mm) {
  std::vector<Vec3> points;
  for (const Vec3& p : mesh.vertices)
    if (p.z() <= top_mm) points.push_back(p);
  return points;
}

/// Sphere through `points` in the least-squares sense: |p|² = 2c·p + (R² − |c|²) is linear in c and the bracket.
std::pair<Vec3, double> fit_sphere(const std::vector<Vec3>& points) {
  Eigen::MatrixXd a(points.size(), 4);
  Eigen::VectorXd b(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    a.row(row) << 2 * points[i].transpose(), 1;
    b[row] = points[i].squaredNorm();
  }
  const Eigen::Vector4d x = a.colPivHouseholderQr().solve(b);
  return {x.head<3>(), std::sqrt(x[3] + x.head<3>().squaredNorm())};
}

TEST(ReamerFace, ConvexIsASphereOf29mm) {
  const auto [center, radius] = fit_sphere(face_points(reamer("convex"), 4.19));
  EXPECT_NEAR(radius, 29, 1e-4);
  EXPECT_NEAR((center - Vec3(0, 0, 29)).norm(), 0, 1e-4) << "the origin of T is the sphere's apex";
}

TEST(ReamerFace, HemisphereIsASphereOf14mm) {
  const auto [center, radius] = fit_sphere(face_points(reamer("hemispherical"), 14));
  EXPECT_NEAR(radius, 14, 1e-4);
  EXPECT_NEAR((center - Vec3(0, 0, 14)).norm(), 0, 1e-4);
}

TEST(ReamerFace, FacetsStayWithinFiveMicrometresOfTheSphere) {
  for (const auto& [name, radius, top] : {std::tuple{"convex", 29.0, 4.19}, std::tuple{"hemispherical", 14.0, 14.0}}) {
    const TriangleMesh mesh = reamer(name);
    double worst = 0;
    for (const auto& t : mesh.triangles) {
      Vec3 middle = Vec3::Zero();
      double highest = 0;
      for (const std::int32_t v : t) {
        middle += mesh.vertices[static_cast<std::size_t>(v)] / 3;
        highest = std::max(highest, mesh.vertices[static_cast<std::size_t>(v)].z());
      }
      if (highest > top || radius_of(middle) < 1.249) continue;
      worst = std::max(worst, std::abs((middle - Vec3(0, 0, radius)).norm() - radius));
    }
    EXPECT_LT(worst, 5e-3) << name;
    EXPECT_GT(worst, 1e-4) << name << ": no facet was looked at";
  }
}

TEST(ReamerFace, FlatIsAPlane) {
  for (const Vec3& p : face_points(reamer("flat"), 1.0)) EXPECT_EQ(p.z(), 0);
}

TEST(ReamerVolume, AgreesWithPappusLessTheFacets) {
  for (const auto& [name, segments] : {std::pair{"convex", 144}, {"flat", 144}, {"hemispherical", 160}}) {
    const TriangleMesh mesh = reamer(name);
    const auto profile = recover_generatrix(mesh);
    ASSERT_TRUE(profile) << name;
    // A ring of n facets encloses sin(2π/n)/(2π/n) of its circle, whatever the profile.
    const double angle = 2 * std::numbers::pi / segments;
    EXPECT_NEAR(mesh.volume_mm3() / (profile->volume_mm3() * std::sin(angle) / angle), 1, 1e-6) << name;
  }
}

TEST(ReamerLips, HaveSixLipsAndLessVolumeThanTheConvexOne) {
  const TriangleMesh toothed = reamer("convex_edges");
  EXPECT_LT(toothed.volume_mm3(), 0.9 * reamer("convex").volume_mm3());
  // Genus from Euler's number: the bore and six chip slots.
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  std::set<std::int32_t> used;
  for (const auto& t : toothed.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
      used.insert(t[k]);
    }
  const auto euler =
      static_cast<long>(used.size()) - static_cast<long>(edges.size()) + static_cast<long>(toothed.triangles.size());
  EXPECT_EQ((2 - euler) / 2, 7);
}

TEST(Drill, IsTheEnvelopeOfItsDocumentedSize) {
  const TriangleMesh mesh = read_mesh(REAMSIM_ASSETS "/drill_3_2mm.stl", 1);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
  const double point = 1.6 / std::tan(59 * std::numbers::pi / 180);
  EXPECT_NEAR(mesh.volume_mm3(), std::numbers::pi * 1.6 * 1.6 * (20 - point + point / 3), 0.1) << "faceted";
}

TEST(ReamerGenerator, MakesTheCommittedBytes) {
  const TempDir dir;
  const std::string command = std::string("\"") + REAMSIM_GENERATE_REAMERS + "\" \"" + dir.path() + "\"";
  ASSERT_EQ(std::system(command.c_str()), 0);
  for (const std::string name :
       {"reamer_convex", "reamer_convex_edges", "reamer_flat", "reamer_hemispherical", "drill_3_2mm"}) {
    const std::string made = file_bytes(dir.path() + "/" + name + ".stl");
    EXPECT_FALSE(made.empty()) << name;
    EXPECT_TRUE(made == file_bytes(REAMSIM_ASSETS "/" + name + ".stl"))
        << name << ": run generate_reamers on assets/ and commit";
  }
}

}  // namespace
}  // namespace reamsim::test
