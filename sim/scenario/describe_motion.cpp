// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

namespace reamsim {

namespace {

constexpr Range kSpin = between(-20000, 20000);
constexpr Range kFeed = between(1e-4, 1000);  // mm/s

void describe_plunge(KeyVisitor& v, PlungeSettings& plunge) {
  v.point("entry_mm", plunge.entry_mm,
          "A point of the line of the plunge, through which the origin of the tool passes");
  v.direction("axis", plunge.axis, "Direction of the feed; the opposite of +z of the tool");
  v.key("from", plunge.from,
        "Where the depth begins. entry: at entry_mm. contact: where the envelope of the tool, coming along axis from "
        "outside the bone, first touches the bone as it is before the run");
  v.key("approach_mm", plunge.approach_mm, "Distance before the point where the depth begins", between(0, 500));
  v.key("feed_mm_s", plunge.feed_mm_s, "Feed rate", kFeed);
  v.key("depth_mm", plunge.depth_mm, "Distance beyond the point where the depth begins", between(0, 500));
  v.key("dwell_s", plunge.dwell_s, "Time at full depth", between(0, 3600));
  v.key("retract_mm", plunge.retract_mm, "Retraction distance", between(0, 1000));
  v.key("retract_mm_s", plunge.retract_mm_s, "Retraction speed", kFeed);
  v.key("spin_rpm", plunge.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
}

void describe_push(KeyVisitor& v, PushSettings& push) {
  v.point("entry_mm", push.entry_mm, "A point of the line of the push, through which the origin of the tool passes");
  v.direction("axis", push.axis, "Direction of the push; the opposite of +z of the tool");
  v.key("from", push.from, "Where the depth begins, as for a plunge");
  v.key("approach_mm", push.approach_mm, "Distance before the point where the depth begins", between(0, 500));
  v.key("thrust_n", push.thrust_n, "Thrust along axis, N", between(1e-3, 10000));
  v.key("profile", push.profile,
        "CSV of the thrust over time, with the columns time_s and thrust_n; it replaces thrust_n",
        {.text = TextKind::input_file});
  v.key("max_feed_mm_s", push.max_feed_mm_s, "Greatest feed rate, also in air and after breakthrough", kFeed);
  v.key("spin_rpm", push.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
  v.key("until", push.until,
        "What ends the push. depth: depth_mm. time: time_s. stall: the tool stands still in the bone. time_s ends it "
        "in any case");
  v.key("depth_mm", push.depth_mm,
        "With until: depth, the distance beyond the point where the depth begins; else it only spaces the pictures",
        between(1e-3, 500));
  v.key("time_s", push.time_s, "The longest duration", between(1e-3, 36000));
  v.key("mass_kg", push.mass_kg, "Mass of handpiece and arm that moves with the tool; 0: forces balance in every frame",
        between(0, 100));
  v.key("damping_n_s_mm", push.damping_n_s_mm, "Damping force against the feed, per feed", between(0, 1000));
}

void describe_compliance(KeyVisitor& v, ComplianceSettings& compliance) {
  v.key("stiffness_n_mm", compliance.stiffness_n_mm,
        "Stiffness in the directions x, y and z of the tool; 1e6 is rigid: no deflection in that direction",
        {.required = true, .range = between(1e-3, ComplianceSettings::kRigid_n_mm)});
  v.key("damping_n_s_mm", compliance.damping_n_s_mm,
        "Force of a damper beside each spring, per speed of the deflection", between(0, 1000));
}

void describe_keyframe(KeyVisitor& v, KeyframeSettings& key) {
  v.key("time_s", key.time_s, "Time; later than that of the previous keyframe",
        {.required = true, .range = between(0, 1e5)});
  v.point("position_mm", key.position_mm, "Origin of the tool", {.required = true});
  v.direction("axis", key.axis, "+z of the tool: out of the bone, towards the drive");
  v.key("quaternion", key.quaternion, "Rotation from tool to motion.frame: unit quaternion w, x, y, z",
        between(-1.01, 1.01));
  v.group({.names = {"axis", "quaternion"}});
  v.key("spin_rpm", key.spin_rpm, "Spindle speed, positive clockwise seen from the drive", kSpin);
}

void describe_pass(KeyVisitor& v, PassSettings& pass) {
  v.section("tool", pass.tool, describe_tool, "Tool of this pass; without it the section `tool`");
  v.section("plunge", pass.plunge, describe_plunge, "Motion of this pass");
}

void describe_transform(KeyVisitor& v, TransformSettings& transform) {
  v.key("translation_mm", transform.translation_mm, "Added after the rotation", kPosition);
  v.key("quaternion", transform.quaternion, "Rotation: unit quaternion w, x, y, z; without it and rotation: none",
        between(-1.01, 1.01));
  v.key("rotation", transform.rotation, "Rotation: the three rows of its matrix",
        {.range = between(-1.001, 1.001), .least_points = 3});
  v.group({.names = {"quaternion", "rotation"}, .one_needed = false});
}

void describe_csv(KeyVisitor& v, CsvMotionSettings& csv) {
  v.key("path", csv.path,
        "Recorded poses, a row each. Without further keys: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally spin_rpm",
        {.required = true, .text = TextKind::input_file});
  v.key("format", csv.format,
        "csv: columns with a header or numbers. tum: `t tx ty tz qx qy qz qw` between blanks, s and m");
  v.defaults([&csv] { apply_format_defaults(csv); });
  v.key("separator", csv.separator, "What separates columns; space: any blanks", {.default_by = "format"});
  v.key("decimal", csv.decimal, "Decimal mark of numbers");
  v.key("skip_lines", csv.skip_lines, "Lines before the header that are skipped. Lines that begin with # always are",
        between(0, 10000));
  v.key("time_column", csv.time_column, "Column of the time: its name in the header, or its number from 1",
        {.number_too = true, .default_by = "format"});
  v.key("time_unit", csv.time_unit, "Unit of the time");
  v.key("position_columns", csv.position_columns, "The three columns of the position of the tool, by name or number",
        {.default_by = "format"});
  v.key("position_unit", csv.position_unit, "Unit of the position", {.default_by = "format"});
  v.key("quaternion_columns", csv.quaternion_columns,
        "The four columns of the rotation from the tool, by name or number, in the order quaternion_order",
        {.default_by = "format"});
  v.key("quaternion_order", csv.quaternion_order,
        "Whether quaternion_columns begin with the real part, w, or end with it", {.default_by = "format"});
  v.key("spin_column", csv.spin_column,
        "Column of the spindle speed, rpm, by name or number; a file without it has spin_rpm", {.number_too = true});
  v.key("max_gap_s", csv.max_gap_s,
        "Longest time without a pose; a longer one is an input error, and rows without a pose (empty, nan, missing) "
        "are skipped. 0: any time between rows, and each has a pose",
        between(0, 3600));
  v.section("bone_from_tracker", csv.bone_from_tracker, describe_transform,
            "Registration: from the frame of the recording to that of the bone");
  v.section("marker_from_tool", csv.marker_from_tool, describe_transform,
            "Calibration: from the tool to the recorded marker that is fixed to it");
  v.key("spin_rpm", csv.spin_rpm, "Spindle speed if the file has no such column", kSpin);
}

// So that either end may be at its limit.
constexpr Range kBegin = between(-1000, 999);
constexpr Range kEnd = between(-999, 1000);
constexpr Range kDiameter = between(0, 1000);

void describe_envelope(KeyVisitor& v, ClearanceEnvelopeSettings& envelope) {
  v.key("path", envelope.path, "STL, OBJ or PLY in the bone frame; it need not be closed",
        {.required = true, .text = TextKind::input_file});
  v.key("scale", envelope.scale, "File units to mm", kFileUnit);
}

void describe_holder_part(KeyVisitor& v, HolderPartSettings& part) {
  v.key("name", part.name, "Name in messages and results; without it holder and its number");
  v.key("from_z_mm", part.from_z_mm, "Begin on the spin axis, in the tool frame; +z leads to the drive",
        {.required = true, .range = kBegin});
  v.key("to_z_mm", part.to_z_mm, "End, more than from_z_mm", {.required = true, .range = kEnd});
  v.key("diameter_mm", part.diameter_mm, "Diameter at from_z_mm", {.required = true, .range = between(0.01, 1000)});
  v.key("end_diameter_mm", part.end_diameter_mm, "Diameter at to_z_mm, of a cone; 0: diameter_mm", kDiameter);
}

}  // namespace

void describe_tool(KeyVisitor& v, ToolSettings& tool) {
  v.key("mesh", tool.mesh, "STL, OBJ or PLY in the tool frame", {.required = true, .text = TextKind::input_file});
  v.key("scale", tool.scale, "File units to mm", kFileUnit);
  v.key("shell_resolution", tool.shell_resolution,
        "M of the M³ grid whose cells sample the surface; 0: a spacing of 0.47 voxel, which leaves no voxel behind. "
        "Not used with erosion exact and the detector implicit, which use the surface itself",
        between(0, 4096));
  v.key("spin", tool.spin,
        "envelope: the envelope of revolution of the reamer; resolved: the rotating cutting edges themselves");
  v.list("holder", tool.holder, describe_holder_part,
         "Parts of shaft and holder, stacked cylinders and cones about the spin axis. They do not cut; their clearance "
         "from the bone is reported");
}

void describe_motion(KeyVisitor& v, MotionSettings& motion) {
  v.key("frame", motion.frame, "Frame of all positions and directions of the motion");
  v.key("frame_rate_hz", motion.frame_rate_hz, "Frames per second; 1000 is the haptic rate", between(1, 100000));
  v.section("plunge", motion.plunge, describe_plunge, "Straight motion in, dwell, straight motion out");
  v.section("push", motion.push, describe_push,
            "A thrust moves the tool along a line; the feed follows from the balance of forces in every frame. Needs "
            "erosion exact");
  v.list("passes", motion.passes, describe_pass,
         "Plunges one after another on the same bone, each with a tool of its own: reaming in increasing sizes. The "
         "change of tools takes no time");
  v.list("keyframes", motion.keyframes, describe_keyframe,
         "Two or more poses; position and spindle speed are interpolated linearly, orientation spherically");
  v.section("csv", motion.csv, describe_csv, "Poses from a file");
  v.group({.names = {"plunge", "push", "passes", "keyframes", "csv"}});
  v.section("compliance", motion.compliance, describe_compliance,
            "Springs between the planned pose and the tool, which the force of the bone deflects; not for push. Needs "
            "erosion exact");
}

void describe_clearance(KeyVisitor& v, ClearanceSettings& clearance) {
  v.key("least_mm", clearance.least_mm, "Least clearance of tool.holder from bone and envelope; less is warned of",
        between(0, 1000));
  v.section("envelope", clearance.envelope, describe_envelope,
            "Surface of soft tissue, from which tool.holder is kept clear as well");
}

}  // namespace reamsim
