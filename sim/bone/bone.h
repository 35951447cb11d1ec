// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

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
  std::shared_ptr<const Voxmap> voxmap;                      ///< before reaming; shared with readers
  FillBricks fill;                                           ///< current fill of each voxel
  std::optional<GlenoidFrame> glenoid;                       ///< of the scenario, the phantom or the VDB
  std::optional<LandmarkSettings> landmarks = std::nullopt;  ///< in B; likewise
  std::optional<ScapularAxes> scapula = std::nullopt;        ///< from the landmarks
  BodySide side = BodySide::unknown;                         ///< of the scenario or the VDB
  std::optional<Segmentation> segmentation = std::nullopt;   ///< of a CT
  std::vector<Vec3> rim_mm{};  ///< of the articular face, in B, in order; of the scenario or the phantom

  Bone() = default;
  explicit Bone(FilledVoxmap&& voxels, std::optional<GlenoidFrame> frame = {}) : glenoid(std::move(frame)) {
    set_voxels(std::move(voxels));
  }

  [[nodiscard]] BoneView view() const { return {*voxmap, fill}; }
  operator BoneView() const { return view(); }  // not explicit on purpose
  void set_voxels(FilledVoxmap&& voxels);
  /// Moves voxmap and fill out, to change them; set_voxels() moves them back. The voxmap must not be shared yet.
  [[nodiscard]] FilledVoxmap take_voxels();
};

/// Builds the bone of the scenario (CT, mesh, VDB or phantom) and drills the pilot hole. The lattice is fitted to the
/// bone (fit_to_bone); only a VDB keeps its lattice, so that a run can continue an earlier one. Does not compare the
/// glenoid frame with the bone: check_glenoid_frame() does. `surface_voxels: automatic` counts as whole; resolve it
/// with with_surface_voxels(). Notes voxels, volumes and pieces in `report`. Throws InputError for invalid data.
Bone load_bone(const BoneSettings& settings, Report& report);

// The two steps of load_bone(), for bones that differ in their anatomy only.

/// The voxels, without the glenoid frame and the landmarks of the scenario, and without the pilot hole.
Bone bone_from_source(const BoneSettings& settings, Report& report);
/// Adds these. Voxmaps are not copied: with a pilot hole, that of `bone` must not be shared.
Bone with_anatomy(Bone bone, const BoneSettings& settings, Report& report);

// The sources of load_bone(), with voxmap_from_ct() (sim/bone/ct/ct_import.h): isotropic voxmaps in the frame B.

/// A closed mesh: cortical grade down to `cortical_mm` below the surface, trabecular grade below. Throws InputError:
/// unreadable, open or non-manifold (unless `repair`), a failed repair, no volume, absurdly large.
FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Report& report);
/// A VDB of an earlier run or import, or of another program with a FloatGrid `density`. Uses the voxel size and density
/// mapping of the VDB; its glenoid frame, landmarks and side if the scenario has none. Throws as read_stored_bone().
Bone bone_from_vdb(const BoneSettings& settings, Report& report);
/// A generated bone in the frame "phantom" (sim/bone/phantom.h). Blocks have their top face at z = 0; the sphere has
/// its centre at the origin. The glenoid has the axes of a patient (left: +x lateral, right: −x lateral; +y posterior;
/// +z superior), the centre of its native face at the origin, and landmarks beyond the modelled bone. Throws
/// InputError: inconsistent shapes, a glenoid without `side`, absurdly large.
Bone bone_from_phantom(const BoneSettings& settings, Report& report);

/// The glenoid frame of the scenario, from centre/normal/superior or from landmarks; nullopt without either,
/// and where the face must be found (find_glenoid.h). `superior`
/// is projected perpendicular to the normal. With landmarks the normal is the Friedman axis (trigonum spinae to glenoid
/// centre, lateral), and superior lies in the scapular plane, away from the inferior angle. The frame is right-handed
/// on both sides: +x is posterior on a left scapula, anterior on a right one. Throws InputError: an incomplete set,
/// zero or parallel directions, collinear landmarks, an unknown side.
std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side);

/// The scapular axes if the normal of the frame is the Friedman axis. An unknown side counts as left.
ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side);

/// Removes the voxels whose centre lies in the hole, or with `partial` the part of each voxel in the hole; returns the
/// drilled volume in mm³. `glenoid` is required if `hole.frame` is glenoid. Throws InputError: no such frame, no
/// direction.
double drill_pilot_hole(FilledVoxmap& voxmap, const PilotHoleSettings& hole, const std::optional<GlenoidFrame>& glenoid,
                        bool partial = false);

/// Changes the lattice so that it surrounds the bone with a margin of `margin_voxels`, and its dimensions are multiples
/// of 8 (whole bricks). Throws InputError without bone.
FilledVoxmap fit_to_bone(const FilledVoxmap& voxmap, int margin_voxels);

}  // namespace reamsim
