// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

#include "sim/scenario/key_visitor.h"

namespace reamsim {

namespace {

void describe_augment(KeyVisitor& v, AugmentSettings& augment) {
  v.number({.name = "angle_deg",
            .doc = "Angle of the wedge: the back is the lower of the plain back and its copy rotated by this angle",
            .required = true,
            .range = between(0.1, 60)},
           augment.angle_deg);
  v.vector({.name = "direction",
            .doc = "Direction in which the implant becomes thicker, in the frame of the implant; z is ignored",
            .range = kComponent,
            .nonzero = true},
           augment.direction);
  v.number(
      {.name = "start_mm",
       .doc = "Place of the line at which the wedge begins, along `direction` from the axis of the implant; 0: half "
              "wedge; minus the half width of the footprint: full wedge",
       .range = between(-100, 100)},
      augment.start_mm);
}

void describe_peg(KeyVisitor& v, PegSettings& peg) {
  v.vector({.name = "from_mm",
            .doc = "One end of the axis of the peg, in the frame of the implant",
            .required = true,
            .range = between(-200, 200)},
           peg.from_mm);
  v.vector({.name = "to_mm", .doc = "The other end", .required = true, .range = between(-200, 200)}, peg.to_mm);
  v.number({.name = "diameter_mm",
            .doc = "Diameter of the peg; its ends are hemispheres around from_mm and to_mm",
            .required = true,
            .range = between(0.1, 50)},
           peg.diameter_mm);
}

void describe_footprint(KeyVisitor& v, ImplantSettings& implant) {
  v.number({.name = "width_mm",
            .doc = "Width of the footprint, along x of the implant; needs height_mm; 0: see diameter_mm",
            .range = between(0, 200)},
           implant.width_mm);
  v.number({.name = "height_mm", .doc = "Height of the footprint, along y of the implant", .range = between(0, 200)},
           implant.height_mm);
  v.choice({.name = "footprint",
            .doc = "Shape of a footprint with width_mm and height_mm. pear: two circles and their common tangents, the "
                   "inferior circle of the full width, the superior one of three quarters of it"},
           implant.footprint);
}

void describe_pose(KeyVisitor& v, ImplantSettings& implant) {
  v.choice(
      {.name = "frame", .doc = "Frame of center_mm, axis and superior. reamer: the tool frame at its deepest pose"},
      implant.frame);
  v.vector({.name = "center_mm",
            .doc = "Apex of the back of the implant; with `seat` only its place across the axis counts",
            .range = kPosition,
            .point = true},
           implant.center_mm);
  v.vector({.name = "axis",
            .doc = "Axis of the implant, out of the bone: another axis than that of the reamer tilts the implant",
            .range = kComponent,
            .nonzero = true},
           implant.axis);
  v.optional_vector(
      {.name = "superior",
       .doc = "Superior direction of the implant; without it that of the glenoid, or else +y of the frame",
       .range = kComponent,
       .nonzero = true},
      implant.superior);
  v.flag({.name = "seat",
          .doc = "Translate the implant along its axis until it rests on the bone; false: it stays at center_mm"},
         implant.seat);
}

}  // namespace

void describe_implant(KeyVisitor& v, ImplantSettings& implant) {
  v.number({.name = "backside_radius_mm",
            .doc = "Radius of the spherical back of the implant; 0: flat",
            .required = true,
            .range = between(0, 500)},
           implant.backside_radius_mm);
  v.number({.name = "diameter_mm",
            .doc = "Diameter of a round footprint around the axis of the implant; with 0 and no width_mm the footprint "
                   "is the reamed face",
            .range = between(0, 200)},
           implant.diameter_mm);
  v.number({.name = "gap_mm", .doc = "Largest gap that counts as seated", .range = between(0.001, 10)}, implant.gap_mm);
  describe_footprint(v, implant);
  describe_pose(v, implant);
  v.number({.name = "thickness_mm",
            .doc = "Distance from back to articular surface along the axis, for the joint line",
            .range = between(0, 50)},
           implant.thickness_mm);
  v.number({.name = "support_depth_mm",
            .doc = "Thickness of the layer of bone under the implant whose fraction of dense bone is measured",
            .range = between(0.1, 50)},
           implant.support_depth_mm);
  v.number({.name = "vault_depth_mm",
            .doc = "Depth of the vault below the unreamed surface, over which the remaining bone is measured",
            .range = between(0.1, 200)},
           implant.vault_depth_mm);
  v.optional_section({.name = "augment", .doc = "Wedge on the back of the implant"}, implant.augment, describe_augment);
  v.list({.name = "pegs", .doc = "Pegs and keels; each is a capsule in the frame of the implant"}, implant.pegs,
         describe_peg);
}

namespace {

// So that either end may be at its limit.
constexpr Range kBegin = between(-1000, 999);
constexpr Range kEnd = between(-999, 1000);
constexpr Range kDiameter = between(0, 1000);

void describe_envelope(KeyVisitor& v, ClearanceEnvelopeSettings& envelope) {
  v.text({.name = "path",
          .doc = "STL, OBJ or PLY in the bone frame; it need not be closed",
          .required = true,
          .text = TextKind::input_file},
         envelope.path);
  v.number({.name = "scale", .doc = "File units to mm", .range = kFileUnit}, envelope.scale);
}

}  // namespace

void describe_holder_part(KeyVisitor& v, HolderPartSettings& part) {
  v.text({.name = "name", .doc = "Name in messages and results; without it holder and its number"}, part.name);
  v.number({.name = "from_z_mm",
            .doc = "Begin on the spin axis, in the tool frame; +z leads to the drive",
            .required = true,
            .range = kBegin},
           part.from_z_mm);
  v.number({.name = "to_z_mm", .doc = "End, more than from_z_mm", .required = true, .range = kEnd}, part.to_z_mm);
  v.number({.name = "diameter_mm", .doc = "Diameter at from_z_mm", .required = true, .range = between(0.01, 1000)},
           part.diameter_mm);
  v.number({.name = "end_diameter_mm", .doc = "Diameter at to_z_mm, of a cone; 0: diameter_mm", .range = kDiameter},
           part.end_diameter_mm);
}

void describe_clearance(KeyVisitor& v, ClearanceSettings& clearance) {
  v.number({.name = "least_mm",
            .doc = "Least clearance of tool.holder from bone and envelope; less is warned of",
            .range = between(0, 1000)},
           clearance.least_mm);
  v.optional_section(
      {.name = "envelope", .doc = "Surface of soft tissue, from which tool.holder is kept clear as well"},
      clearance.envelope, describe_envelope);
}

}  // namespace reamsim
