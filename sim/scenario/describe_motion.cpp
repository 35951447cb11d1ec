// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

namespace reamsim {

namespace {

constexpr Range kSpin = between(-20000, 20000);
constexpr Range kFeed = between(1e-4, 1000);  // mm/s

void describe_plunge(KeyVisitor& v, PlungeSettings& plunge) {
  v.vector({.name = "entry_mm",
            .doc = "A point of the line of the plunge, through which the origin of the tool passes",
            .range = kPosition,
            .point = true},
           plunge.entry_mm);
  v.vector({.name = "axis",
            .doc = "Direction of the feed; the opposite of +z of the tool",
            .range = kComponent,
            .nonzero = true},
           plunge.axis);
  v.choice({.name = "from",
            .doc = "Where the depth begins. entry: at entry_mm. contact: where the envelope of the tool, coming along "
                   "axis from outside the bone, first touches the bone as it is before the run"},
           plunge.from);
  v.number({.name = "approach_mm", .doc = "Distance before the point where the depth begins", .range = between(0, 500)},
           plunge.approach_mm);
  v.number({.name = "feed_mm_s", .doc = "Feed rate", .range = kFeed}, plunge.feed_mm_s);
  v.number({.name = "depth_mm", .doc = "Distance beyond the point where the depth begins", .range = between(0, 500)},
           plunge.depth_mm);
  v.number({.name = "dwell_s", .doc = "Time at full depth", .range = between(0, 3600)}, plunge.dwell_s);
  v.number({.name = "retract_mm", .doc = "Retraction distance", .range = between(0, 1000)}, plunge.retract_mm);
  v.number({.name = "retract_mm_s", .doc = "Retraction speed", .range = kFeed}, plunge.retract_mm_s);
  v.number({.name = "spin_rpm", .doc = "Spindle speed, positive clockwise seen from the drive", .range = kSpin},
           plunge.spin_rpm);
}

void describe_push(KeyVisitor& v, PushSettings& push) {
  v.vector({.name = "entry_mm",
            .doc = "A point of the line of the push, through which the origin of the tool passes",
            .range = kPosition,
            .point = true},
           push.entry_mm);
  v.vector({.name = "axis",
            .doc = "Direction of the push; the opposite of +z of the tool",
            .range = kComponent,
            .nonzero = true},
           push.axis);
  v.choice({.name = "from", .doc = "Where the depth begins, as for a plunge"}, push.from);
  v.number({.name = "approach_mm", .doc = "Distance before the point where the depth begins", .range = between(0, 500)},
           push.approach_mm);
  v.number({.name = "thrust_n", .doc = "Thrust along axis, N", .range = between(1e-3, 10000)}, push.thrust_n);
  v.text({.name = "profile",
          .doc = "CSV of the thrust over time, with the columns time_s and thrust_n; it replaces thrust_n",
          .text = TextKind::input_file},
         push.profile);
  v.number({.name = "max_feed_mm_s", .doc = "Greatest feed rate, also in air and after breakthrough", .range = kFeed},
           push.max_feed_mm_s);
  v.number({.name = "spin_rpm", .doc = "Spindle speed, positive clockwise seen from the drive", .range = kSpin},
           push.spin_rpm);
  v.choice(
      {.name = "until",
       .doc = "What ends the push. depth: depth_mm. time: time_s. stall: the tool stands still in the bone. time_s "
              "ends it in any case"},
      push.until);
  v.number({.name = "depth_mm",
            .doc = "With until: depth, the distance beyond the point where the depth begins; else it only spaces the "
                   "pictures",
            .range = between(1e-3, 500)},
           push.depth_mm);
  v.number({.name = "time_s", .doc = "The longest duration", .range = between(1e-3, 36000)}, push.time_s);
  v.number({.name = "mass_kg",
            .doc = "Mass of handpiece and arm that moves with the tool; 0: forces balance in every frame",
            .range = between(0, 100)},
           push.mass_kg);
  v.number({.name = "damping_n_s_mm", .doc = "Damping force against the feed, per feed", .range = between(0, 1000)},
           push.damping_n_s_mm);
}

void describe_compliance(KeyVisitor& v, ComplianceSettings& compliance) {
  v.vector({.name = "stiffness_n_mm",
            .doc = "Stiffness in the directions x, y and z of the tool; 1e6 is rigid: no deflection in that direction",
            .required = true,
            .range = between(1e-3, ComplianceSettings::kRigid_n_mm)},
           compliance.stiffness_n_mm);
  v.number({.name = "damping_n_s_mm",
            .doc = "Force of a damper beside each spring, per speed of the deflection",
            .range = between(0, 1000)},
           compliance.damping_n_s_mm);
}

void describe_keyframe(KeyVisitor& v, KeyframeSettings& key) {
  v.number({.name = "time_s",
            .doc = "Time; later than that of the previous keyframe",
            .required = true,
            .range = between(0, 1e5)},
           key.time_s);
  v.vector({.name = "position_mm", .doc = "Origin of the tool", .required = true, .range = kPosition, .point = true},
           key.position_mm);
  v.optional_vector({.name = "axis",
                     .doc = "+z of the tool: out of the bone, towards the drive",
                     .range = kComponent,
                     .nonzero = true},
                    key.axis);
  v.optional_quaternion({.name = "quaternion",
                         .doc = "Rotation from tool to motion.frame: unit quaternion w, x, y, z",
                         .range = between(-1.01, 1.01)},
                        key.quaternion);
  v.group({.names = {"axis", "quaternion"}});
  v.number({.name = "spin_rpm", .doc = "Spindle speed, positive clockwise seen from the drive", .range = kSpin},
           key.spin_rpm);
}

void describe_pass(KeyVisitor& v, PassSettings& pass) {
  v.optional_section({.name = "tool", .doc = "Tool of this pass; without it the section `tool`"}, pass.tool,
                     describe_tool);
  v.section({.name = "plunge", .doc = "Motion of this pass"}, pass.plunge, describe_plunge);
}

void describe_transform(KeyVisitor& v, TransformSettings& transform) {
  v.vector({.name = "translation_mm", .doc = "Added after the rotation", .range = kPosition}, transform.translation_mm);
  v.optional_quaternion({.name = "quaternion",
                         .doc = "Rotation: unit quaternion w, x, y, z; without it and rotation: none",
                         .range = between(-1.01, 1.01)},
                        transform.quaternion);
  v.points({.name = "rotation",
            .doc = "Rotation: the three rows of its matrix",
            .range = between(-1.001, 1.001),
            .least_points = 3},
           transform.rotation);
  v.group({.names = {"quaternion", "rotation"}, .one_needed = false});
}

void describe_columns(KeyVisitor& v, CsvMotionSettings& csv) {
  v.text({.name = "time_column",
          .doc = "Column of the time: its name in the header, or its number from 1",
          .number_too = true,
          .default_by = "format"},
         csv.time_column);
  v.choice({.name = "time_unit", .doc = "Unit of the time"}, csv.time_unit);
  v.names({.name = "position_columns",
           .doc = "The three columns of the position of the tool, by name or number",
           .default_by = "format"},
          csv.position_columns);
  v.choice({.name = "position_unit", .doc = "Unit of the position", .default_by = "format"}, csv.position_unit);
  v.names({.name = "quaternion_columns",
           .doc = "The four columns of the rotation from the tool, by name or number, in the order quaternion_order",
           .default_by = "format"},
          csv.quaternion_columns);
  v.choice({.name = "quaternion_order",
            .doc = "Whether quaternion_columns begin with the real part, w, or end with it",
            .default_by = "format"},
           csv.quaternion_order);
  v.text({.name = "spin_column",
          .doc = "Column of the spindle speed, rpm, by name or number; a file without it has spin_rpm",
          .number_too = true},
         csv.spin_column);
}

void describe_csv(KeyVisitor& v, CsvMotionSettings& csv) {
  v.text({.name = "path",
          .doc = "Recorded poses, a row each. Without further keys: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally "
                 "spin_rpm",
          .required = true,
          .text = TextKind::input_file},
         csv.path);
  v.choice({.name = "format",
            .doc = "csv: columns with a header or numbers. tum: `t tx ty tz qx qy qz qw` between blanks, s and m"},
           csv.format);
  v.defaults([&csv] { apply_format_defaults(csv); });
  v.choice({.name = "separator", .doc = "What separates columns; space: any blanks", .default_by = "format"},
           csv.separator);
  v.choice({.name = "decimal", .doc = "Decimal mark of numbers"}, csv.decimal);
  v.integer({.name = "skip_lines",
             .doc = "Lines before the header that are skipped. Lines that begin with # always are",
             .range = between(0, 10000)},
            csv.skip_lines);
  describe_columns(v, csv);
  v.number({.name = "max_gap_s",
            .doc = "Longest time without a pose; a longer one is an input error, and rows without a pose (empty, nan, "
                   "missing) are skipped. 0: any time between rows, and each has a pose",
            .range = between(0, 3600)},
           csv.max_gap_s);
  v.optional_section(
      {.name = "bone_from_tracker", .doc = "Registration: from the frame of the recording to that of the bone"},
      csv.bone_from_tracker, describe_transform);
  v.optional_section(
      {.name = "marker_from_tool", .doc = "Calibration: from the tool to the recorded marker that is fixed to it"},
      csv.marker_from_tool, describe_transform);
  v.number({.name = "spin_rpm", .doc = "Spindle speed if the file has no such column", .range = kSpin}, csv.spin_rpm);
}

}  // namespace

void describe_tool(KeyVisitor& v, ToolSettings& tool) {
  v.text({.name = "mesh", .doc = "STL, OBJ or PLY in the tool frame", .required = true, .text = TextKind::input_file},
         tool.mesh);
  v.number({.name = "scale", .doc = "File units to mm", .range = kFileUnit}, tool.scale);
  v.integer({.name = "shell_resolution",
             .doc = "M of the M³ grid whose cells sample the surface; 0: a spacing of 0.47 voxel, which leaves no "
                    "voxel behind. Not used with erosion exact and the detector implicit, which use the surface itself",
             .range = between(0, 4096)},
            tool.shell_resolution);
  v.choice(
      {.name = "spin",
       .doc = "envelope: the envelope of revolution of the reamer; resolved: the rotating cutting edges themselves"},
      tool.spin);
  v.list({.name = "holder",
          .doc = "Parts of shaft and holder, stacked cylinders and cones about the spin axis. They do not cut; their "
                 "clearance from the bone is reported"},
         tool.holder, describe_holder_part);
}

void describe_motion(KeyVisitor& v, MotionSettings& motion) {
  v.choice({.name = "frame", .doc = "Frame of all positions and directions of the motion"}, motion.frame);
  v.number({.name = "frame_rate_hz", .doc = "Frames per second; 1000 is the haptic rate", .range = between(1, 100000)},
           motion.frame_rate_hz);
  v.optional_section({.name = "plunge", .doc = "Straight motion in, dwell, straight motion out"}, motion.plunge,
                     describe_plunge);
  v.optional_section(
      {.name = "push",
       .doc = "A thrust moves the tool along a line; the feed follows from the balance of forces in every "
              "frame. Needs erosion exact"},
      motion.push, describe_push);
  v.list(
      {.name = "passes",
       .doc = "Plunges one after another on the same bone, each with a tool of its own: reaming in increasing sizes. "
              "The change of tools takes no time"},
      motion.passes, describe_pass);
  v.list({.name = "keyframes",
          .doc = "Two or more poses; position and spindle speed are interpolated linearly, orientation spherically"},
         motion.keyframes, describe_keyframe);
  v.optional_section({.name = "csv", .doc = "Poses from a file"}, motion.csv, describe_csv);
  v.group({.names = {"plunge", "push", "passes", "keyframes", "csv"}});
  v.optional_section(
      {.name = "compliance",
       .doc =
           "Springs between the planned pose and the tool, which the force of the bone deflects; not for push. Needs "
           "erosion exact"},
      motion.compliance, describe_compliance);
}

}  // namespace reamsim
