// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_source.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "sim/bone/mesh_frame.h"
#include "sim/bone/mesh_unit.h"
#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_holes.h"
#include "sim/mesh/mesh_io.h"
#include "sim/mesh/mesh_repair.h"
#include "sim/mesh/winding.h"

namespace reamsim {

namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& found, const std::string& expected) {
  throw InputError({path, 0, 0}, "", found, expected);
}

std::string edges_text(std::size_t count) {
  return count == 1 ? "1 edge lies" : fmt::format("{} edges lie", count);
}

/// The points of the scenario that lie on the bone.
std::vector<Vec3> points_of(const GlenoidSettings& glenoid) {
  std::vector<Vec3> out = glenoid.rim_mm;
  for (const auto& point : {glenoid.near_mm, glenoid.center_mm}) {
    if (point) out.push_back(*point);
  }
  if (const auto& marks = glenoid.landmarks) {
    out.insert(out.end(), {marks->glenoid_center_mm, marks->trigonum_spinae_mm, marks->inferior_angle_mm});
  }
  return out;
}

/// A surface before its holes are closed.
struct OpenSurface {
  TriangleMesh mesh;
  MeshDiagnosis found;  ///< as it was read
  RepairResult done;
  std::vector<MeshHole> holes;
  double area = 0;  ///< mm²
};

/// Drops doubled triangles and turns the others alike. Throws InputError where they cannot be, or must not.
OpenSurface cleaned(const MeshBoneSettings& settings, TriangleMesh mesh, const MeshDiagnosis& found) {
  if (found.inconsistent_edges > 0 && !settings.repair) {
    refuse(settings.path, "the triangles have no consistent orientation: " + found.text(),
           "set bone.mesh.repair: true, which turns them, or export the mesh with consistent normals");
  }
  OpenSurface out{std::move(mesh), found, {}, {}, 0};
  out.done = clean(out.mesh);
  const std::size_t opposite = diagnose(out.mesh).inconsistent_edges;
  if (opposite > 0) {
    refuse(settings.path, "the triangles cannot be turned alike",
           "orient the triangles of the mesh alike: " + edges_text(opposite) +
               " between triangles with opposite orientation");
  }
  out.holes = holes_of(out.mesh);
  out.area = area_mm2(out.mesh);
  return out;
}

void require_small_holes(const MeshBoneSettings& settings, const OpenSurface& surface) {
  if (surface.holes.empty()) return;
  if (are_small(surface.holes, surface.area) && is_likely_length(surface.mesh.bounds())) return;
  refuse(settings.path,
         "not a closed surface: " + surface.found.text() + "; " + text_of(surface.holes, surface.area) +
             fmt::format(", where {:g} mm and {:g} % are read as they are", HoleLimits::kMostWidth_mm,
                         100 * HoleLimits::kMostOfArea),
         "give a closed, two-manifold mesh: repair it, or set bone.mesh.repair: true");
}

/// Refuses a repair that changes the volume by more than the scenario allows. `triangles_before`: those of the mesh
/// before its holes were closed, which are the first ones.
void check_change(const MeshBoneSettings& settings, const TriangleMesh& closed, std::size_t triangles_before,
                  Diagnostics& report) {
  TriangleMesh open = closed;
  open.triangles.resize(triangles_before);
  const VolumeChange change = compare_volumes(open, closed);
  const double percent = change.before_mm3 > 0 ? 100 * change.differs_mm3 / change.before_mm3 : 100;
  const std::string volumes = fmt::format("{:.0f} mm3 before and {:.0f} mm3 after, {:.2g} % of it elsewhere",
                                          change.before_mm3, change.after_mm3, percent);
  if (percent > settings.repair_change_percent) {
    throw InputError(
        {settings.path, 0, 0}, "bone.mesh.repair",
        fmt::format("closing the holes would change the volume by more than {:g} %: {}", settings.repair_change_percent,
                    volumes),
        fmt::format("close the holes in a program for meshes, or accept it: bone.mesh.repair_change_percent: "
                    "{:.0f}",
                    std::ceil(percent + 0.5)));
  }
  report.warn("volume of the mesh by winding numbers: " + volumes);
}

/// Closes the holes, and says what was found and done.
void close_surface(const MeshBoneSettings& settings, OpenSurface& surface, Diagnostics& report) {
  if (!settings.repair) require_small_holes(settings, surface);
  const std::size_t before = surface.mesh.triangles.size();
  close_holes(surface.mesh, surface.holes);
  surface.done.closed_holes = surface.holes.size();
  surface.done.added_triangles = surface.mesh.triangles.size() - before;
  for (const MeshHole& hole : surface.holes) {
    surface.done.widest_hole_mm = std::max(surface.done.widest_hole_mm, hole.length_mm);
  }
  report.warn((settings.repair ? "mesh repaired: " : "the mesh is not clean: ") + surface.done.text());
  report.note("quality of the mesh: " + text_of(surface.holes, surface.area) + ", " +
              std::to_string(surface.found.nonmanifold_edges) +
              " non-manifold edges; what is inside is decided by winding numbers");
}

/// Throws InputError for a surface without volume.
void require_volume(const std::string& path, const BoneMesh& bone) {
  const double box_mm3 = bone.mesh.bounds().half().prod() * 8;
  if (bone.outer_mm3 <= 1e-9 * box_mm3) refuse(path, "the mesh encloses no volume", "give the surface of a solid");
}

/// Pieces without volume, as closed flaps are, are not named.
void warn_of_pieces(std::vector<MeshPiece> pieces, Diagnostics& report) {
  constexpr double kNone = 1e-9;  // of the largest
  const double largest = pieces.empty() ? 0 : pieces.front().volume_mm3;
  std::erase_if(pieces, [&](const MeshPiece& piece) { return piece.volume_mm3 <= kNone * largest; });
  for (const std::string& warning : warnings_of(pieces)) report.warn(warning);
}

void make_solid(const MeshBoneSettings& settings, BoneMesh& bone, Diagnostics& report) {
  const MeshDiagnosis found = diagnose(bone.mesh);
  bone.was_clean = found.closed_manifold();
  std::size_t triangles_before = bone.mesh.triangles.size();
  const std::string state = "mesh: " + std::to_string(bone.mesh.triangles.size()) + " triangles, " + found.text();
  if (!bone.was_clean) {
    OpenSurface surface = cleaned(settings, std::move(bone.mesh), found);
    triangles_before = surface.mesh.triangles.size();
    close_surface(settings, surface, report);
    bone.mesh = std::move(surface.mesh);
  }
  report.note(state);
  const std::vector<MeshPiece> pieces = turn_outwards(bone.mesh, !bone.was_clean);
  bone.outer_mm3 = outer_volume_mm3(pieces);
  require_volume(settings.path, bone);
  if (settings.repair && !bone.was_clean) check_change(settings, bone.mesh, triangles_before, report);
  warn_of_pieces(pieces, report);
}

}  // namespace

BoneMesh read_bone_mesh(const BoneSettings& settings, Diagnostics& report) {
  const MeshBoneSettings& source = settings.mesh;
  require_mesh(source.path, "bone.mesh.path");
  MeshContents contents = read_mesh_contents(source.path, source.scale);
  for (const std::string& warning : contents.warnings) report.warn("bone.mesh.path: " + warning);
  for (const std::string& note : contents.notes) report.note("bone.mesh.path: " + note);
  bring_into_lps(contents, source.frame, source.path, "bone.mesh.frame", report);
  BoneMesh out{.mesh = std::move(contents.mesh)};
  const Aabb box = out.mesh.bounds();
  const std::vector<Vec3> points = points_of(settings.glenoid);
  warn_of_half_turn(points, "bone.glenoid", box, report);
  const bool has_glenoid = settings.glenoid.center_mm || settings.glenoid.landmarks || settings.glenoid.near_mm;
  MistakeList mistakes;  // the unit first: the size of holes depends on it
  mistakes.attempt([&] { check_mesh_unit(source.path, box, source.scale, has_glenoid, report); });
  mistakes.attempt([&] { make_solid(source, out, report); });
  mistakes.throw_if_any();
  return out;
}

}  // namespace reamsim
