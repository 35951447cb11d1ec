// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

#include "sim/scenario/key_visitor.h"

namespace reamsim {

namespace {

void describe_augment(KeyVisitor& v, AugmentSettings& augment) {
  v.key("angle_deg", augment.angle_deg,
        "Angle of the wedge: the back is the lower of the plain back and its copy rotated by this angle",
        {.required = true, .range = between(0.1, 60)});
  v.direction("direction", augment.direction,
              "Direction in which the implant becomes thicker, in the frame of the implant; z is ignored");
  v.key("start_mm", augment.start_mm,
        "Place of the line at which the wedge begins, along `direction` from the axis of the implant; 0: half wedge; "
        "minus the half width of the footprint: full wedge",
        between(-100, 100));
}

void describe_peg(KeyVisitor& v, PegSettings& peg) {
  v.key("from_mm", peg.from_mm, "One end of the axis of the peg, in the frame of the implant",
        {.required = true, .range = between(-200, 200)});
  v.key("to_mm", peg.to_mm, "The other end", {.required = true, .range = between(-200, 200)});
  v.key("diameter_mm", peg.diameter_mm, "Diameter of the peg; its ends are hemispheres around from_mm and to_mm",
        {.required = true, .range = between(0.1, 50)});
}

void describe_footprint(KeyVisitor& v, ImplantSettings& implant) {
  v.key("width_mm", implant.width_mm,
        "Width of the footprint, along x of the implant; needs height_mm; 0: see diameter_mm", between(0, 200));
  v.key("height_mm", implant.height_mm, "Height of the footprint, along y of the implant", between(0, 200));
  v.key("footprint", implant.footprint,
        "Shape of a footprint with width_mm and height_mm. pear: two circles and their common tangents, the inferior "
        "circle of the full width, the superior one of three quarters of it");
}

void describe_pose(KeyVisitor& v, ImplantSettings& implant) {
  v.key("frame", implant.frame, "Frame of center_mm, axis and superior. reamer: the tool frame at its deepest pose");
  v.point("center_mm", implant.center_mm,
          "Apex of the back of the implant; with `seat` only its place across the axis counts");
  v.direction("axis", implant.axis,
              "Axis of the implant, out of the bone: another axis than that of the reamer tilts the implant");
  v.direction("superior", implant.superior,
              "Superior direction of the implant; without it that of the glenoid, or else +y of the frame");
  v.key("seat", implant.seat,
        "Translate the implant along its axis until it rests on the bone; false: it stays at center_mm");
}

}  // namespace

void describe_implant(KeyVisitor& v, ImplantSettings& implant) {
  v.key("backside_radius_mm", implant.backside_radius_mm, "Radius of the spherical back of the implant; 0: flat",
        {.required = true, .range = between(0, 500)});
  v.key("diameter_mm", implant.diameter_mm,
        "Diameter of a round footprint around the axis of the implant; with 0 and no width_mm the footprint is the "
        "reamed face",
        between(0, 200));
  v.key("gap_mm", implant.gap_mm, "Largest gap that counts as seated", between(0.001, 10));
  describe_footprint(v, implant);
  describe_pose(v, implant);
  v.key("thickness_mm", implant.thickness_mm,
        "Distance from back to articular surface along the axis, for the joint line", between(0, 50));
  v.key("support_depth_mm", implant.support_depth_mm,
        "Thickness of the layer of bone under the implant whose fraction of dense bone is measured", between(0.1, 50));
  v.key("vault_depth_mm", implant.vault_depth_mm,
        "Depth of the vault below the unreamed surface, over which the remaining bone is measured", between(0.1, 200));
  v.section("augment", implant.augment, describe_augment, "Wedge on the back of the implant");
  v.list("pegs", implant.pegs, describe_peg, "Pegs and keels; each is a capsule in the frame of the implant");
}

namespace {

// So that either end may be at its limit.
constexpr Range kBegin = between(-1000, 999);
constexpr Range kEnd = between(-999, 1000);
constexpr Range kDiameter = between(0, 1000);

void describe_envelope(KeyVisitor& v, ClearanceEnvelopeSettings& envelope) {
  v.key("path", envelope.path, "STL, OBJ or PLY in the bone frame; it need not be closed",
        {.required = true, .text = TextKind::input_file});
  v.key("scale", envelope.scale, "File units to mm", kFileUnit);
}

}  // namespace

void describe_holder_part(KeyVisitor& v, HolderPartSettings& part) {
  v.key("name", part.name, "Name in messages and results; without it holder and its number");
  v.key("from_z_mm", part.from_z_mm, "Begin on the spin axis, in the tool frame; +z leads to the drive",
        {.required = true, .range = kBegin});
  v.key("to_z_mm", part.to_z_mm, "End, more than from_z_mm", {.required = true, .range = kEnd});
  v.key("diameter_mm", part.diameter_mm, "Diameter at from_z_mm", {.required = true, .range = between(0.01, 1000)});
  v.key("end_diameter_mm", part.end_diameter_mm, "Diameter at to_z_mm, of a cone; 0: diameter_mm", kDiameter);
}

void describe_clearance(KeyVisitor& v, ClearanceSettings& clearance) {
  v.key("least_mm", clearance.least_mm, "Least clearance of tool.holder from bone and envelope; less is warned of",
        between(0, 1000));
  v.section("envelope", clearance.envelope, describe_envelope,
            "Surface of soft tissue, from which tool.holder is kept clear as well");
}

}  // namespace reamsim
