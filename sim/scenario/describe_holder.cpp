// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

namespace reamsim {

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
