// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Removed volume and reamed surface against the boolean of meshes (CGAL), and OpenVDB's CSG of level sets beside them
// (docs/verification.md).
#include <fmt/format.h>
#include <openvdb/tools/Composite.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "render/surface/scalar_grid.h"
#include "tests/cli/cli_fixture.h"
#include "tests/verify/mesh_boolean/exact_boolean.h"
#include "tests/verify/mesh_boolean/plunges.h"

namespace reamsim::test {
namespace {

constexpr double kPointsPerMm2 = 20;
constexpr double kOnTool_mm = 1e-6;  // rounding of the intersection points
constexpr double kSharp = 0.9;       // cosine of the angle between the normals at an edge
constexpr double kFromEdge_voxels = 2;

Vec3 normal_of(const TriangleMesh& mesh, const MeshTriangle& triangle) {
  const auto [a, b, c] = mesh.corners(triangle);
  return (b - a).cross(c - a).normalized();
}

/// Points of a surface, evenly by area: Roberts' sequence in each triangle.
std::vector<Vec3> points_on(const TriangleMesh& mesh) {
  std::vector<Vec3> out;
  double due = 0.5;
  for (const MeshTriangle& triangle : mesh.triangles) {
    const auto [a, b, c] = mesh.corners(triangle);
    for (due += kPointsPerMm2 * 0.5 * (b - a).cross(c - a).norm(); due >= 1; --due) {
      const auto n = static_cast<double>(out.size());
      double u = std::fmod(0.7548776662466927 * n, 1), v = std::fmod(0.5698402909980532 * n, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      out.push_back(a + u * (b - a) + v * (c - a));
    }
  }
  return out;
}

/// The triangles whose centre lies at most `near_mm` from another surface.
TriangleMesh part_near(const TriangleMesh& mesh, const TriangleMesh& other, double near_mm) {
  std::vector<Vec3> centers;
  for (const MeshTriangle& t : mesh.triangles)
    centers.push_back((mesh.vertex(t[0]) + mesh.vertex(t[1]) + mesh.vertex(t[2])) / 3);
  const std::vector<double> distances = distances_mm(centers, other);
  TriangleMesh out{mesh.vertices, {}};
  for (std::size_t i = 0; i < centers.size(); ++i)
    if (distances[i] <= near_mm) out.triangles.push_back(mesh.triangles[i]);
  return out;
}

using Segment = std::array<Vec3, 2>;

/// The sharp edges of a part, and its boundary.
std::vector<Segment> edges_of(const TriangleMesh& part) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Vec3>> normals;
  for (const MeshTriangle& t : part.triangles)
    for (std::size_t i = 0; i < 3; ++i) normals[std::minmax(t[i], t[(i + 1) % 3])].push_back(normal_of(part, t));
  std::vector<Segment> out;
  for (const auto& [edge, sides] : normals)
    if (sides.size() == 1 || sides[0].dot(sides[1]) < kSharp)
      out.push_back({part.vertex(edge.first), part.vertex(edge.second)});
  return out;
}

double distance_mm(const Vec3& p, const std::vector<Segment>& edges) {
  double least = 1e18;
  for (const auto& [a, b] : edges) {
    const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    least = std::min(least, (a + t * (b - a) - p).squaredNorm());
  }
  return std::sqrt(least);
}

/// The truth: exact but for the rounding of intersection points.
struct Exact {
  explicit Exact(const Plunge& plunge)
      : tool(swept(plunge)),
        bone(mesh_difference(plunge.bone, tool)),
        removed_mm3(plunge.bone.volume_mm3() - bone.volume_mm3()) {
    const TriangleMesh reamed = part_near(bone, tool, kOnTool_mm);
    points = points_on(reamed);
    const std::vector<Segment> edges = edges_of(reamed);
    for (const Vec3& p : points) edge_mm.push_back(distance_mm(p, edges));
  }
  TriangleMesh tool, bone;
  double removed_mm3;
  std::vector<Vec3> points;     ///< of the reamed surface
  std::vector<double> edge_mm;  ///< their distances from its edges
};

/// Errors of a volume, %, and of a surface at the points of the exact one, voxels.
struct Errors {
  double volume_percent = 0, mean = 0, p99 = 0, p99_off_edges = 0;
};

double percentile_99(std::vector<double> values) {
  std::ranges::sort(values);
  return values.at(values.size() * 99 / 100);
}

Errors errors_of(const Exact& exact, double removed_mm3, const TriangleMesh& surface, double voxel_mm) {
  std::vector<double> all = distances_mm(exact.points, surface), off_edges;
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] /= voxel_mm;
    if (exact.edge_mm[i] > kFromEdge_voxels * voxel_mm) off_edges.push_back(all[i]);
  }
  const double mean = std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
  return {100 * (removed_mm3 / exact.removed_mm3 - 1), mean, percentile_99(all), percentile_99(off_edges)};
}

/// What ball_into_box() removes: the cap of the ball below the box's top, without the core in the cannula.
double closed_form_mm3(const Plunge& plunge) {
  constexpr double kPi = std::numbers::pi;
  const double r = plunge.radius_mm, r0 = assets::kCannulaRadiusMm, top_mm = plunge.bone.bounds().max.z();
  const Vec3 axis = plunge.axis.normalized(), apex = plunge.entry_mm + plunge.depth_mm * axis;
  const double cap_mm = r - ((apex - r * axis).z() - top_mm);
  const double face_mm =
      r - 2.0 / 3 * (std::pow(r, 3) - std::pow(r * r - r0 * r0, 1.5)) / (r0 * r0);  // mean, above apex
  const double core_mm = (top_mm - apex.z()) / -axis.z() - face_mm;
  return kPi * cap_mm * cap_mm * (r - cap_mm / 3) - kPi * r0 * r0 * core_mm;
}

class MeshBoolean : public CliTest {
 protected:
  static double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }

  Errors errors_of_reamsim(const Plunge& plunge, const Exact& exact, double voxel_mm) {
    meshes_ = true;
    write_stl(path("bone.stl"), plunge.bone);
    expect_done(run(fmt::format("version: 2\n"
                                "bone: {{source: mesh, voxel_mm: {}, cache: false, mesh: {{path: bone.stl}}}}\n"
                                "tool: {{mesh: {}}}\n"
                                "motion:\n"
                                "  frame_rate_hz: 100\n"
                                "  plunge: {{entry_mm: [{}], axis: [{}], depth_mm: {}, feed_mm_s: 2, retract_mm: 0}}\n"
                                "render: {{enabled: false}}\n"
                                "output: {{vti: false}}\n",
                                voxel_mm, REAMSIM_ROOT "/assets/reamer_" + plunge.reamer + ".stl",
                                fmt::join(plunge.entry_mm, ", "), fmt::join(plunge.axis, ", "), plunge.depth_mm),
                    {"--overwrite"}));
    const double removed_mm3 = nlohmann::json::parse(read("out/summary.json"))["removed_mm3"];
    return errors_of(exact, removed_mm3, read_mesh(path("out/reamed.stl"), 1), voxel_mm);
  }

  /// OpenVDB's CSG on the lattice of the bone's corner.
  static Errors errors_of_csg(const Plunge& plunge, const Exact& exact, double voxel_mm) {
    const DistanceSampling sampling{.first_mm = plunge.bone.bounds().min, .spacing_mm = voxel_mm, .exact = true};
    const auto surface = [&](const openvdb::FloatGrid& grid) {
      const IsoSurface iso = extract_surface(grid, 0);
      TriangleMesh mesh;
      for (const Eigen::Vector3f& p : iso.points)
        mesh.vertices.push_back(sampling.first_mm + voxel_mm * p.cast<double>());
      for (std::size_t i = 0; i < iso.indices.size(); i += 3)
        mesh.triangles.push_back({static_cast<int>(iso.indices[i]), static_cast<int>(iso.indices[i + 2]),
                                  static_cast<int>(iso.indices[i + 1])});
      return mesh;
    };
    const auto bone = mesh_distance(plunge.bone, sampling), tool = mesh_distance(exact.tool, sampling);
    const double before_mm3 = surface(*bone).volume_mm3();
    openvdb::tools::csgDifference(*bone, *tool);
    const TriangleMesh left = surface(*bone);
    return errors_of(exact, before_mm3 - left.volume_mm3(), left, voxel_mm);
  }
};

TEST_F(MeshBoolean, RemovedVolumeAndReamedSurface) {
  const bool all = std::getenv("REAMSIM_LONG_TESTS") != nullptr;
  std::vector<Plunge> plunges{ball_into_box()};
  if (all) {
    plunges.push_back(flat_into_sphere());
    if (std::filesystem::exists(data_file(kScapula))) plunges.push_back(convex_into_scapula());
  }
  for (const Plunge& plunge : plunges) {
    double begin = seconds();
    const Exact exact(plunge);
    if (&plunge == plunges.data()) {
      EXPECT_NEAR(exact.removed_mm3 / closed_form_mm3(plunge), 1, 1e-5);
    }
    std::cout << fmt::format("{}: CGAL removes {:.3f} mm3, {} points, {:.1f} s\n", plunge.name, exact.removed_mm3,
                             exact.points.size(), seconds() - begin);
    for (const double voxel_mm : all ? std::vector<double>{0.25, 0.2, 0.125} : std::vector<double>{0.25}) {
      const auto show = [&](const char* program, const Errors& e) {
        std::cout << fmt::format("| {} | {} mm | {} | {:.4f} % | {:.3f} | {:.3f} | {:.3f} | {:.1f} s |\n", plunge.name,
                                 voxel_mm, program, e.volume_percent, e.mean, e.p99, e.p99_off_edges,
                                 seconds() - begin);
      };
      begin = seconds();
      const Errors found = errors_of_reamsim(plunge, exact, voxel_mm);
      show("reamsim", found);
      begin = seconds();
      if (all) show("OpenVDB", errors_of_csg(plunge, exact, voxel_mm));
      EXPECT_LT(std::abs(found.volume_percent), 0.005) << plunge.name;
      EXPECT_LT(found.p99_off_edges, 0.05) << plunge.name;
      EXPECT_LT(found.p99, 0.1) << plunge.name;
    }
  }
}

}  // namespace
}  // namespace reamsim::test
