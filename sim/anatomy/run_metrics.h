// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/face_surface.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/bone/bone.h"
#include "sim/mesh/winding.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The rim of an articular face, as a closed polygon in the plane through its points.
struct FaceOutline {
  Rigid bone_from_outline = Rigid::Identity();  ///< origin at the centroid of the polygon, +z out of the bone
  std::vector<Vec2> corners_mm;
  Aabb box_mm;  ///< of the points, in the frame of the outline

  /// `rim_mm`: points of B in order round the face. `outward`: out of the bone. nullopt for points on a line.
  static std::optional<FaceOutline> of(const std::vector<Vec3>& rim_mm, const Vec3& outward);

  /// Distance of a point of the plane from the polygon, mm; positive inside.
  [[nodiscard]] double inside_mm(const Vec2& place_mm) const;
  /// Radius of the largest circle around the centroid that lies inside.
  [[nodiscard]] double inner_radius_mm() const { return inside_mm(Vec2::Zero()); }
};

/// The articular face before reaming, inside its rim.
struct NativeFace {
  std::optional<FaceSurface> surface;  ///< fitted to the face, at a distance from its rim
  double area_mm2 = 0;                 ///< along the surface, not of its projection
  double reamed_mm2 = 0;               ///< the part that was reamed to at least about half a voxel
};

/// Measures the unreamed surface within the outline, along the normal of the outline's plane. Heights are integrals of
/// fill, as in ColumnMap. Areas use the slope of a plane through the heights within 1.5 mm.
NativeFace measure_native_face(const BoneView& bone, const FaceOutline& outline);

/// Anatomical directions and points of a bone, as far as they are known.
struct BoneAxes {
  std::optional<ScapularAxes> scapula;
  std::optional<ScapularAxes> glenoid;   ///< of the glenoid frame, see axes_of()
  std::optional<Vec3> face_center_mm{};  ///< centre of the articular face, on the Friedman axis
  std::vector<Vec3> rim_mm{};            ///< of the articular face, in order; empty: unknown
  std::optional<Rigid> bone_from_glenoid{};
  VersionLandmarks version{};
  bool side_known = false;  ///< of the shoulder: anterior is not a guess
  bool axial_z = false;     ///< axial slices lie across z

  /// The scapular frame, or else the glenoid frame.
  [[nodiscard]] const std::optional<ScapularAxes>& known() const { return scapula ? scapula : glenoid; }
};

/// Retroversion and superior tilt are positive.
struct FaceAngles {
  double version_deg = 0;
  double inclination_deg = 0;
};
inline FaceAngles operator-(const FaceAngles& a, const FaceAngles& b) {
  return {a.version_deg - b.version_deg, a.inclination_deg - b.inclination_deg};
}

/// Version and inclination of a unit vector out of a face: version = atan2(−n·anterior, n·lateral), inclination =
/// asin(n·superior). The convention of bone.phantom.version_deg and inclination_deg.
FaceAngles face_angles(const Vec3& direction, const ScapularAxes& axes);

struct Missing {
  std::string reason;
};

template <class Value>
struct Measured {
  std::optional<Value> value;
  std::string reason;  ///< only without a value

  Measured() = default;
  Measured(const Value& found) : value(found) {}                    // not explicit on purpose
  Measured(Missing missing) : reason(std::move(missing.reason)) {}  // likewise
};

/// The joint line and the axes of the face. Native axis: from the centre of the face to that of the fitted sphere
/// (Lewis and Armstrong 2011, J Shoulder Elbow Surg 20, 3–11), or the normal of the fitted plane. Reamed axis: the same
/// from where the reamer's axis meets the reamed surface. Their standard error is at most a degree.
struct JointLine {
  std::optional<NativeFace> native_face;      ///< nullopt without a rim
  std::optional<FaceSurface> reamed_surface;  ///< fitted to the reamed face
  Measured<FaceAxis> native;
  Measured<FaceAxis> reamed;
  Measured<double> medialization_mm;  ///< along the Friedman axis, from the native to the reamed face
  Measured<double> reamed_fraction;   ///< of the native face's area
};

inline constexpr const char* kNoScapularFrame = "the scapular frame is unknown: set bone.glenoid.landmarks";

/// The angles of an axis in a frame; `without_frame`: the reason where there is no frame.
Measured<FaceAngles> angles_of(const Measured<FaceAxis>& axis, const std::optional<ScapularAxes>& frame,
                               const char* without_frame);

/// The intersection of the Friedman axis and the native face, B.
Measured<Vec3> point_on_native_face(const JointLine& line, const BoneAxes& axes);

/// `map`: along the reamer's axis, of the region that lost bone; `face`: from find_face(map).
JointLine measure_joint_line(const BoneView& bone, const ColumnMap& map, const ReamedFace& face, const BoneAxes& axes);

/// Thickness of the dense bone under the reamed face, along its normal. Less than about half a voxel counts as none.
struct RemainingDenseBone {
  double mean_mm = 0;
  double least_mm = 0;
  double p05_mm = 0;           ///< 5 % of the face have less
  double exposed_percent = 0;  ///< of the face without dense bone
};
/// nullopt where the face has no columns. `dense_g_cm3`: the least density of dense bone.
std::optional<RemainingDenseBone> remaining_dense_bone(const BoneView& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3);

/// Reaming through the bone, as areas projected along z of the map.
struct Perforation {
  int holes = 0;
  double area_mm2 = 0;  ///< of the holes: reamed through, surrounded by bone
  /// Reamed through within face_edge_columns() of the edge of the bone, or connected to it. The bone has an edge to
  /// air, and where the surface beside it lies below all removed bone.
  double rim_area_mm2 = 0;
};

/// Removed volume, mm³. Bone below MetricSettings::dense_g_cm3 is trabecular.
struct RemovedVolume {
  double total_mm3 = 0;
  double trabecular_mm3 = 0;
  double dense_mm3 = 0;  ///< subchondral and cortical
};

/// Depth along the reamer's axis (docs/results.md, Headline).
struct AxialDepth {
  double max_mm = 0;
  double mean_mm = 0;
  double p95_mm = 0;    ///< 95 % of the reamed area is less deep
  double area_mm2 = 0;  ///< reamed area, projected along the axis
};

/// Orientation of the planes fitted to the reamed columns. A plane through a part of a bowl tilts with that part: it
/// does not show the orientation of the face (see FaceOrientation).
struct PlaneOrientation {
  std::optional<FaceAngles> before;  ///< in the scapular frame
  std::optional<FaceAngles> after;   ///< likewise
  std::optional<FaceAngles> change;  ///< after − before; in the glenoid frame if there is no scapular frame
  double turned_deg = 0;             ///< the angle between the planes
};

/// Orientation of the face, by the axes of JointLine.
struct FaceOrientation {
  Measured<FaceAngles> native;       ///< in the scapular frame
  Measured<FaceAngles> reamed;       ///< likewise
  std::optional<FaceAngles> reamer;  ///< of the reamer's axis, likewise
  /// Native − reamed: positive where retroversion or superior tilt decreased. In the glenoid frame if there is no
  /// scapular frame. Missing where less than half of the face was reamed.
  Measured<FaceAngles> corrected;
  std::optional<double> turned_deg;  ///< the angle between both axes
  std::optional<PlaneOrientation> planes;
};

/// Angle between two directions, degrees.
double angle_deg(const Vec3& a, const Vec3& b);

/// Version of the face before reaming by one definition.
struct FaceVersion {
  const char* name;
  const char* definition;
  Measured<double> deg;  ///< retroversion positive
};

/// By every definition in use. `native`: FaceOrientation::native.
std::vector<FaceVersion> measure_versions(const Measured<FaceAngles>& native, const BoneAxes& axes);

/// The back of an implant in its frame I, mm: origin at the apex of the plain back, +z out of the bone, +y superior.
class ImplantShape {
 public:
  /// `mesh`: that of ImplantSettings::mesh, or nullptr; it must outlive the object.
  explicit ImplantShape(const ImplantSettings& settings, const TriangleMesh* mesh = nullptr);

  /// Height of the back, augment included; nullopt beside a spherical back.
  [[nodiscard]] std::optional<double> back_mm(const Vec2& place) const;
  /// Height of the back with a place outside the footprint moved towards the axis, to the edge of the footprint.
  [[nodiscard]] double level_mm(const Vec2& place) const;

  /// Whether the footprint has an outline of its own; otherwise it is the reamed face.
  [[nodiscard]] bool has_outline() const { return half_width_mm_ > 0; }
  /// Whether the back is one with steps.
  [[nodiscard]] bool may_have_walls() const {
    return mesh_.has_value() || (augment_ && augment_->shape == AugmentShape::step);
  }
  /// Whether a place lies within the outline; true without one.
  [[nodiscard]] bool covers(const Vec2& place) const;
  /// The fraction of a square cell within the outline, from 8 × 8 points; of a mesh 4 × 4.
  [[nodiscard]] double covered_fraction(const Vec2& center, double cell_mm) const;
  /// Half the longer side of the outline's bounding box.
  [[nodiscard]] double reach_mm() const { return std::max(half_width_mm_, half_height_mm_); }
  /// Depth of the lowest point of the augment below the apex of the plain back.
  [[nodiscard]] double augment_depth_mm() const;
  /// Whether a point of the mesh lies so far below the plain back that it belongs to a peg.
  [[nodiscard]] bool is_peg(const Vec3& point) const;
  /// The fraction of the underside of the mesh within ImplantMeshSettings::pegs_below_mm of the plain back.
  [[nodiscard]] double back_fraction() const;

 private:
  [[nodiscard]] std::optional<double> plain_mm(const Vec2& place) const;
  [[nodiscard]] std::optional<double> augment_mm(const Vec2& place) const;
  [[nodiscard]] std::optional<double> underside_mm(const Vec2& place) const;

  double radius_mm_;  ///< 0: flat
  double half_width_mm_;
  double half_height_mm_;
  FootprintShape shape_;
  std::optional<AugmentSettings> augment_;
  std::optional<LineCrossings> mesh_;  ///< its crossings with lines along z
  double pegs_below_mm_ = 0;
  Vec2 toward_ = Vec2::UnitX();          ///< of the augment
  Vec3 wedge_center_mm_ = Vec3::Zero();  ///< of the rotated sphere
};

/// Reads the mesh of ImplantSettings::mesh. Throws InputError: no closed surface, a size that is not supported, an
/// underside that is not at the plain back.
TriangleMesh read_implant_mesh(const ImplantSettings& settings, Diagnostics& report);

/// The pose of an implant before it is seated: its apex at `center_mm`, +y superior (of the settings, else of the
/// glenoid or scapular frame, else +y of the settings' frame). nullopt where its glenoid frame is unknown.
std::optional<Rigid> implant_pose(const ImplantSettings& settings, const Rigid& bone_from_tool, const BoneAxes& axes);

/// A column under the footprint of an implant.
struct FootprintColumn {
  ColumnPlace place;
  double weight = 0;         ///< fraction of the column within the footprint
  double back_mm = 0;        ///< height of the implant's back above its apex
  bool hole = false;         ///< reamed through, surrounded by bone
  bool beside_wall = false;  ///< within a voxel of a wall of the back, as that of a step
};

struct SeatedImplant {
  ColumnMap map;                                ///< along the axis, in the frame of the implant before it is seated
  double apex_mm = 0;                           ///< z of the seated apex in the map
  Rigid bone_from_implant = Rigid::Identity();  ///< of the seated implant
  std::vector<FootprintColumn> footprint;       ///< only where the implant has a back

  /// Distance from the back of the implant down to the bone, mm; negative where the bone is penetrated.
  [[nodiscard]] double gap_mm(const FootprintColumn& column) const {
    return apex_mm + column.back_mm - map.at(column.place).after_mm;
  }
  [[nodiscard]] double column_mm2() const { return map.pitch_mm * map.pitch_mm; }
};

/// Bone further below the back of an implant than this does not lie under it: the implant projects beyond the bone.
inline constexpr double kOverhangDepth_mm = 5;

/// Translates an implant along its axis until the highest percent of its footprint has yielded; without
/// ImplantSettings::seat it stays there. The footprint is its outline, or without one the reamed face. In an outline,
/// unreamed bone supports the implant, but no core of a cannulated reamer. nullopt where the footprint contains no
/// bone.
std::optional<SeatedImplant> place_implant(const BoneView& bone, const Rigid& bone_from_implant,
                                           const ImplantShape& shape, const ImplantSettings& settings);

/// Unreamed bone on which an implant rests.
struct HeldOff {
  Vec3 position_mm = Vec3::Zero();  ///< its point next to the implant if that rested on reamed bone alone, B
  double gap_mm = 0;                ///< by which the implant would lie deeper then
  double area_mm2 = 0;              ///< of the unreamed bone that is in its way
};

/// Contact between the back of an implant and the bone. Areas are projected along the axis.
struct Seating {
  double footprint_mm2 = 0;
  double seated_percent = 0;  ///< of the footprint, with a gap of at most ImplantSettings::gap_mm
  double mean_gap_mm = 0;     ///< over the part of the footprint with bone
  double max_gap_mm = 0;      ///< likewise
  double overhang_mm2 = 0;    ///< of the footprint beyond the edge of the bone
  double overhang_percent = 0;
  std::optional<double> dense_percent;  ///< dense fraction of the bone in the supporting layer; nullopt: no bone
  double unreamed_mm2 = 0;              ///< of the footprint, over bone that was not reamed
  std::optional<HeldOff>
      held_off;  ///< nullopt: it rests on reamed bone, no reamed face is under it, or it was not seated

  /// What to warn of: a footprint wider than what was reamed; "" where it is not.
  [[nodiscard]] std::string warning() const;
};

/// `dense_g_cm3`: the least density of dense bone.
Seating measure_seating(const BoneView& bone, const SeatedImplant& implant, const ImplantSettings& settings,
                        double dense_g_cm3);

/// A point of the surface of a peg, in the frame of the implant.
struct PegPoint {
  Vec3 at_mm;
  Vec3 outward;  ///< of length 1
};

/// The surface of a peg as far as its wall is measured.
struct PegSurface {
  struct Circumference {
    Vec3 center_mm = Vec3::Zero();
    double length_mm = 0;  ///< of the axis, to the next circumference
    std::vector<PegPoint> points{};
  };
  std::vector<Circumference> circumferences;  ///< from the back down
  std::vector<PegPoint> rays;                 ///< along which the wall is measured
  std::pair<Vec3, Vec3> axis_mm;
};

/// In the order of the settings; of a mesh its parts with a vertex for which shape.is_peg() is true, in its order.
std::vector<PegSurface> surfaces_of_pegs(const ImplantSettings& settings, const ImplantShape& shape,
                                         const TriangleMesh* mesh, double voxel_mm);

/// The bone around a peg of a seated implant. Its wall ends at the outer surface of the bone, of which the gap between
/// back and bone, through which the peg enters, is no part.
struct PegWall {
  double length_mm = 0;      ///< of the axis below the back of the implant
  double in_bone_mm = 0;     ///< length of the axis over which the whole circumference lies in bone
  double perforated_mm = 0;  ///< length of the axis over which the circumference leaves the outer surface of the bone
  /// From the surface of the capsule to the outer surface; 0: perforated. nullopt where no part lies below the back.
  std::optional<double> least_wall_mm;
};

/// Remaining bone under the footprint of an implant, to ImplantSettings::vault_depth_mm below the unreamed surface
/// along its axis or the first air. Holes for pegs are not subtracted.
struct Vault {
  double before_mm3 = 0;                ///< before reaming
  double left_mm3 = 0;                  ///< below the back of the implant
  double mean_depth_mm = 0;             ///< left_mm3 over the area of the footprint
  std::optional<double> axis_depth_mm;  ///< on the axis of the implant; nullopt beside the bone
};

/// What a surgeon plans by: pose, support and fixation of an implant in the reamed bone.
struct Planning {
  Rigid bone_from_implant = Rigid::Identity();  ///< of the seated implant
  Measured<FaceAngles> native;                  ///< of the face before reaming, in the scapular frame
  Measured<FaceAngles> planned;                 ///< of the axis of the implant, likewise
  /// Native − planned: positive where retroversion or superior tilt decreases. In the scapular, else the glenoid frame.
  Measured<FaceAngles> corrected;
  /// Along the Friedman axis, from the native face to the articular surface, which is the plain back of the implant
  /// translated along its axis by ImplantSettings::thickness_mm. Positive is medial.
  Measured<double> medialization_mm;
  Seating seating;
  Vault vault;
  std::vector<PegWall> pegs;                       ///< in the order of the settings, or of the mesh
  std::vector<std::pair<Vec3, Vec3>> peg_axes_mm;  ///< likewise, in the frame of the implant

  /// Pegs of which a part, perhaps only the end, leaves the outer surface of the bone.
  [[nodiscard]] std::ptrdiff_t pegs_perforated() const {
    return std::ranges::count_if(pegs, [](const PegWall& peg) { return peg.least_wall_mm == 0.0; });
  }
};

/// nullopt where the footprint of the implant contains no bone, or its frame is unknown.
std::optional<Planning> measure_planning(const BoneView& bone, const Rigid& bone_from_tool, const JointLine& line,
                                         const BoneAxes& axes, const MetricSettings& settings,
                                         const TriangleMesh* implant_mesh);

struct BoneMetrics {
  RemovedVolume removed;
  std::vector<FaceVersion> versions;
  // The following are missing if no column lost bone.
  std::optional<AxialDepth> depth;
  std::optional<ReamedFace> face;
  std::optional<JointLine> joint_line;
  std::optional<FaceOrientation> orientation;
  std::optional<RemainingDenseBone> remaining_dense;
  std::optional<Perforation> perforation;
  std::optional<Planning> planning;  ///< only with an implant
};

RemovedVolume removed_volume(const BoneView& bone, double dense_g_cm3);

/// `bone_from_tool`: the deepest pose of the tool; depths are measured along its −z. `implant_mesh`: of the settings.
BoneMetrics measure_bone(const BoneView& bone, const Rigid& bone_from_tool, const BoneAxes& axes,
                         const MetricSettings& settings, const TriangleMesh* implant_mesh = nullptr);

/// The depth map: columns along −z of the glenoid frame, or else of the deepest pose of the tool.
ColumnMap depth_map(const BoneView& bone, const std::optional<GlenoidFrame>& glenoid, const Rigid& bone_from_tool);

}  // namespace reamsim
