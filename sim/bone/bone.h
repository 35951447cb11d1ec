// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A bone ready to be reamed.
struct Bone {
  std::shared_ptr<const Voxmap> voxmap;                      ///< before reaming; shared with readers
  FillBricks fill;                                           ///< current fill of each voxel
  FillBricks fill_before;                                    ///< that before the run
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

  [[nodiscard]] BoneView view() const { return {*voxmap, fill, fill_before}; }
  operator BoneView() const { return view(); }  // not explicit on purpose
  void set_voxels(FilledVoxmap&& voxels);
  /// A copy of voxmap and fill, to change them for set_voxels().
  [[nodiscard]] FilledVoxmap copy_voxels() const;
};

// Sources of bones, as isotropic voxmaps in the frame B. sim/scan reads those of a CT, sim/scene those of a VDB.

/// A closed mesh: cortical grade down to `cortical_mm` below the surface, trabecular grade below. Throws InputError:
/// unreadable, open or non-manifold (unless `repair`), a failed repair, no volume, absurdly large.
FilledVoxmap voxmap_from_mesh(const BoneSettings& settings, Diagnostics& report, const StageSink& stages = {});
/// A generated bone in the frame "phantom". Blocks have their top face at z = 0; the sphere has its centre at the
/// origin; the glenoid has the axes of a patient (left: +x lateral, right: −x lateral; +y posterior; +z superior), its
/// native face at the origin, and landmarks beyond the bone. Throws InputError: inconsistent shapes, absurdly large.
Bone bone_from_phantom(const BoneSettings& settings, Diagnostics& report);

/// Removes the voxels whose centre lies in the hole, or with `partial` the part of each voxel in the hole; returns the
/// drilled volume in mm³. Throws InputError if `hole.frame` is glenoid and there is none.
double drill_pilot_hole(FilledVoxmap& voxmap, const PilotHoleSettings& hole, const std::optional<GlenoidFrame>& glenoid,
                        bool partial = false);

/// Fits the lattice, of whole bricks, to the bone with a margin of `margin_voxels`. Throws InputError without bone.
FilledVoxmap fit_to_bone(const BoneView& bone, int margin_voxels);

/// The glenoid frame of the scenario, from centre/normal/superior or from landmarks; nullopt without either, and where
/// the face must be found (find_glenoid.h). With landmarks the normal is the Friedman axis, and superior lies in the
/// scapular plane. The frame is right-handed: +x is posterior on a left scapula, anterior on a right one. Throws
/// InputError: an incomplete set, zero or parallel directions, collinear landmarks, an unknown side.
std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side);

/// The scapular axes if the normal of the frame is the Friedman axis. An unknown side counts as left.
ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side);

}  // namespace reamsim
