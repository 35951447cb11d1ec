// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

namespace {

constexpr Range kChip = between(1e-5, 10);  // mm

void describe_cutting_edges(KeyVisitor& v, int& count) {
  v.integer({.name = "cutting_edges", .doc = "Number of cutting edges", .required = true, .range = between(1, 1000)},
            count);
}

void describe_specific_energy(KeyVisitor& v, SpecificEnergySettings& point) {
  v.number({.name = "density_g_cm3", .doc = "Apparent density", .required = true, .range = between(0, 2)},
           point.density_g_cm3);
  v.number({.name = "energy_j_mm3",
            .doc = "Energy to cut 1 mm³ of bone of that density",
            .required = true,
            .range = between(0, 10)},
           point.energy_j_mm3);
}

void describe_size_effect(KeyVisitor& v, SizeEffectSettings& size) {
  v.number({.name = "exponent",
            .doc = "m in u·(reference/h)^m; 1: the force is independent of the chip thickness",
            .required = true,
            .range = between(0.001, 1)},
           size.exponent);
  v.number({.name = "reference_mm",
            .doc = "Chip thickness at which the specific energy was measured",
            .required = true,
            .range = kChip},
           size.reference_mm);
  describe_cutting_edges(v, size.cutting_edges);
  v.number({.name = "least_mm", .doc = "Lower limit of the chip thickness", .range = kChip}, size.least_mm);
  v.number({.name = "most_mm", .doc = "Upper limit of the chip thickness", .range = kChip}, size.most_mm);
}

void describe_edge_force(KeyVisitor& v, EdgeForceSettings& edge) {
  v.number({.name = "tangential_n_mm",
            .doc = "Force against the motion per length of cutting edge in contact",
            .required = true,
            .range = between(1e-6, 1000)},
           edge.tangential_n_mm);
  v.number({.name = "normal_n_mm",
            .doc = "Normal force per length of cutting edge in contact; it pushes the tool out of the bone",
            .required = true,
            .range = between(0, 1000)},
           edge.normal_n_mm);
  describe_cutting_edges(v, edge.cutting_edges);
}

/// Energy per volume by density: a table, a preset or a power law.
void describe_specific_energies(KeyVisitor& v, CuttingSettings& cutting) {
  constexpr std::string_view kTable = "specific_energy_table";
  v.list({.name = kTable,
          .doc = "Specific cutting energy over density instead of the power law: two or more points in ascending "
                 "density, interpolated linearly, constant beyond the ends"},
         cutting.specific_energy_table, describe_specific_energy);
  v.choice({.name = "preset",
            .doc = "Sets specific_energy_j_mm3, reference_density_g_cm3 and density_exponent to the low end, the "
                   "middle or the high end of the ranges that this project assumes; they do not bound the result. A "
                   "key that is given takes precedence",
            .unless = kTable},
           cutting.preset);
  v.number({.name = "specific_energy_j_mm3",
            .doc = "Specific cutting energy at the reference density (u0). Uncalibrated; 0.05 to 0.30 is assumed, thin "
                   "chips need more",
            .range = between(1e-6, 10),
            .unless = kTable},
           cutting.specific_energy_j_mm3);
  v.number({.name = "reference_density_g_cm3",
            .doc = "Density at which the specific cutting energy is specific_energy_j_mm3",
            .range = kDensity,
            .unless = kTable},
           cutting.reference_density_g_cm3);
  v.number({.name = "density_exponent",
            .doc = "p in u = u0·(density/reference density)^p; 1 to 2.5 is assumed",
            .range = between(0, 5),
            .unless = kTable},
           cutting.density_exponent);
}

/// Options of the energetic law.
void describe_options(KeyVisitor& v, CuttingSettings& cutting) {
  v.number({.name = "normal_ratio",
            .doc = "Normal force as a multiple of the tangential force (k_n)",
            .range = between(0, 10)},
           cutting.normal_ratio);
  v.number(
      {.name = "friction_fraction",
       .doc = "Fraction of the tangential force that is friction. It changes no force; summary.json states its energy",
       .range = between(0, 1),
       .when = {"law", {"energy"}}},
      cutting.friction_fraction);
  v.group({.names = {"size_effect", "edge_force"}, .one_needed = false});
  v.optional_section({.name = "size_effect",
                      .doc = "Thin chips need more energy per volume: u·(reference/h)^exponent, where h is the uncut "
                             "chip thickness. Not with `edge_force`",
                      .when = {"law", {"energy"}}},
                     cutting.size_effect, describe_size_effect);
  v.optional_section({.name = "edge_force",
                      .doc = "Force per length of cutting edge in contact, cutting or not. Needs `law: energy`; not "
                             "with `size_effect`, nor with tool.spin: resolved",
                      .when = {"erosion", {"exact"}}},
                     cutting.edge_force, describe_edge_force);
}

}  // namespace

void describe_cutting(KeyVisitor& v, CuttingSettings& cutting) {
  v.choice({.name = "law",
            .doc = "energy: force from the specific cutting energy of the removed volume; per_point: a given force per "
                   "shell point in contact, as in the paper"},
           cutting.law);
  v.defaults([&cutting] {
    if (cutting.law == CuttingLaw::per_point) cutting.erosion = ErosionMode::remove;
  });
  v.choice(
      {.name = "erosion",
       .doc = "exact: a voxel keeps the part of it that lies outside the tool (needs engine.type: auto or exact, and "
              "law: energy); remove: a touched voxel is removed as a whole, the default where exact is not "
              "possible; wear: it loses density at a constant rate",
       .default_by = "engine.type"},
      cutting.erosion);
  describe_specific_energies(v, cutting);
  describe_options(v, cutting);
  v.number(
      {.name = "speed_floor_mm_s",
       .doc =
           "Lower limit of the cutting speed in the force law; it keeps the force finite where the tool hardly moves",
       .range = between(0.001, 10000)},
      cutting.speed_floor_mm_s);
  v.number({.name = "force_per_point_n",
            .doc = "Force of one shell point in contact; used by `law: per_point` only",
            .range = between(0, 1000)},
           cutting.force_per_point_n);
  v.number({.name = "wear_g_cm3_per_s",
            .doc = "Density that a touched voxel loses per second; used by `erosion: wear` only",
            .range = between(0.001, 1e6)},
           cutting.wear_g_cm3_per_s);
}

}  // namespace reamsim
