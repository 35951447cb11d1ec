// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/locate_glenoid.h"

#include <fmt/core.h>
#include <algorithm>
#include <vector>

#include "cli/first_scenario.h"
#include "sim/anatomy/search_faces.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scan/ct_import.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

constexpr double kSearchVoxel_mm = 1;
constexpr std::size_t kMostJoints = 4;
constexpr double kLeastConfidence = 0.6;
constexpr double kRival = 0.8;  // of the confidence of the best place: another one that is as plausible

std::string text_of(const FacePlace& place) {
  const Vec3 &c = place.center_mm, &n = place.normal;
  return fmt::format("({:.1f}, {:.1f}, {:.1f}), {:.0f} x {:.0f} mm, normal ({:.2f}, {:.2f}, {:.2f}), confidence {:.2f}",
                     c.x(), c.y(), c.z(), place.height_mm, place.width_mm, n.x(), n.y(), n.z(), place.confidence);
}

/// The places next to the heads in a scan.
std::vector<FacePlace> places_at_heads(const BoneSettings& settings, Diagnostics& report) {
  std::vector<ct::Joint> joints = joints_in_scan(settings, report);
  joints.resize(std::min(joints.size(), kMostJoints));
  std::vector<FacePlace> out;
  for (const ct::Joint& joint : joints) {
    BoneSettings near = settings;
    near.ct.separate = Separate::humerus;
    near.glenoid.near_mm = joint.near_mm;
    if (near.side == BodySide::unknown) near.side = BodySide::left;  // turns about the normal only
    crop_round_glenoid(near.ct, joint.near_mm);
    try {
      Diagnostics ignored;
      const Bone bone = load_bone(near, ignored);
      if (const auto place = place_at(bone.view(), bone.glenoid->bone_from_glenoid)) out.push_back(*place);
    } catch (const InputError&) {
      // A head without a glenoid, as in the hip.
    }
  }
  return out;
}

/// Places on the whole surface of the bone.
std::vector<FacePlace> places_on_surface(const BoneSettings& settings, Diagnostics& report) {
  return search_faces(load_bone(settings, report).view());
}

/// In LPS a left glenoid faces +x.
bool is_of_other_side(const FacePlace& place, BodySide side) {
  return side != BodySide::unknown && (place.normal.x() > 0) != (side == BodySide::left);
}

/// `of_bone` gets what is said of the bone.
std::vector<FacePlace> places_of(const BoneSettings& settings, Diagnostics& of_bone, Diagnostics& report) {
  std::vector<FacePlace> out;
  if (settings.source == BoneSource::ct) {
    out = places_at_heads(settings, of_bone);
    if (out.empty()) {
      report.note("no head of a humerus with a joint in the scan: the whole surface of the bone is searched");
    }
  }
  if (out.empty()) out = places_on_surface(settings, of_bone);
  std::ranges::stable_sort(out, {}, [](const FacePlace& place) { return -place.confidence; });
  return out;
}

[[noreturn]] void refuse(const BoneSettings& settings, const std::string& found) {
  throw InputError({}, "--near", "missing, and " + found,
                   std::string(settings.source == BoneSource::mesh ? "check --scale; " : "") +
                       "give a point on the face of the glenoid, --near=X,Y,Z; `reamsim preview BONE -o bone.html` "
                       "shows coordinates");
}

/// The centre of the only plausible face.
Vec3 only_face(const BoneSettings& settings, Diagnostics& of_bone, Diagnostics& report) {
  std::vector<FacePlace> places = places_of(settings, of_bone, report);
  if (settings.source == BoneSource::ct) {
    const auto of_other_side = [&](const FacePlace& place) { return is_of_other_side(place, settings.side); };
    const std::size_t others = std::erase_if(places, of_other_side);
    if (others > 0 && places.empty()) {
      refuse(settings, "the search found a glenoid of the other side only: check --side");
    }
  }
  if (places.empty()) refuse(settings, "the search found no face of a glenoid");
  const FacePlace& best = places.front();
  if (best.confidence < kLeastConfidence) {
    refuse(settings, "the search found no clear face of a glenoid; the best: " + text_of(best));
  }
  std::string rivals;
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i].confidence >= kRival * best.confidence) rivals += " or " + text_of(places[i]);
  }
  if (!rivals.empty())
    refuse(settings, "the search found several faces that may be the glenoid: " + text_of(best) + rivals);
  report.note("search for the glenoid: " + text_of(best) +
              (places.size() > 1 ? fmt::format("; the next best place has {:.2f}", places[1].confidence) : ""));
  return best.center_mm;
}

/// The scan may have been read more than once.
void add_warnings_once(const Diagnostics& from, Diagnostics& to) {
  for (const std::string& warning : from.warnings) {
    if (std::ranges::find(to.warnings, warning) == to.warnings.end()) to.warn(warning);
  }
}

}  // namespace

Vec3 locate_glenoid(const BoneSettings& given, Diagnostics& report) {
  BoneSettings settings = given;
  settings.voxel_mm = kSearchVoxel_mm;
  Diagnostics of_bone;  // where a face is found, the bone is loaded once more with it, and its warnings come then
  try {
    return only_face(settings, of_bone, report);
  } catch (const InputError&) {
    add_warnings_once(of_bone, report);
    throw;
  }
}

}  // namespace reamsim
