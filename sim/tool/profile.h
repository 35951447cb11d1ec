// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

inline constexpr double kOnAxisMm = 1e-6;  ///< a point with a smaller radius counts as on the spin axis, mm
/// At a smaller distance the normal is the edge's instead of the direction to the surface, mm.
inline constexpr double kOnSurfaceMm = 1e-9;

/// (r, z) of a point of T.
inline Vec2 rz_of(const Vec3& point) {
  return {point.head<2>().norm(), point.z()};
}

/// The tool's envelope of revolution: a closed polygon in (r, z) of the tool frame T, r ≥ 0, mm, counter-clockwise (r
/// right, z up), with the inside on the left. Edges on the axis r = 0 are not surface.
struct Profile {
  std::vector<Vec2> points;

  [[nodiscard]] static bool on_axis(const Vec2& rz) { return rz.x() < kOnAxisMm; }
  /// Largest r, mm.
  [[nodiscard]] double max_radius_mm() const;
  /// The box of the solid of revolution, T, mm.
  [[nodiscard]] Aabb bounds() const;
  /// Signed distance to the surface (negative inside), and outward unit normal (n_r, n_z) at the nearest point, from
  /// all edges. The reference for the device code.
  struct Nearest {
    double distance_mm;
    Vec2 normal;
  };
  [[nodiscard]] Nearest nearest(const Vec2& rz) const;
  /// The normal at a point of T, from that in its half plane; on the axis without its radial part.
  [[nodiscard]] static Vec3 normal_at(const Vec3& point, const Nearest& nearest) {
    const double r = point.head<2>().norm();
    const Vec3 outward = r > kOnAxisMm ? Vec3(point.x() / r, point.y() / r, 0) : Vec3::Zero();
    return nearest.normal.x() * outward + nearest.normal.y() * Vec3::UnitZ();
  }
  /// Volume of the solid of revolution, mm³ (Pappus).
  [[nodiscard]] double volume_mm3() const;
};

/// Revolves a profile about z to a closed mesh (mm, frame T) with `segments` vertices per ring, the first at angle 0.
/// Vertices lie on the surface of revolution; a profile point on the axis becomes one vertex.
TriangleMesh revolve(const Profile& profile, int segments);

/// Vertices per ring for a sagitta of at most `sagitta_mm` at `radius_mm`; at least 32, a multiple of 4.
int segments_for_sagitta(double radius_mm, double sagitta_mm);

/// Step of the lattice that samples the outline of a tool that is no surface of revolution, mm.
inline constexpr double kOutlineStepMm = 0.02;

/// The envelope of revolution about z of a closed mesh that faces outwards (mm, frame T).
struct Envelope {
  Profile profile;
  bool revolved = false;  ///< the mesh is a surface of revolution, and the profile its generating polygon
};

/// recover_generatrix(), or sweep_outline() for other meshes. Throws InputError when the envelope has no volume.
Envelope envelope_of_revolution(const TriangleMesh& mesh);

/// The generating polygon of a surface of revolution, or nullopt for other meshes: every triangle spans at most two
/// rings of vertices about z, facets lie within 0.02 mm of the circle of their ring, and the rings form one simple
/// closed polygon, or one that begins and ends on the axis. `mesh`: as above.
std::optional<Profile> recover_generatrix(const TriangleMesh& mesh);

/// The outline in (r, z) of the volume that a closed mesh sweeps when it rotates about z. Sampled on a lattice of
/// `step_mm`, which grows to limit the lattice to 4096² points. Crossings between lattice points have an error below
/// 0.1 µm; corners are restored; points within step/5 of a straight line are dropped. Features thinner than a step may
/// be missed. Closed cavities off the axis are filled. `mesh`: as above. Throws InputError for several swept parts.
Profile sweep_outline(const TriangleMesh& mesh, double step_mm);

/// A line or an arc of at most 100° in (r, z) of the tool frame T, mm, the inside on its left.
struct OutlineArc {
  Vec2 begin, end;
  Vec2 along_begin, along_end;  ///< unit tangents
  Vec2 middle;                  ///< point at half length
  Vec2 normal;                  ///< outward unit normal there
  double curvature = 0;         ///< 1/mm, positive where it bulges outwards; 0 for a line

  [[nodiscard]] double length() const;
  /// Distance of a point from it, mm.
  [[nodiscard]] double distance(const Vec2& rz) const;
};

/// Lines and arcs through the vertices of a tool's profile.
struct Outline {
  std::vector<OutlineArc> arcs;  ///< in order, without edges on the spin axis
  double bulge_mm = 0;           ///< largest distance of an arc from the profile's edges
};

/// An outline has a sharp corner where its direction changes by more, rad.
inline constexpr double kSharpTurn = 0.2;
inline constexpr double kOnArcMm = 5e-4;  ///< tolerance of vertices on a circle, mm

/// The angle from direction `a` to `b`, rad; positive to the left.
double angle_between(const Vec2& a, const Vec2& b);

/// Fits arcs to four or more vertices within kOnArcMm of a circle and without sharp corners; other edges are lines.
Outline fit_outline(const Profile& profile);

/// Area of a closed polygon, mm²; positive if counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

/// Simplifies a closed polygon: dropped points lie within `tolerance_mm` of the result (Douglas and Peucker 1973). It
/// begins at the lowest point, the innermost of several.
std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm);

/// Restores corners of a traced outline: replaces an edge that cuts off a corner (no longer than a lattice cell's
/// diagonal, between edges of at least three steps) by the corner. Corners move by less than `step_mm`.
std::vector<Vec2> sharpen_corners(const std::vector<Vec2>& polygon, double step_mm);

}  // namespace reamsim
