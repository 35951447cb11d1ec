// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"
#include "sim/scenario/key_visitor.h"

namespace reamsim {

namespace {

constexpr Range kChip = between(1e-5, 10);  // mm

void describe_cutting_edges(KeyVisitor& v, int& count) {
  v.key("cutting_edges", count, "Number of cutting edges", {.required = true, .range = between(1, 1000)});
}

void describe_specific_energy(KeyVisitor& v, SpecificEnergySettings& point) {
  v.key("density_g_cm3", point.density_g_cm3, "Apparent density", {.required = true, .range = between(0, 2)});
  v.key("energy_j_mm3", point.energy_j_mm3, "Energy to cut 1 mm³ of bone of that density",
        {.required = true, .range = between(0, 10)});
}

void describe_size_effect(KeyVisitor& v, SizeEffectSettings& size) {
  v.key("exponent", size.exponent, "m in u·(reference/h)^m; 1: the force is independent of the chip thickness",
        {.required = true, .range = between(0.001, 1)});
  v.key("reference_mm", size.reference_mm, "Chip thickness at which the specific energy was measured",
        {.required = true, .range = kChip});
  describe_cutting_edges(v, size.cutting_edges);
  v.key("least_mm", size.least_mm, "Lower limit of the chip thickness", kChip);
  v.key("most_mm", size.most_mm, "Upper limit of the chip thickness", kChip);
}

void describe_edge_force(KeyVisitor& v, EdgeForceSettings& edge) {
  v.key("tangential_n_mm", edge.tangential_n_mm, "Force against the motion per length of cutting edge in contact",
        {.required = true, .range = between(1e-6, 1000)});
  v.key("normal_n_mm", edge.normal_n_mm,
        "Normal force per length of cutting edge in contact; it pushes the tool out of the bone",
        {.required = true, .range = between(0, 1000)});
  describe_cutting_edges(v, edge.cutting_edges);
}

/// Energy per volume by density: a table, a preset or a power law.
void describe_specific_energies(KeyVisitor& v, CuttingSettings& cutting) {
  constexpr std::string_view kTable = "specific_energy_table";
  v.list(kTable, cutting.specific_energy_table, describe_specific_energy,
         "Specific cutting energy over density instead of the power law: two or more points in ascending density, "
         "interpolated linearly, constant beyond the ends");
  v.key(
      "preset", cutting.preset,
      "Sets specific_energy_j_mm3, reference_density_g_cm3 and density_exponent to the low end, the middle or the high "
      "end of the ranges that this project assumes; they do not bound the result. A key that is given takes precedence",
      {.unless = kTable});
  v.key("specific_energy_j_mm3", cutting.specific_energy_j_mm3,
        "Specific cutting energy at the reference density (u0). Uncalibrated; 0.05 to 0.30 is assumed, thin chips need "
        "more",
        {.range = between(1e-6, 10), .unless = kTable});
  v.key("reference_density_g_cm3", cutting.reference_density_g_cm3,
        "Density at which the specific cutting energy is specific_energy_j_mm3", {.range = kDensity, .unless = kTable});
  v.key("density_exponent", cutting.density_exponent, "p in u = u0·(density/reference density)^p; 1 to 2.5 is assumed",
        {.range = between(0, 5), .unless = kTable});
}

/// Options of the energetic law.
void describe_options(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("normal_ratio", cutting.normal_ratio, "Normal force as a multiple of the tangential force (k_n)",
        between(0, 10));
  v.key("friction_fraction", cutting.friction_fraction,
        "Fraction of the tangential force that is friction. It changes no force; summary.json states its energy",
        {.range = between(0, 1), .when = {"law", {"energy"}}});
  v.group({.names = {"size_effect", "edge_force"}, .one_needed = false});
  v.section("size_effect", cutting.size_effect, describe_size_effect,
            "Thin chips need more energy per volume: u·(reference/h)^exponent, where h is the uncut chip thickness. "
            "Not with `edge_force`",
            {.when = {"law", {"energy"}}});
  v.section("edge_force", cutting.edge_force, describe_edge_force,
            "Force per length of cutting edge in contact, cutting or not. Needs `law: energy`; not with `size_effect`, "
            "nor with tool.spin: resolved",
            {.when = {"erosion", {"exact"}}});
}

}  // namespace

void describe_cutting(KeyVisitor& v, CuttingSettings& cutting) {
  v.key("law", cutting.law,
        "energy: force from the specific cutting energy of the removed volume; per_point: a given force per shell "
        "point in contact, as in the paper");
  v.defaults([&cutting] {
    if (cutting.law == CuttingLaw::per_point) cutting.erosion = ErosionMode::remove;
  });
  v.key("erosion", cutting.erosion,
        "exact: a voxel keeps the part of it that lies outside the tool (needs engine.type: auto or exact, and law: "
        "energy); remove: a touched voxel is removed as a whole, the default where exact is not possible; wear: it "
        "loses density at a constant rate",
        {.default_by = "engine.type"});
  describe_specific_energies(v, cutting);
  describe_options(v, cutting);
  v.key("speed_floor_mm_s", cutting.speed_floor_mm_s,
        "Lower limit of the cutting speed in the force law; it keeps the force finite where the tool hardly moves",
        between(0.001, 10000));
  v.key("force_per_point_n", cutting.force_per_point_n,
        "Force of one shell point in contact; used by `law: per_point` only", between(0, 1000));
  v.key("wear_g_cm3_per_s", cutting.wear_g_cm3_per_s,
        "Density that a touched voxel loses per second; used by `erosion: wear` only", between(0.001, 1e6));
}

}  // namespace reamsim
