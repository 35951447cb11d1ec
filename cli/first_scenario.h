// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

// The first scenario of a bone, which `init` and `preview` write. Its landmarks: landmark_roles.cpp.

/// `given`, or where it is "" the convex reamer that comes with the program. Throws InputError where there is no such
/// file.
std::string reamer_or_own(const std::string& given);

/// The settings of a bone file; `scale` is of a mesh, `threshold_hu` of a CT, `more` are overrides. Throws InputError.
BoneSettings first_bone(const std::string& path, double voxel_mm, double scale, double threshold_hu,
                        const std::vector<std::string>& more = {});

/// A plunge of 3 mm beyond first contact, along the normal at the centre of the face.
PlungeSettings first_plunge();

struct FirstScenario {
  std::string first_line;  ///< a comment
  BoneSettings bone;       ///< a side that is unknown, a crop that is open, and a near_mm that is missing: left out
  std::string bone_path;   ///< as it stands in the file
  std::string tool_path;   ///< likewise
  std::string scale_note;  ///< of a mesh: why its scale is what it is; "": nothing is known of it
  std::optional<Rigid> glenoid;  ///< bone_from_glenoid that was found
  PlungeSettings plunge;
};

/// Landmarks of a scapula for a first scenario, LPS, mm.
struct Landmarks {
  std::optional<Vec3> center;
  GlenoidSettings glenoid;         ///< landmarks where all three are there, else the superior direction; and the rim
  std::vector<std::string> found;  ///< for the user: which point was understood as what, and which were not used
};

/// The landmarks of markups files, by `given`, "ROLE=LABEL", or by their labels in any case: "Glenoid centre", "TS",
/// "rim-3". Labels that name the other side of the body are left out. Throws InputError: an unreadable file, an unknown
/// role or label, two points for one role, no point that is understood, a superior point at the centre.
Landmarks find_landmarks(const std::vector<std::string>& files, const std::vector<std::string>& given, BodySide side);

/// The file: comments say what its keys are for.
std::string text_of(const FirstScenario& first);

/// That text with the keys of `--set KEY.PATH=VALUE`: their values replaced, or added to their sections.
std::string with_keys(const std::string& text, const std::vector<std::string>& assignments);

/// The keys of the bone among the assignments of `--set`.
std::vector<std::string> bone_keys(const std::vector<std::string>& assignments);

/// What `--set` gives a key; the last one counts.
std::optional<std::string> value_set(const std::vector<std::string>& assignments, const std::string& key);

/// The scale of the option, or that of `--set bone.mesh.scale=...`. Throws InputError: both, or no number.
std::optional<double> scale_of(std::optional<double> of_option, const std::vector<std::string>& assignments);

/// File units to mm of a bone's mesh that has no scenario yet.
struct MeshScale {
  double scale = 1;
  std::string why;  ///< for a comment: "given by --scale"; "" of a scan, whose file says its unit
};

/// The scale of the option, or by the length of the mesh, which is then said at once: what follows may fail because it
/// is wrong. Throws InputError: --scale for a scan, an unknown unit, a length that no bone with a glenoid has.
MeshScale mesh_scale(const std::string& path, std::optional<double> of_option, const Console& console);

}  // namespace reamsim
