// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/metrics_file.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/csv.h"
#include "sim/record/result_json.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

/// `make` of the value; null where it is missing.
template <class Value, class Make>
Json json_or_null(const std::optional<Value>& value, const Make& make) {
  return value ? make(*value) : Json();
}

Json angles_json(const std::optional<FaceAngles>& angles) {
  return json_or_null(angles, [](const FaceAngles& a) {
    return Json{{"version_deg", a.version_deg}, {"inclination_deg", a.inclination_deg}};
  });
}

Json plane_json(const PlaneFit& plane) {
  return {{"point_mm", vector_json(plane.point_mm)},
          {"normal", vector_json(plane.normal)},
          {"residual_rms_mm", plane.rms_mm}};
}

Json face_json(const ReamedFace& face) {
  Json json;
  json["shape"] = !face.plane ? Json() : Json(face.spherical ? "sphere" : "plane");
  json["points"] = face.columns.size();
  json["sphere"] = json_or_null(face.sphere, [&](const SphereFit& sphere) {
    return Json{{"radius_mm", sphere.radius_mm},
                {"center_mm", vector_json(sphere.center_mm)},
                {"concave", face.concave},
                {"residual_rms_mm", sphere.rms_mm}};
  });
  json["plane"] = json_or_null(face.plane, plane_json);
  return json;
}

/// Why a value is missing; null where it is not.
template <class Value>
Json reason_json(const Measured<Value>& measured) {
  return measured.value ? Json() : Json(measured.reason);
}

Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

constexpr const char* kNativeDefinition =
    "sphere: line from the centre of the face to the centre of the sphere fitted to the unreamed face within its rim "
    "(Lewis and Armstrong 2011); plane: its normal";
constexpr const char* kReamedDefinition =
    "sphere: line from the intersection of the reamer's axis with the sphere fitted to the reamed face to its centre; "
    "plane: its normal";
constexpr const char* kVersionConvention = "atan2(-n.anterior, n.lateral), retroversion positive";
constexpr const char* kInclinationConvention = "asin(n.superior), superior tilt positive; not projected";

Json planes_json(const PlaneOrientation& planes) {
  return {{"before", angles_json(planes.before)},
          {"after", angles_json(planes.after)},
          {"change", angles_json(planes.change)},
          {"turned_deg", planes.turned_deg}};
}

Json orientation_json(const FaceOrientation& orientation, const JointLine& line) {
  const auto shape = [](const std::optional<FaceSurface>& surface, bool has_axis) {
    return surface && has_axis ? Json(surface->spherical ? "sphere" : "plane") : Json();
  };
  const auto error = [](const Measured<FaceAxis>& axis) {
    return json_or_null(axis.value, [](const FaceAxis& found) { return Json(found.error_deg); });
  };
  const auto& native_face = line.native_face;
  const auto corrected = [&](double FaceAngles::*angle) {
    return json_or_null(orientation.corrected.value, [&](const FaceAngles& angles) { return Json(angles.*angle); });
  };
  return {{"definition", {{"native", kNativeDefinition}, {"reamed", kReamedDefinition}}},
          {"version_convention", kVersionConvention},
          {"inclination_convention", kInclinationConvention},
          {"native", angles_json(orientation.native.value)},
          {"native_reason", reason_json(orientation.native)},
          {"native_shape", native_face ? shape(native_face->surface, line.native.value.has_value()) : Json()},
          {"native_standard_error_deg", error(line.native)},
          {"reamed", angles_json(orientation.reamed.value)},
          {"reamed_reason", reason_json(orientation.reamed)},
          {"reamed_shape", shape(line.reamed_surface, line.reamed.value.has_value())},
          {"reamed_standard_error_deg", error(line.reamed)},
          {"reamer", angles_json(orientation.reamer)},
          {"retroversion_corrected_deg", corrected(&FaceAngles::version_deg)},
          {"inclination_corrected_deg", corrected(&FaceAngles::inclination_deg)},
          {"corrected_reason", reason_json(orientation.corrected)},
          {"corrected_frame", orientation.corrected.value ? Json(orientation.reamer ? "scapular" : "glenoid") : Json()},
          {"turned_deg", number_or_null(orientation.turned_deg)},
          {"planes_through_reamed_columns", json_or_null(orientation.planes, planes_json)}};
}

Json surface_json(const FaceSurface& surface) {
  Json json{{"shape", surface.spherical ? "sphere" : "plane"},
            {"points", surface.points},
            {"fitted_fraction", surface.fitted_fraction},
            {"residual_rms_mm", surface.rms_mm}};
  if (surface.spherical) {
    json["radius_mm"] = surface.sphere->radius_mm;
    json["center_mm"] = vector_json(surface.sphere->center_mm);
    json["concave"] = surface.concave;
  } else {
    json["point_mm"] = vector_json(surface.plane.point_mm);
    json["normal"] = vector_json(surface.plane.normal);
  }
  return json;
}

Json joint_line_json(const JointLine& line) {
  const auto surface = [&](const NativeFace& face) { return json_or_null(face.surface, surface_json); };
  return {{"native_surface", json_or_null(line.native_face, surface)},
          {"reamed_surface", json_or_null(line.reamed_surface, surface_json)},
          {"native_area_mm2", json_or_null(line.native_face, [](const NativeFace& f) { return Json(f.area_mm2); })},
          {"reamed_fraction", number_or_null(line.reamed_fraction.value)},
          {"reamed_fraction_definition",
           "fraction of the area of the native face within its rim that lost bone, along the surface"},
          {"reamed_fraction_reason", reason_json(line.reamed_fraction)},
          {"medialization_mm", number_or_null(line.medialization_mm.value)},
          {"medialization_definition", "along the Friedman axis, from the native to the reamed surface"},
          {"medialization_reason", reason_json(line.medialization_mm)}};
}

Json dense_json(const RemainingDenseBone& left) {
  return {{"mean_mm", left.mean_mm},
          {"least_mm", left.least_mm},
          {"p05_mm", left.p05_mm},
          {"exposed_percent", left.exposed_percent}};
}

Json perforation_json(const Perforation& perforation) {
  return {{"perforated", perforation.holes > 0},
          {"holes", perforation.holes},
          {"area_mm2", perforation.area_mm2},
          {"rim_area_mm2", perforation.rim_area_mm2}};
}

Json seating_json(const Planning& planning) {
  const Seating& seating = planning.seating;
  return {{"footprint_mm2", seating.footprint_mm2},
          {"seated_percent", seating.seated_percent},
          {"mean_gap_mm", seating.mean_gap_mm},
          {"max_gap_mm", seating.max_gap_mm},
          {"overhang_mm2", seating.overhang_mm2},
          {"overhang_percent", seating.overhang_percent},
          {"dense_percent", number_or_null(seating.dense_percent)}};
}

Json vault_json(const Vault& vault) {
  return {{"before_mm3", vault.before_mm3},
          {"left_mm3", vault.left_mm3},
          {"left_percent", vault.before_mm3 > 0 ? Json(100 * vault.left_mm3 / vault.before_mm3) : Json()},
          {"mean_depth_mm", vault.mean_depth_mm},
          {"axis_depth_mm", number_or_null(vault.axis_depth_mm)}};
}

Json pegs_json(const std::vector<PegWall>& pegs) {
  Json json = Json::array();
  for (const PegWall& peg : pegs) {
    json.push_back({{"length_mm", peg.length_mm},
                    {"in_bone_mm", peg.in_bone_mm},
                    {"perforated_mm", peg.perforated_mm},
                    {"least_wall_mm", number_or_null(peg.least_wall_mm)}});
  }
  return json;
}

Json planning_json(const Planning& planning) {
  const Rigid& pose = planning.bone_from_implant;
  const auto corrected = [&](double FaceAngles::*angle) {
    return json_or_null(planning.corrected.value, [&](const FaceAngles& angles) { return Json(angles.*angle); });
  };
  const bool scapular = planning.planned.value.has_value();
  return {{"apex_mm", vector_json(pose.translation())},
          {"axis", vector_json(pose.linear().col(2))},
          {"superior", vector_json(pose.linear().col(1))},
          {"native", angles_json(planning.native.value)},
          {"native_reason", reason_json(planning.native)},
          {"planned", angles_json(planning.planned.value)},
          {"planned_reason", reason_json(planning.planned)},
          {"retroversion_corrected_deg", corrected(&FaceAngles::version_deg)},
          {"inclination_corrected_deg", corrected(&FaceAngles::inclination_deg)},
          {"corrected_reason", reason_json(planning.corrected)},
          {"corrected_frame", planning.corrected.value ? Json(scapular ? "scapular" : "glenoid") : Json()},
          {"medialization_mm", number_or_null(planning.medialization_mm.value)},
          {"medialization_reason", reason_json(planning.medialization_mm)},
          {"vault", vault_json(planning.vault)},
          {"pegs", pegs_json(planning.pegs)}};
}

/// To a millionth of a millimetre, so that -13.8 is not written as -13.800000000000002.
double rounded(double mm) {
  constexpr double kPerMm = 1e6;
  return std::round(mm * kPerMm) / kPerMm;
}

}  // namespace

Json metrics_json(const BoneMetrics& metrics) {
  Json json;
  json["removed"] = {{"total_mm3", metrics.removed.total_mm3},
                     {"trabecular_mm3", metrics.removed.trabecular_mm3},
                     {"dense_mm3", metrics.removed.dense_mm3}};
  json["depth"] = json_or_null(metrics.depth, [](const AxialDepth& depth) {
    return Json{
        {"max_mm", depth.max_mm}, {"mean_mm", depth.mean_mm}, {"p95_mm", depth.p95_mm}, {"area_mm2", depth.area_mm2}};
  });
  json["face"] = json_or_null(metrics.face, face_json);
  json["orientation"] = json_or_null(metrics.orientation, [&](const FaceOrientation& orientation) {
    return orientation_json(orientation, *metrics.joint_line);
  });
  json["joint_line"] = json_or_null(metrics.joint_line, joint_line_json);
  json["dense_bone_left"] = json_or_null(metrics.remaining_dense, dense_json);
  json["perforation"] = json_or_null(metrics.perforation, perforation_json);
  json["seating"] = json_or_null(metrics.planning, seating_json);
  json["planning"] = json_or_null(metrics.planning, planning_json);
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

nlohmann::ordered_json clearance_json(const HolderClearance& clearance, const SimulationInput& scene) {
  const FrameClearance& least = clearance.least;
  const Vec3& p = least.point_mm;
  nlohmann::ordered_json json{{"least_mm", least.mm},
                              {"frame", least.frame},
                              {"time_s", static_cast<double>(least.frame) * scene.motion.frame_s()},
                              {"part", holder_part_name(scene.scenario, least)},
                              {"obstacle", name_of(least.obstacle)},
                              {"point_mm", {p.x(), p.y(), p.z()}},
                              {"limit_mm", scene.scenario.clearance.least_mm},
                              {"first_frame_below", nullptr},
                              {"last_frame_below", nullptr}};
  if (clearance.first_below) json["first_frame_below"] = *clearance.first_below;
  if (clearance.last_below) json["last_frame_below"] = *clearance.last_below;
  return json;
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
