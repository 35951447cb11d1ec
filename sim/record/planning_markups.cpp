// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "sim/record/summary.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kSchema =
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#";
/// Edge length of the planes, about the height of a glenoid; they have no natural end.
constexpr double kPlane_mm = 40;
/// Length of the axis of the reamer out of the bone.
constexpr double kAxis_mm = 60;

using LabelledPoint = std::pair<std::string, Vec3>;

OrderedJson list_of(const Vec3& v) {
  return OrderedJson::array({v.x() + 0.0, v.y() + 0.0, v.z() + 0.0});  // no negative zeros
}

/// A 4×4 matrix row by row.
OrderedJson matrix_json(const Rigid& transform) {
  OrderedJson out = OrderedJson::array();
  for (const double value : transform.matrix().transpose().reshaped()) out.push_back(value + 0.0);
  return out;
}

OrderedJson markup_json(const char* type, const std::string& name, const std::vector<LabelledPoint>& points,
                        const std::array<double, 3>& color) {
  OrderedJson control = OrderedJson::array();
  for (const auto& [label, position_mm] : points) {
    control.push_back({{"id", std::to_string(control.size() + 1)},
                       {"label", label},
                       {"description", ""},
                       {"associatedNodeID", ""},
                       {"position", list_of(position_mm)},
                       {"orientation", {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}},
                       {"selected", true},
                       {"locked", true},
                       {"visibility", true},
                       {"positionStatus", "defined"}});
  }
  return {{"type", type},
          {"name", name},
          {"coordinateSystem", "LPS"},
          {"coordinateUnits", "mm"},
          {"locked", true},
          {"labelFormat", "%N-%d"},
          {"controlPoints", control},
          {"display", {{"visibility", true}, {"color", color}, {"selectedColor", color}}}};
}

OrderedJson plane_markup(const std::string& name, const Vec3& point_mm, const Vec3& normal,
                         const std::array<double, 3>& color) {
  OrderedJson json = markup_json("Plane", name, {{name, point_mm}}, color);
  json["planeType"] = "pointNormal";
  json["sizeMode"] = "absolute";
  json["autoScalingSizeFactor"] = 1.0;
  json["size"] = {kPlane_mm, kPlane_mm, 0.0};
  json["planeBounds"] = {-kPlane_mm / 2, kPlane_mm / 2, -kPlane_mm / 2, kPlane_mm / 2};
  json["center"] = list_of(point_mm);
  json["normal"] = list_of(normal.normalized());
  json["objectToBase"] = matrix_json(Rigid::Identity());
  json["baseToNode"] =
      matrix_json(Eigen::Translation3d(point_mm) * smallest_rotation(Vec3::UnitZ(), normal.normalized()));
  return json;
}

constexpr std::array<double, 3> kBefore{0.9, 0.75, 0.4}, kAfter{0.3, 0.7, 0.9}, kReamer{0.9, 0.3, 0.3},
    kPeg{0.6, 0.4, 0.8}, kLandmark{0.4, 0.8, 0.4};

void add_planes(OrderedJson& markups, const BoneMetrics& metrics) {
  const auto add = [&](const std::string& name, const Measured<FaceAxis>& axis, const std::optional<PlaneFit>& plane,
                       const std::array<double, 3>& color) {
    if (axis.value) {
      markups.push_back(plane_markup(name, axis.value->point_mm, axis.value->direction, color));
    } else if (plane) {
      markups.push_back(plane_markup(name, plane->point_mm, plane->normal, color));
    }
  };
  const std::optional<ReamedFace>& face = metrics.face;
  const JointLine line = metrics.joint_line.value_or(JointLine{});
  add("native face", line.native, face ? face->plane_before : std::nullopt, kBefore);
  add("reamed face", line.reamed, face ? face->plane : std::nullopt, kAfter);
}

/// The entry of the first plunge or push, in B.
std::optional<Vec3> entry_of(const SimulationInput& scene) {
  const MotionSettings motion = passes_of(scene.scenario).front().motion;
  std::optional<Vec3> entry;
  if (motion.plunge) entry = motion.plunge->entry_mm;
  if (motion.push) entry = motion.push->entry_mm;
  if (!entry) return std::nullopt;
  return bone_from_frame(motion.frame, scene.bone.glenoid).value_or(Rigid::Identity()) * *entry;
}

void add_reamer(OrderedJson& markups, const SimulationInput& scene, const ToolPose& deepest) {
  const Vec3 out = deepest.orientation * Vec3::UnitZ();
  const Vec3& lowest = deepest.position_mm;
  markups.push_back(markup_json("Line", "reamer axis", {{"tip", lowest}, {"drive", lowest + kAxis_mm * out}}, kReamer));
  std::vector<LabelledPoint> points;
  if (const auto entry = entry_of(scene)) points.push_back({"entry", *entry});
  if (!scene.first_contacts.empty() && scene.first_contacts.front())
    points.push_back({"first contact", scene.first_contacts.front()->bone_mm});
  points.push_back({"deepest point", lowest});
  markups.push_back(markup_json("Fiducial", "reaming", points, kReamer));
}

void add_pegs(OrderedJson& markups, const BoneMetrics& metrics) {
  if (!metrics.planning) return;
  const Rigid& bone_from_implant = metrics.planning->bone_from_implant;
  int number = 0;
  for (const auto& [from_mm, to_mm] : metrics.planning->peg_axes_mm) {
    const std::string name = "peg " + std::to_string(++number);
    markups.push_back(
        markup_json("Line", name,
                    {{name + " from", bone_from_implant * from_mm}, {name + " to", bone_from_implant * to_mm}}, kPeg));
  }
}

void add_landmarks(OrderedJson& markups, const Bone& bone) {
  std::vector<LabelledPoint> points;
  if (const auto& marks = bone.landmarks) {
    points = {{"glenoid center", marks->glenoid_center_mm},
              {"trigonum spinae", marks->trigonum_spinae_mm},
              {"inferior angle", marks->inferior_angle_mm}};
  } else if (bone.glenoid) {
    points = {{"glenoid center", bone.glenoid->bone_from_glenoid.translation()}};
  }
  if (!points.empty()) markups.push_back(markup_json("Fiducial", "landmarks", points, kLandmark));
  std::vector<LabelledPoint> rim;
  for (const Vec3& p : bone.rim_mm) rim.push_back({"rim-" + std::to_string(rim.size() + 1), p});
  if (!rim.empty()) markups.push_back(markup_json("ClosedCurve", "glenoid rim", rim, kLandmark));
}

}  // namespace

std::string planning_markups(const SimulationInput& scene, const BoneMetrics& metrics, const ToolPose& deepest) {
  OrderedJson markups = OrderedJson::array();
  add_landmarks(markups, scene.bone);
  add_planes(markups, metrics);
  add_reamer(markups, scene, deepest);
  add_pegs(markups, metrics);
  return OrderedJson{{"@schema", kSchema}, {"markups", markups}}.dump(2) + "\n";
}

}  // namespace reamsim
