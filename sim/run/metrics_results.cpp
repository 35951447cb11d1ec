#include "sim/run/metrics_results.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/record/csv_log.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

/// What `make` makes of the value; null without one.
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

Json orientation_json(const FaceOrientation& orientation) {
  return {{"before", angles_json(orientation.before)},
          {"after", angles_json(orientation.after)},
          {"change", angles_json(orientation.change)},
          {"reamer", angles_json(orientation.reamer)},
          {"turned_deg", orientation.turned_deg}};
}

Json dense_json(const DenseBoneLeft& left) {
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

Json seating_json(const Seating& seating) {
  return {{"footprint_mm2", seating.footprint_mm2},
          {"seated_percent", seating.seated_percent},
          {"mean_gap_mm", seating.mean_gap_mm},
          {"max_gap_mm", seating.max_gap_mm}};
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
  json["depth"] = json_or_null(metrics.depth, [](const ReamedDepth& depth) {
    return Json{
        {"max_mm", depth.max_mm}, {"mean_mm", depth.mean_mm}, {"p95_mm", depth.p95_mm}, {"area_mm2", depth.area_mm2}};
  });
  json["face"] = json_or_null(metrics.face, face_json);
  json["orientation"] = json_or_null(metrics.orientation, orientation_json);
  json["dense_bone_left"] = json_or_null(metrics.dense_left, dense_json);
  json["perforation"] = json_or_null(metrics.perforation, perforation_json);
  json["seating"] = json_or_null(metrics.seating, seating_json);
  return json;
}

void write_depth_map(const std::string& path, const ColumnMap& map) {
  CsvLog log(path, "x_mm,y_mm,before_z_mm,after_z_mm,depth_mm");
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (int j = 0; j < map.ny; ++j) {
    for (int i = 0; i < map.nx; ++i) {
      const Column& column = map.at(i, j);
      if (column.state == ColumnState::air) continue;
      const Vec2 place = map.center_mm(i, j);
      const bool bone_left = column.state != ColumnState::through;
      log.row({rounded(place.x()), rounded(place.y()), rounded(column.before_mm),
               bone_left ? rounded(column.after_mm) : kNone, rounded(column.depth_mm)});
    }
  }
  log.close();
}

}  // namespace reamsim
