// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/csv.h"
#include "sim/record/result_json.h"
#include "sim/record/summary.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kNativeDefinition =
    "sphere: line from the centre of the face to the centre of the sphere fitted to the unreamed face within its rim "
    "(Lewis and Armstrong 2011); plane: its normal";
constexpr const char* kReamedDefinition =
    "sphere: line from the intersection of the reamer's axis with the sphere fitted to the reamed face to its centre; "
    "plane: its normal";
constexpr const char* kVersionConvention = "atan2(-n.anterior, n.lateral), retroversion positive";
constexpr const char* kInclinationConvention = "asin(n.superior), superior tilt positive; not projected";

/// Why a value is missing; null where it is not.
template <class Value>
Json reason_json(const Measured<Value>& measured) {
  return measured.value ? Json() : Json(measured.reason);
}

/// A member of a value; null where the value is missing.
template <class Struct, class Member>
Json member_json(const std::optional<Struct>& value, Member Struct::*member) {
  return value ? Json((*value).*member) : Json();
}

const char* shape_name(bool spherical) {
  return spherical ? "sphere" : "plane";
}

}  // namespace

// Found by nlohmann::json, also for the values of std::optional.

REAMSIM_TO_JSON(RemovedVolume, total_mm3, trabecular_mm3, dense_mm3)
REAMSIM_TO_JSON(FaceAngles, version_deg, inclination_deg)
REAMSIM_TO_JSON(PlaneOrientation, before, after, change, turned_deg)
REAMSIM_TO_JSON(AxialDepth, max_mm, mean_mm, p95_mm, area_mm2)
REAMSIM_TO_JSON(RemainingDenseBone, mean_mm, least_mm, p05_mm, exposed_percent)
REAMSIM_TO_JSON(HeldOff, position_mm, gap_mm, area_mm2)
REAMSIM_TO_JSON(Seating, footprint_mm2, seated_percent, mean_gap_mm, max_gap_mm, overhang_mm2, overhang_percent,
                dense_percent, unreamed_mm2, held_off)
REAMSIM_TO_JSON(PegWall, length_mm, in_bone_mm, perforated_mm, least_wall_mm)

static void to_json(Json& json, const PlaneFit& plane) {
  json = {{"point_mm", plane.point_mm}, {"normal", plane.normal}, {"residual_rms_mm", plane.rms_mm}};
}

static void to_json(Json& json, const ReamedFace& face) {
  json = {{"shape", face.plane ? Json(shape_name(face.spherical)) : Json()},
          {"points", face.columns.size()},
          {"sphere", nullptr},
          {"plane", face.plane}};
  if (const auto& sphere = face.sphere) {
    json["sphere"] = {{"radius_mm", sphere->radius_mm},
                      {"center_mm", sphere->center_mm},
                      {"concave", face.concave},
                      {"residual_rms_mm", sphere->rms_mm}};
  }
}

static void to_json(Json& json, const FaceSurface& surface) {
  json = {{"shape", shape_name(surface.spherical)},
          {"points", surface.points},
          {"fitted_fraction", surface.fitted_fraction},
          {"residual_rms_mm", surface.rms_mm}};
  if (surface.spherical) {
    json["radius_mm"] = surface.sphere->radius_mm;
    json["center_mm"] = surface.sphere->center_mm;
    json["concave"] = surface.concave;
  } else {
    json["point_mm"] = surface.plane.point_mm;
    json["normal"] = surface.plane.normal;
  }
}

static void to_json(Json& json, const JointLine& line) {
  json = {{"native_surface", member_json(line.native_face, &NativeFace::surface)},
          {"reamed_surface", line.reamed_surface},
          {"native_area_mm2", member_json(line.native_face, &NativeFace::area_mm2)},
          {"reamed_fraction", line.reamed_fraction.value},
          {"reamed_fraction_definition",
           "fraction of the area of the native face within its rim that lost bone, along the surface"},
          {"reamed_fraction_reason", reason_json(line.reamed_fraction)},
          {"medialization_mm", line.medialization_mm.value},
          {"medialization_definition", "along the Friedman axis, from the native to the reamed surface"},
          {"medialization_reason", reason_json(line.medialization_mm)}};
}

static void to_json(Json& json, const Perforation& perforation) {
  json = {{"perforated", perforation.holes > 0},
          {"holes", perforation.holes},
          {"area_mm2", perforation.area_mm2},
          {"rim_area_mm2", perforation.rim_area_mm2}};
}

static void to_json(Json& json, const Vault& vault) {
  json = {{"before_mm3", vault.before_mm3},
          {"left_mm3", vault.left_mm3},
          {"left_percent", vault.before_mm3 > 0 ? Json(100 * vault.left_mm3 / vault.before_mm3) : Json()},
          {"mean_depth_mm", vault.mean_depth_mm},
          {"axis_depth_mm", vault.axis_depth_mm}};
}

static void to_json(Json& json, const Planning& planning) {
  const Rigid& pose = planning.bone_from_implant;
  const auto& corrected = planning.corrected.value;
  json = {{"apex_mm", Vec3(pose.translation())},
          {"axis", Vec3(pose.linear().col(2))},
          {"superior", Vec3(pose.linear().col(1))},
          {"native", planning.native.value},
          {"native_reason", reason_json(planning.native)},
          {"planned", planning.planned.value},
          {"planned_reason", reason_json(planning.planned)},
          {"retroversion_corrected_deg", member_json(corrected, &FaceAngles::version_deg)},
          {"inclination_corrected_deg", member_json(corrected, &FaceAngles::inclination_deg)},
          {"corrected_reason", reason_json(planning.corrected)},
          {"corrected_frame", corrected ? Json(planning.planned.value ? "scapular" : "glenoid") : Json()},
          {"medialization_mm", planning.medialization_mm.value},
          {"medialization_reason", reason_json(planning.medialization_mm)},
          {"vault", planning.vault},
          {"pegs", planning.pegs},
          {"pegs_perforated", planning.pegs_perforated()}};
}

namespace {

Json orientation_json(const FaceOrientation& orientation, const JointLine& line) {
  const auto shape = [](const std::optional<FaceSurface>& surface, bool has_axis) {
    return surface && has_axis ? Json(shape_name(surface->spherical)) : Json();
  };
  const auto& native_face = line.native_face;
  const auto& corrected = orientation.corrected.value;
  return {{"definition", {{"native", kNativeDefinition}, {"reamed", kReamedDefinition}}},
          {"version_convention", kVersionConvention},
          {"inclination_convention", kInclinationConvention},
          {"native", orientation.native.value},
          {"native_reason", reason_json(orientation.native)},
          {"native_shape", native_face ? shape(native_face->surface, line.native.value.has_value()) : Json()},
          {"native_standard_error_deg", member_json(line.native.value, &FaceAxis::error_deg)},
          {"reamed", orientation.reamed.value},
          {"reamed_reason", reason_json(orientation.reamed)},
          {"reamed_shape", shape(line.reamed_surface, line.reamed.value.has_value())},
          {"reamed_standard_error_deg", member_json(line.reamed.value, &FaceAxis::error_deg)},
          {"reamer", orientation.reamer},
          {"retroversion_corrected_deg", member_json(corrected, &FaceAngles::version_deg)},
          {"inclination_corrected_deg", member_json(corrected, &FaceAngles::inclination_deg)},
          {"corrected_reason", reason_json(orientation.corrected)},
          {"corrected_frame", corrected ? Json(orientation.reamer ? "scapular" : "glenoid") : Json()},
          {"turned_deg", orientation.turned_deg},
          {"planes_through_reamed_columns", orientation.planes}};
}

Json versions_json(const std::vector<FaceVersion>& versions) {
  Json out{{"convention", "retroversion positive"}, {"definition", Json::object()}};
  for (const FaceVersion& version : versions) {
    const std::string name = version.name;
    out["definition"][name] = version.definition;
    out[name + "_deg"] = version.deg.value;
    out[name + "_reason"] = reason_json(version.deg);
  }
  const auto known = std::ranges::count_if(versions, [](const FaceVersion& one) { return one.deg.value.has_value(); });
  const auto of_face = !versions.empty() && versions.front().deg.value ? 1 : 0;
  out["by_landmarks"] = known > of_face ? Json(known - of_face) : Json();
  return out;
}

/// To a millionth of a millimetre, so that -13.8 is not written as -13.800000000000002.
double rounded(double mm) {
  constexpr double kPerMm = 1e6;
  return std::round(mm * kPerMm) / kPerMm;
}

}  // namespace

Json metrics_json(const BoneMetrics& metrics) {
  Json json{{"removed", metrics.removed}, {"depth", metrics.depth}, {"face", metrics.face}};
  json["orientation"] = metrics.orientation ? orientation_json(*metrics.orientation, *metrics.joint_line) : Json();
  json["version"] = versions_json(metrics.versions);
  json["joint_line"] = metrics.joint_line;
  json["dense_bone_left"] = metrics.remaining_dense;
  json["perforation"] = metrics.perforation;
  json["seating"] = member_json(metrics.planning, &Planning::seating);
  json["planning"] = metrics.planning;
  return json;
}

void write_depth_map(const std::string& path, const ColumnMap& map) {
  CsvWriter log(path, "x_mm,y_mm,before_z_mm,after_z_mm,depth_mm");
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  map.for_each([&](const ColumnPlace& place) {
    const Column& column = map.at(place);
    if (column.state == ColumnState::air) return;
    const Vec2 center = map.center_mm(place);
    const bool remains = column.state != ColumnState::through;
    log.row({rounded(center.x()), rounded(center.y()), rounded(column.before_mm),
             remains ? rounded(column.after_mm) : kNone, rounded(column.depth_mm)});
  });
  log.close();
}

Json clearance_json(const HolderClearance& clearance, const SimulationInput& scene) {
  const FrameClearance& least = clearance.least;
  return {{"least_mm", least.mm},
          {"frame", least.frame},
          {"time_s", static_cast<double>(least.frame) * scene.motion.frame_s()},
          {"part", holder_part_name(scene.scenario, least)},
          {"obstacle", name_of(least.obstacle)},
          {"point_mm", least.point_mm},
          {"limit_mm", scene.scenario.clearance.least_mm},
          {"first_frame_below", clearance.first_below},
          {"last_frame_below", clearance.last_below}};
}

void write_clearance(const std::string& path, const HolderClearance& clearance, double frame_s) {
  CsvWriter log(path, "frame,time_s,clearance_mm,part,envelope,x_mm,y_mm,z_mm,pass");
  for (const FrameClearance& row : clearance.frames) {
    const Vec3& p = row.point_mm;
    const double part = static_cast<double>(row.part) + 1;
    log.row({static_cast<double>(row.frame), static_cast<double>(row.frame) * frame_s, row.mm, part,
             row.obstacle == Obstacle::envelope ? 1.0 : 0.0, p.x(), p.y(), p.z(), static_cast<double>(row.pass)});
  }
  log.close();
}

}  // namespace reamsim
