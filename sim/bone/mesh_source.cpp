// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_source.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/winding.h"
#include "sim/scenario/key_tree.h"

namespace reamsim {

namespace {

/// Of the header; nullopt: another one.
std::optional<MeshFrame> stated_frame(const std::string& space) {
  if (space.empty()) return MeshFrame::file;
  if (space == "LPS" || space == "LEFT-POSTERIOR-SUPERIOR") return MeshFrame::lps;
  if (space == "RAS" || space == "RIGHT-ANTERIOR-SUPERIOR") return MeshFrame::ras;
  return std::nullopt;
}

/// A half turn about z: what RAS is to LPS.
Aabb half_turned(const Aabb& box) {
  return {Vec3(-box.max.x(), -box.max.y(), box.min.z()), Vec3(-box.min.x(), -box.min.y(), box.max.z())};
}

bool meet(const Aabb& a, const Aabb& b) {
  return (a.min.array() <= b.max.array()).all() && (b.min.array() <= a.max.array()).all();
}

struct LengthRange {
  double least_mm;
  double most_mm;

  [[nodiscard]] bool contains(double mm) const { return mm >= least_mm && mm <= most_mm; }
};

constexpr LengthRange kBoneWithGlenoid{20, 400};  // from an isolated glenoid to a long bone with a glenoid
constexpr LengthRange kAnySolid{10, 400};         // without a glenoid frame; beyond this the unit is probably wrong
/// Superior to inferior, of an adult; for the estimate of a scale if no unit fits.
constexpr double kScapula_mm = 150;
constexpr LengthRange kScapulas{100, 220};

double length_of(const Aabb& bounds) {
  return (bounds.max - bounds.min).maxCoeff();
}

struct UnitOfLength {
  const char* name;
  double mm;
};
constexpr std::array kUnits{UnitOfLength{"metres", 1000}, UnitOfLength{"centimetres", 10}, UnitOfLength{"inches", 25.4},
                            UnitOfLength{"micrometres", 0.001}};

/// The units for which the length lies in the range, sorted by the similarity to a scapula.
std::vector<UnitOfLength> units_that_fit(double file_length, const LengthRange& range) {
  std::vector<UnitOfLength> out;
  std::ranges::copy_if(kUnits, std::back_inserter(out),
                       [&](const UnitOfLength& unit) { return range.contains(unit.mm * file_length); });
  const auto distance = [&](const UnitOfLength& unit) {
    return std::abs(std::log(unit.mm * file_length / kScapula_mm));
  };
  std::ranges::sort(out, {}, distance);
  return out;
}

/// The scales that would fit, the most likely first: that of a unit, or else the estimate from a scapula.
std::string scale_advice(double file_length, const std::string& what_to_set) {
  std::vector<std::string> scales;
  const std::vector<UnitOfLength> units = units_that_fit(file_length, kBoneWithGlenoid);
  for (const UnitOfLength& unit : units) {
    scales.push_back(fmt::format("{:g} if the file is in {} ({:.0f} mm)", unit.mm, unit.name, unit.mm * file_length));
  }
  const std::string estimate =
      fmt::format("about {:.2g} for a scapula of {:.0f} mm", kScapula_mm / file_length, kScapula_mm);
  const bool unit_is_likely = !units.empty() && kScapulas.contains(units.front().mm * file_length);
  scales.insert(unit_is_likely ? scales.end() : scales.begin(), estimate);
  return what_to_set + ": " + join_or({scales.begin(), scales.end()});
}

void require_length(const std::string& path, double length_mm, double scale, const std::string& what_to_set) {
  if (kBoneWithGlenoid.contains(length_mm)) return;
  throw InputError(
      {path, 0, 0}, "bone.mesh.scale",
      fmt::format("the mesh is {:.3g} mm long, expected {:.0f} to {:.0f} mm for a bone with a glenoid frame", length_mm,
                  kBoneWithGlenoid.least_mm, kBoneWithGlenoid.most_mm),
      scale_advice(length_mm / scale, what_to_set));
}

/// Throws InputError if the longest side of a bone with a glenoid frame is not 20 to 400 mm: the mesh has another unit.
/// Without a frame any solid may be reamed, and a size beyond 10 to 400 mm is a warning.
void check_mesh_unit(const std::string& path, const Aabb& bounds_mm, double scale, bool has_glenoid,
                     Diagnostics& report) {
  constexpr const char* kSetScale = "set bone.mesh.scale";
  const double length_mm = length_of(bounds_mm);
  if (has_glenoid) return require_length(path, length_mm, scale, kSetScale);
  if (kAnySolid.contains(length_mm)) return;
  report.warn(fmt::format("{}: the mesh is {:.3g} mm long; if that is wrong, {}", path, length_mm,
                          scale_advice(length_mm / scale, kSetScale)));
}

/// Warns where the points of the scenario lie outside the mesh, and would lie in its box after a half turn.
void warn_of_half_turn(const GlenoidSettings& glenoid, const Aabb& mesh_mm, Diagnostics& report) {
  std::vector<Vec3> points_mm = glenoid.rim_mm;
  for (const auto& point : {glenoid.near_mm, glenoid.center_mm}) {
    if (point) points_mm.push_back(*point);
  }
  if (const auto& marks = glenoid.landmarks) {
    points_mm.insert(points_mm.end(), {marks->glenoid_center_mm, marks->trigonum_spinae_mm, marks->inferior_angle_mm});
  }
  constexpr double kRoom_mm = 10;  // a point on the face need not lie in the bone
  const Aabb here = mesh_mm.expanded(kRoom_mm), turned = half_turned(here);
  const bool any_here = std::ranges::any_of(points_mm, [&](const Vec3& p) { return meet(here, {p, p}); });
  const bool all_turned = std::ranges::all_of(points_mm, [&](const Vec3& p) { return meet(turned, {p, p}); });
  if (points_mm.empty() || any_here || !all_turned) return;
  report.warn(
      "the points of bone.glenoid lie outside the mesh, and would lie in its box after a half turn about z: either "
      "they or the mesh are in RAS; set bone.mesh.frame, or change the sign of x and y of the points");
}

/// Drops doubled triangles, turns the others alike, closes the holes, and reports it. Returns the number of triangles
/// before the holes were closed, which are the first ones. Throws InputError where it cannot or must not.
std::size_t close_surface(const MeshBoneSettings& settings, const MeshDiagnosis& found, TriangleMesh& mesh,
                          Diagnostics& report) {
  if (found.inconsistent_edges > 0 && !settings.repair) {
    refuse_file(settings.path, "the triangles have no consistent orientation: " + found.text(),
                "set bone.mesh.repair: true, which turns them, or export the mesh with consistent normals");
  }
  RepairResult done = clean(mesh);
  if (const std::size_t opposite = diagnose(mesh).inconsistent_edges; opposite > 0) {
    refuse_file(settings.path, "the triangles cannot be turned alike",
                fmt::format("orient them alike; edges between triangles of opposite orientation: {}", opposite));
  }
  const std::vector<MeshHole> holes = holes_of(mesh);
  const double area_mm2 = mesh.area_mm2();
  const bool small = are_small(holes, area_mm2) && kAnySolid.contains(length_of(mesh.bounds()));
  if (!settings.repair && !holes.empty() && !small) {
    refuse_file(
        settings.path,
        "not a closed surface: " + found.text() + "; " + text_of(holes, area_mm2) +
            fmt::format(", where {:g} mm and {:g} % are read as they are", kSmallHoleWidth_mm, 100 * kSmallHoles),
        "give a closed, two-manifold mesh: repair it, or set bone.mesh.repair: true");
  }
  const std::size_t before = mesh.triangles.size();
  close_holes(mesh, holes, done);
  report.warn((settings.repair ? "mesh repaired: " : "the mesh is not clean: ") + done.text());
  report.note("quality of the mesh: " + text_of(holes, area_mm2) + ", " + std::to_string(found.nonmanifold_edges) +
              " non-manifold edges; what is inside is decided by winding numbers");
  return before;
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

void make_solid(const MeshBoneSettings& settings, BoneMesh& bone, Diagnostics& report) {
  const MeshDiagnosis found = diagnose(bone.mesh);
  bone.was_clean = found.closed_manifold();
  std::size_t triangles_before = bone.mesh.triangles.size();
  const std::string state = "mesh: " + std::to_string(bone.mesh.triangles.size()) + " triangles, " + found.text();
  if (!bone.was_clean) triangles_before = close_surface(settings, found, bone.mesh, report);
  report.note(state);
  std::vector<MeshPiece> pieces = turn_outwards(bone.mesh, !bone.was_clean);
  bone.outer_mm3 = outer_volume_mm3(pieces);
  bone.nested = std::ranges::any_of(pieces, &MeshPiece::inside_another);
  if (bone.outer_mm3 <= 1e-9 * bone.mesh.bounds().half().prod() * 8) {
    refuse_file(settings.path, "the mesh encloses no volume", "give the surface of a solid");
  }
  if (settings.repair && !bone.was_clean) check_change(settings, bone.mesh, triangles_before, report);
  constexpr double kNone = 1e-9;  // of the largest; pieces without volume, as closed flaps are, are not named
  const double largest = pieces.empty() ? 0 : pieces.front().volume_mm3;
  std::erase_if(pieces, [&](const MeshPiece& piece) { return piece.volume_mm3 <= kNone * largest; });
  for (const std::string& warning : warnings_of(pieces)) report.warn(warning);
}

}  // namespace

void bring_into_lps(MeshContents& contents, MeshFrame asked, const std::string& path, const std::string& key,
                    Diagnostics& report) {
  const auto stated = stated_frame(contents.space);
  if (asked == MeshFrame::file && !stated) {
    throw InputError({path, 0, 0}, key, "the header of the mesh says SPACE=" + contents.space,
                     key.empty() ? "expected LPS or RAS" : "expected LPS or RAS: set lps or ras");
  }
  const MeshFrame frame = asked == MeshFrame::file ? *stated : asked;
  if (frame == MeshFrame::file) {
    return report.note("frame of the mesh: its header states none; the coordinates are taken as they stand, as LPS" +
                       (key.empty() ? "" : " (if they are RAS, set " + key + ": ras)"));
  }
  if (asked != MeshFrame::file && !contents.space.empty() && stated != asked) {
    report.warn(key + " is " + name_of(asked) + ", but the header of the mesh says SPACE=" + contents.space +
                "; the key counts");
  }
  const bool ras = frame == MeshFrame::ras;
  const std::string reason =
      asked != MeshFrame::file ? "by " + key : "as its header says (SPACE=" + contents.space + ")";
  report.note(std::string("frame of the mesh: ") + (ras ? "RAS, " : "LPS, ") + reason +
              (ras ? "; x and y were negated, because the bone frame is LPS" : ""));
  if (!ras) return;
  for (Vec3& vertex : contents.mesh.vertices) vertex.head<2>() *= -1;
}

bool meet_after_half_turn_only(const Aabb& a, const Aabb& b) {
  return !meet(a, b) && meet(half_turned(a), b);
}

FoundScale find_scale_of(const std::string& path, const std::string& what_to_set) {
  const double length = length_of(read_mesh(path, 1).bounds());
  if (kBoneWithGlenoid.contains(length)) {
    return {.scale = 1, .unit = "mm", .length_mm = length, .assumed = !kScapulas.contains(length)};
  }
  const std::vector<UnitOfLength> units = units_that_fit(length, kScapulas);
  if (units.size() == 1) return {.scale = units[0].mm, .unit = units[0].name, .length_mm = units[0].mm * length};
  throw InputError({path, 0, 0}, "bone.mesh.scale",
                   fmt::format("the mesh is {:.3g} long, in a unit that is unknown", length),
                   scale_advice(length, what_to_set));
}

void require_scale(const std::string& path, double scale, const std::string& what_to_set) {
  require_length(path, length_of(read_mesh(path, scale).bounds()), scale, what_to_set);
}

BoneMesh read_bone_mesh(const BoneSettings& settings, Diagnostics& report) {
  const MeshBoneSettings& source = settings.mesh;
  MeshContents contents = read_mesh_contents(source.path, source.scale, "bone.mesh.path");
  report.append(contents.report, "bone.mesh.path: ");
  bring_into_lps(contents, source.frame, source.path, "bone.mesh.frame", report);
  BoneMesh out{.mesh = std::move(contents.mesh)};
  const Aabb box = out.mesh.bounds();
  warn_of_half_turn(settings.glenoid, box, report);
  const bool has_glenoid = settings.glenoid.center_mm || settings.glenoid.landmarks || settings.glenoid.near_mm;
  MistakeList mistakes;  // the unit first: the size of holes depends on it
  mistakes.attempt([&] { check_mesh_unit(source.path, box, source.scale, has_glenoid, report); });
  mistakes.attempt([&] { make_solid(source, out, report); });
  mistakes.throw_if_any();
  return out;
}

}  // namespace reamsim
