// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/fit_face.h"
#include "sim/base/diagnostics.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// An articular face found on the surface of a bone.
struct FoundGlenoid {
  GlenoidFrame frame;        ///< origin on the surface, +z out of the face, +y superior
  std::vector<Vec3> rim_mm;  ///< B, in order round the face
  FaceNormal normal = FaceNormal::sphere;
  double height_mm = 0, width_mm = 0;  ///< of the pear that fits the rim
  double rim_fraction = 0;             ///< of the directions: those with a rim within 1.5 mm of the pear
  double rim_rms_mm = 0;               ///< of their distances from it
  double face_rms_mm = 0;              ///< of the distances of the face from the sphere or plane
  double radius_mm = 0;                ///< of the sphere; 0: none
  double confidence = 0;               ///< place_of(): 0…1
  bool superior_guessed = false;       ///< from the shape of the face only
};

/// Finds the face round `settings.near_mm`, which lies within about 8 mm of its centre: rays to the surface, walks to
/// the rim (walk_to_rim()), the pear that fits it (fit_pear()) and the sphere or plane that fits the face inside it,
/// in turns until the frame rests.
///
/// The centre is the middle of the pear's height on its long axis, moved to the surface along the normal. The normal
/// points to the centre of the sphere; for a face that is no single surface (biconcave) it is that of the plane through
/// the rim, the least-squares form of the intermediate glenoid, from rim to rim (Rouleau et al. 2010). Superior is that
/// of `settings.superior` or the landmarks; else the long axis of the face towards +z of a scan, and else towards its
/// narrow end. Throws InputError (bone.glenoid.near_mm): no bone near the point, no face round it.
FoundGlenoid find_glenoid(const BoneView& bone, const GlenoidSettings& settings, BodySide side);

/// One sentence for the console: centre, normal, size and residuals.
std::string sentence_of(const FoundGlenoid& found);
/// What makes the frame uncertain, a sentence each; none where it can be trusted.
std::vector<std::string> doubts_of(const FoundGlenoid& found);

}  // namespace reamsim
