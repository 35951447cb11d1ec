// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/load_bone.h"
#include "sim/tool/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Where a tool that comes along a line from outside first touches the bone.
struct FirstContact {
  double travel_mm = 0;           ///< of the tool's origin along the line, from the given point
  Vec3 origin_mm = Vec3::Zero();  ///< the tool's origin there, B
  Vec3 bone_mm = Vec3::Zero();    ///< the point of the bone that is touched, B
};

/// First contact of an envelope with the axis `-direction` (unit vector, B) whose origin moves along `direction` on the
/// line through `through_mm` (B), from outside the bounding box of the bone. The bone is that of first_bone_mm(): whole
/// voxels are cubes, others are cut by the plane of their fill. nullopt where the envelope meets none. Error: well
/// below 0.1 voxel of that surface.
std::optional<FirstContact> find_first_contact(const BoneView& bone, const Profile& envelope, const Vec3& through_mm,
                                               const Vec3& direction);

/// First contact of a plunge or push along `axis` through `entry_mm`; `bone` is as it is before any reaming. Throws
/// InputError at entry_mm of `section` where the tool meets no bone.
FirstContact find_first_contact(const Bone& bone, const Tool& tool, const Vec3& entry_mm, const Vec3& axis,
                                PoseFrame frame, const std::string& section = "motion.plunge");

/// For users, one line.
std::string sentence_of(const FirstContact& contact);

/// Counts the depth of a plunge or push from entry_mm, which is moved to the first contact.
void count_from(const FirstContact& contact, auto& way) {
  way.entry_mm += contact.travel_mm * way.axis.normalized();
  way.from = PlungeStart::entry;
}

/// A tool on its path.
struct Pass {
  Tool tool;
  Motion motion;
};

/// The validated input of a run.
struct SimulationInput {
  Scenario scenario;
  Bone bone;
  Tool tool;      ///< of the present pass, the first one after loading
  Motion motion;  ///< of the present pass
  std::vector<Pass> later_passes = {};
  FrameSpans contact{};                        ///< expected (contact_forecast.h), for the choice of pictures
  std::optional<TriangleMesh> implant_mesh{};  ///< mm, in the frame of the implant
  std::vector<std::optional<FirstContact>> first_contacts = {};  ///< by pass, of plunges whose depth counts from it

  /// The first contact of the present pass.
  [[nodiscard]] std::optional<FirstContact> first_contact() const {
    const auto i = static_cast<std::size_t>(motion.pass) - 1;
    return i < first_contacts.size() ? first_contacts[i] : std::nullopt;
  }
  /// The last frame of the run.
  [[nodiscard]] std::int64_t last_frame() const {
    return later_passes.empty() ? motion.last_frame() : later_passes.back().motion.last_frame();
  }
};

/// Replaces tool and motion by those of the next pass. Returns false after the last pass.
bool begin_next_pass(SimulationInput& scene);

/// Loads bone, tool and motion of a scenario. Throws InputError with all mistakes, each at its key in the scenario
/// file. A glenoid frame that contradicts the bone is added to `frame_mistakes` instead: the scene is complete, but
/// must not run. `bones`: takes the bone from there where it is the same.
SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, MistakeList& frame_mistakes,
                           BoneCache* bones = nullptr);
/// The same; throws for a wrong frame as well.
SimulationInput load_scene(const Scenario& scenario, Diagnostics& report, BoneCache* bones = nullptr);

/// Called with a pass and the fill of the bone before it.
using VisitPass = std::function<void(const FillBricks& fill, const Tool& tool, const Motion& motion)>;

/// Visits the present pass and the later ones, with the bone that those before are predicted to leave.
void for_each_predicted_pass(const SimulationInput& scene, const VisitPass& visit);

}  // namespace reamsim
