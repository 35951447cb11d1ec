#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sim/base/report.h"
#include "sim/bone/ct/segmentation.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A bone ready to be reamed.
struct Bone {
  std::shared_ptr<const Voxmap> voxmap;                      ///< before reaming; whoever looks at it may share it
  FillBricks fill;                                           ///< live: what a run leaves of each voxel
  std::optional<GlenoidFrame> glenoid;                       ///< from the scenario, or the phantom's own, or the VDB's
  std::optional<LandmarkSettings> landmarks = std::nullopt;  ///< in B: likewise
  std::optional<ScapularAxes> scapula = std::nullopt;        ///< of the landmarks
  BodySide side = BodySide::unknown;                         ///< left | right | "": from the scenario, or the VDB's
  std::optional<Segmentation> segmentation = std::nullopt;   ///< of a CT
  std::vector<Vec3> rim_mm{};  ///< of the joint face, in B, in order: from the scenario, or the phantom's own

  Bone() = default;
  explicit Bone(FilledVoxmap&& voxels, std::optional<GlenoidFrame> frame = {}) : glenoid(std::move(frame)) {
    set_voxels(std::move(voxels));
  }

  [[nodiscard]] BoneView view() const { return {*voxmap, fill}; }
  operator BoneView() const { return view(); }  // not explicit on purpose
  void set_voxels(FilledVoxmap&& voxels);
  /// Takes voxmap and fill out, to change them; set_voxels() puts them back. Nobody may share the voxmap yet.
  [[nodiscard]] FilledVoxmap take_voxels();
};

/// Builds the bone that the scenario asks for (CT, mesh, VDB or phantom) and drills the pilot hole. All but a VDB's
/// lattice are fitted to the bone (fit_to_bone); a VDB keeps its own, so that reaming goes on where it stopped.
/// A glenoid frame is not held against the bone here: check_glenoid_frame() does that.
/// `settings.surface_voxels` must be decided (with_surface_voxels()); `auto` counts as whole.
/// Throws InputError for whatever is wrong with the data; says in `report` what was done (voxels, volumes, pieces).
Bone load_bone(const BoneSettings& settings, Report& report);

/// The sources behind load_bone(), with voxmap_from_ct() (sim/bone/ct/ct_import.h). Each gives an isotropic voxmap of
/// `settings.voxel_mm` in the frame B.

/// A closed mesh: cortical grade down to `cortical_mm` below the surface, trabecular grade inside. A voxel is bone when
/// its centre is inside, or as far as the surface leaves it. Throws InputError: unreadable, open or non-manifold
/// (unless `repair`), a repair that flooded, no volume, absurdly large.
FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Report& report);
/// A VDB of an earlier run or import, or another's with a FloatGrid `density`. Its own voxel size and density mapping
/// hold, and where the scenario does not say otherwise its glenoid frame, landmarks and side. Throws as
/// read_stored_bone().
Bone bone_from_vdb(const BoneSettings& settings, Report& report);
/// A generated bone in the frame "phantom". Verification blocks have their top face at z = 0 and the glenoid frame at
/// its centre, +z up; the sphere has its centre at the origin and the glenoid frame at its pole. The glenoid stands in
/// axes like a patient's (left: +x lateral, right: −x lateral; +y posterior; +z superior), the centre of its face
/// before wear at the origin, and has landmarks, which lie beyond the modelled bone. Throws InputError: shapes that
/// contradict themselves, a glenoid without `side`, absurdly large.
Bone bone_from_phantom(const BoneSettings& settings, Report& report);

/// The glenoid frame of the scenario, from centre/normal/superior or from landmarks; nullopt where neither is given.
/// `superior` is made perpendicular to the normal. From landmarks the normal is the Friedman axis (trigonum spinae to
/// glenoid centre, lateral), and superior lies in the scapular plane, away from the inferior angle. The frame is
/// right-handed on both sides: +x is posterior on a left scapula, anterior on a right one.
/// Throws InputError: an incomplete set, zero or parallel directions, landmarks on a line, a side that is not left or
/// right.
std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side);

/// The directions that a glenoid frame would be made of if its normal were the Friedman axis: lateral is its +z. On a
/// side that is neither left nor right they are those of a left scapula.
ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side);

/// Sets every voxel whose centre lies in the hole to air, or takes the part of each that lies in it (`partial`);
/// returns the drilled volume in mm³. `glenoid` is needed where `hole.frame` is glenoid. Throws InputError: no such
/// frame, no direction.
double drill_pilot_hole(FilledVoxmap& voxmap, const PilotHoleSettings& hole, const std::optional<GlenoidFrame>& glenoid,
                        bool partial = false);

/// Shrinks or grows the lattice so that `margin_voxels` of air surround the bone on every side, and the dimensions are
/// multiples of 8 (whole bricks). Throws InputError when there is no bone.
FilledVoxmap fit_to_bone(const FilledVoxmap& voxmap, int margin_voxels);

}  // namespace reamsim
