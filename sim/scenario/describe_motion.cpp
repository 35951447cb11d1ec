// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

namespace reamsim {

namespace {

constexpr Range kSpin = between(-20000, 20000);
constexpr Range kFeed = between(1e-4, 1000);  // mm/s

void describe_plunge(KeyVisitor& v, PlungeSettings& plunge) {
  v.point("entry_mm", plunge.entry_mm, "Point on the path of the tool origin");
  v.direction("axis", plunge.axis, "Feed direction; -z of the tool");
  v.key("from", plunge.from,
        "Zero of the depth. entry: entry_mm; contact: first contact of the tool envelope, moving along axis from "
        "outside, with the bone before the run");
  v.key("approach_mm", plunge.approach_mm, "Start distance before zero depth", between(0, 500));
  v.key("feed_mm_s", plunge.feed_mm_s, "Feed rate", kFeed);
  v.key("depth_mm", plunge.depth_mm, "Full depth", between(0, 500));
  v.key("dwell_s", plunge.dwell_s, "Time at full depth", between(0, 3600));
  v.key("retract_mm", plunge.retract_mm, "Retraction distance", between(0, 1000));
  v.key("retract_mm_s", plunge.retract_mm_s, "Retraction speed", kFeed);
  v.key("spin_rpm", plunge.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
}

void describe_push(KeyVisitor& v, PushSettings& push) {
  v.point("entry_mm", push.entry_mm, "Point on the path of the tool origin");
  v.direction("axis", push.axis, "Feed direction; -z of the tool");
  v.key("from", push.from, "As for plunge");
  v.key("approach_mm", push.approach_mm, "Start distance before zero depth", between(0, 500));
  v.key("thrust_n", push.thrust_n, "Thrust along axis", between(1e-3, 10000));
  v.key("profile", push.profile, "CSV with columns time_s and thrust_n; replaces thrust_n",
        {.text = TextKind::input_file});
  v.key("max_feed_mm_s", push.max_feed_mm_s, "Upper limit of the feed rate, also in air and after breakthrough", kFeed);
  v.key("spin_rpm", push.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
  v.key("until", push.until, "End of the push: depth_mm, time_s or a stall in the bone; time_s in any case");
  v.key("depth_mm", push.depth_mm, "Full depth with `until: depth`; else it only spaces the pictures",
        between(1e-3, 500));
  v.key("time_s", push.time_s, "Longest duration", between(1e-3, 36000));
  v.key("mass_kg", push.mass_kg, "Moving mass of handpiece and arm; 0: forces balance in every frame", between(0, 100));
  v.key("damping_n_s_mm", push.damping_n_s_mm, "Damping force per feed rate", between(0, 1000));
}

void describe_compliance(KeyVisitor& v, ComplianceSettings& compliance) {
  v.key("stiffness_n_mm", compliance.stiffness_n_mm, "Stiffness along x, y and z of the tool; 1e6: rigid",
        required(between(1e-3, ComplianceSettings::kRigid_n_mm)));
  v.key("damping_n_s_mm", compliance.damping_n_s_mm, "Damper parallel to each spring: force per deflection rate",
        between(0, 1000));
}

void describe_keyframe(KeyVisitor& v, KeyframeSettings& key) {
  v.key("time_s", key.time_s, "Later than the previous keyframe", required(between(0, 1e5)));
  v.point("position_mm", key.position_mm, "Tool origin", {.required = true});
  v.direction("axis", key.axis, "+z of the tool, out of the bone");
  v.key("quaternion", key.quaternion, "Rotation from tool to motion.frame: unit quaternion w, x, y, z",
        between(-1.01, 1.01));
  v.group({.names = {"axis", "quaternion"}});
  v.key("spin_rpm", key.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
}

void describe_pass(KeyVisitor& v, PassSettings& pass) {
  v.section("tool", pass.tool, describe_tool, "Tool of this pass; default: `tool`");
  v.section("plunge", pass.plunge, describe_plunge, "Motion of this pass");
}

void describe_transform(KeyVisitor& v, TransformSettings& transform) {
  v.key("translation_mm", transform.translation_mm, "Added after the rotation", kPosition);
  v.key("quaternion", transform.quaternion, "Unit quaternion w, x, y, z; default: no rotation", between(-1.01, 1.01));
  v.key("rotation", transform.rotation, "Three rows of the rotation matrix",
        {.range = between(-1.001, 1.001), .least_points = 3});
  v.group({.names = {"quaternion", "rotation"}, .one_needed = false});
}

void describe_csv(KeyVisitor& v, CsvMotionSettings& csv) {
  v.key("path", csv.path,
        "Recorded poses, one per row. Default columns: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally spin_rpm",
        {.required = true, .text = TextKind::input_file});
  v.key("format", csv.format,
        "csv: columns with a header or by number; tum: `t tx ty tz qx qy qz qw`, separated by blanks, s and m");
  v.defaults([&csv] { apply_format_defaults(csv); });
  v.key("separator", csv.separator, "Column separator; space: any blanks", {.default_by = "format"});
  v.key("decimal", csv.decimal, "Decimal mark");
  v.key("skip_lines", csv.skip_lines, "Lines skipped before the header; lines that begin with # always are",
        between(0, 10000));
  v.key("time_column", csv.time_column, "Time column: header name, or number from 1",
        {.number_too = true, .default_by = "format"});
  v.key("time_unit", csv.time_unit, "Time unit");
  v.key("position_columns", csv.position_columns, "Three tool position columns, by name or number",
        {.default_by = "format"});
  v.key("position_unit", csv.position_unit, "Position unit", {.default_by = "format"});
  v.key("quaternion_columns", csv.quaternion_columns,
        "Four columns of the rotation from the tool, by name or number, in quaternion_order", {.default_by = "format"});
  v.key("quaternion_order", csv.quaternion_order, "Real part w first or last", {.default_by = "format"});
  v.key("spin_column", csv.spin_column, "Spindle speed column (rpm), by name or number; without it spin_rpm applies",
        {.number_too = true});
  v.key("max_gap_s", csv.max_gap_s,
        "Longest gap between poses; a longer one is an error, and rows without a pose (empty, nan, missing) are "
        "skipped. 0: any gap, but every row needs a pose",
        between(0, 3600));
  v.section("bone_from_tracker", csv.bone_from_tracker, describe_transform,
            "Registration: recording frame to bone frame");
  v.section("marker_from_tool", csv.marker_from_tool, describe_transform,
            "Calibration: tool frame to the recorded marker fixed to it");
  v.key("spin_rpm", csv.spin_rpm, "Spindle speed without spin_column", kSpin);
}

// So that either end may be at its limit.
constexpr Range kBegin = between(-1000, 999);
constexpr Range kEnd = between(-999, 1000);
constexpr Range kDiameter = between(0, 1000);

void describe_envelope(KeyVisitor& v, ClearanceEnvelopeSettings& envelope) {
  v.key("path", envelope.path, "STL, OBJ, PLY or VTP in the bone frame; may be open",
        {.required = true, .text = TextKind::input_file});
  v.key("scale", envelope.scale, "mm per file unit", kFileUnit);
}

void describe_holder_part(KeyVisitor& v, HolderPartSettings& part) {
  v.key("name", part.name, "Name in messages and results; default: holder and its number");
  v.key("from_z_mm", part.from_z_mm, "Start on the spin axis, tool frame; +z points to the drive", required(kBegin));
  v.key("to_z_mm", part.to_z_mm, "End; greater than from_z_mm", required(kEnd));
  v.key("diameter_mm", part.diameter_mm, "Diameter at from_z_mm", required(between(0.01, 1000)));
  v.key("end_diameter_mm", part.end_diameter_mm, "Diameter at to_z_mm; 0: diameter_mm", kDiameter);
}

}  // namespace

void describe_tool(KeyVisitor& v, ToolSettings& tool) {
  v.key("mesh", tool.mesh, "STL, OBJ, PLY or VTP in the tool frame", {.required = true, .text = TextKind::input_file});
  v.key("scale", tool.scale, "mm per file unit", kFileUnit);
  v.key("shell_resolution", tool.shell_resolution,
        "M of the M³ grid that samples the surface; 0: spacing of 0.47 voxel, which misses no voxel. Not used by "
        "erosion exact and engine.type implicit",
        between(0, 4096));
  v.key("spin", tool.spin, "envelope: envelope of revolution; resolved: the rotating cutting edges");
  v.list("holder", tool.holder, describe_holder_part,
         "Shaft and holder: stacked cylinders and cones about the spin axis. They do not cut; their clearance from "
         "bone is reported");
}

void describe_motion(KeyVisitor& v, MotionSettings& motion) {
  v.key("frame", motion.frame, "Frame of positions and directions");
  v.key("frame_rate_hz", motion.frame_rate_hz, "Frame rate; 1000 is the haptic rate", between(1, 100000));
  v.section("plunge", motion.plunge, describe_plunge, "Straight feed, dwell, retraction");
  v.section("push", motion.push, describe_push,
            "Thrust moves the tool along a line; force balance sets the feed in every frame. Needs erosion exact");
  v.list("passes", motion.passes, describe_pass,
         "Successive plunges into the same bone, each with its own tool: reaming in increasing sizes. Tool changes "
         "take no time");
  v.list("keyframes", motion.keyframes, describe_keyframe,
         "Two or more poses; position and spindle speed interpolated linearly, orientation spherically");
  v.section("csv", motion.csv, describe_csv, "Poses from a file");
  v.group({.names = {"plunge", "push", "passes", "keyframes", "csv"}});
  v.section(
      "compliance", motion.compliance, describe_compliance,
      "Springs between planned pose and tool, deflected by the force of the bone; not for push. Needs erosion exact");
}

void describe_clearance(KeyVisitor& v, ClearanceSettings& clearance) {
  v.key("least_mm", clearance.least_mm, "Least clearance from bone and envelope; less causes a warning",
        between(0, 1000));
  v.section("envelope", clearance.envelope, describe_envelope,
            "Soft-tissue surface to which clearance is measured too");
}

}  // namespace reamsim
