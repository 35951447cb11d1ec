// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The section `cutting`: presets, the table of specific energy, and the options of the force law.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/parse.h"
#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

const std::string kSize = "size_effect: {exponent: 0.3, reference_mm: 0.05, cutting_edges: 6}";
const std::string kEdge = "edge_force: {tangential_n_mm: 1, normal_n_mm: 2, cutting_edges: 6}";
const std::string kTable =
    "specific_energy_table: [{density_g_cm3: 0, energy_j_mm3: 0}, {density_g_cm3: 1.8, "
    "energy_j_mm3: 0.2}]";

class Cutting : public ScenarioTest {
 protected:
  /// The valid scenario with a section `cutting` of these keys, as lines 16 and 17.
  static std::string yaml(const std::string& keys) { return kValid + "cutting:\n  {" + keys + "}\n"; }
  CuttingSettings cutting(const std::string& keys, const std::vector<std::string>& overrides = {}) const {
    return parse(yaml(keys), overrides).cutting;
  }
  std::string bad(const std::string& keys) const { return complaint(yaml(keys)); }
  /// The resolved scenario, after checking that it resolves to itself.
  std::string resolved(const std::string& keys) const {
    const std::string once = to_yaml(parse(yaml(keys)));
    EXPECT_EQ(to_yaml(parse(once)), once);
    return once;
  }
};

TEST_F(Cutting, OptionsAreOffByDefault) {
  const CuttingSettings defaults = parse(kValid).cutting;
  EXPECT_EQ(defaults.preset, EnergyPreset::none);
  EXPECT_THAT(defaults.specific_energy_table, IsEmpty());
  EXPECT_FALSE(defaults.size_effect);
  EXPECT_FALSE(defaults.edge_force);
  EXPECT_EQ(defaults.friction_fraction, 0);
}

TEST_F(Cutting, Presets) {
  const CuttingSettings low = cutting("preset: assumed-low"), mid = cutting("preset: assumed-mid"),
                        high = cutting("preset: assumed-high");
  EXPECT_EQ(low.specific_energy_j_mm3, 0.05);
  EXPECT_EQ(low.density_exponent, 2.5);
  EXPECT_EQ(high.specific_energy_j_mm3, 0.30);
  EXPECT_EQ(high.density_exponent, 1);
  const CuttingSettings defaults;
  EXPECT_EQ(mid.specific_energy_j_mm3, defaults.specific_energy_j_mm3) << "the default is the middle";
  EXPECT_EQ(mid.density_exponent, defaults.density_exponent);
  EXPECT_EQ(mid.reference_density_g_cm3, defaults.reference_density_g_cm3);
  EXPECT_THAT(changed_from_preset(low), IsEmpty());
  EXPECT_THAT(changed_from_preset(defaults), IsEmpty()) << "no preset";
}

TEST_F(Cutting, WhatIsGivenWinsOverThePreset) {
  const CuttingSettings own = cutting("density_exponent: 1.5, preset: assumed-high");
  EXPECT_EQ(own.specific_energy_j_mm3, 0.30);
  EXPECT_EQ(own.density_exponent, 1.5);
  EXPECT_THAT(changed_from_preset(own), ElementsAre("density_exponent"));
  EXPECT_EQ(cutting("preset: assumed-high", {"cutting.specific_energy_j_mm3=0.2"}).specific_energy_j_mm3, 0.2);
  EXPECT_EQ(cutting("density_exponent: 1.5", {"cutting.preset=assumed-low"}).specific_energy_j_mm3, 0.05);
  const std::string yaml = resolved("density_exponent: 1.5, preset: assumed-high");
  EXPECT_THAT(yaml, HasSubstr("  preset: assumed-high\n  specific_energy_j_mm3: 0.3\n"));
  EXPECT_THAT(yaml, HasSubstr("  density_exponent: 1.5\n"));
}

TEST_F(Cutting, OldNamesOfPresets) {
  const Scenario old = parse(yaml("preset: literature-high"));
  EXPECT_EQ(old.cutting.preset, EnergyPreset::assumed_high);
  EXPECT_THAT(old.notes, ElementsAre(EndsWith("s.yaml:17:4: cutting.preset: outdated: write assumed-high")));
  EXPECT_EQ(to_yaml(old), resolved("preset: assumed-high"));
  EXPECT_THAT(bad("preset: literature-most"), HasSubstr("found the text \"literature-most\"; expected assumed-low"));
}

TEST_F(Cutting, PresetsOfADrillAreTheFittedConstants) {
  const std::vector<std::string> lines =
      split(read_file(REAMSIM_ROOT "/trajectories/validation/drilling_models.csv", "the fitted constants"), '\n');
  for (const std::string material : {"human", "artificial"}) {
    const CuttingSettings preset = cutting("preset: drill-" + material + "-femur");
    const EdgeForceSettings edge = preset.edge_force.value();
    const std::string row =
        fmt::format("edge force,{},1000,{},{},,,,{},{},{}", material, preset.specific_energy_j_mm3, preset.normal_ratio,
                    edge.tangential_n_mm, edge.normal_n_mm, edge.cutting_edges);
    EXPECT_THAT(lines, Contains(row));
    EXPECT_THAT(changed_from_preset(preset), IsEmpty());
    resolved("preset: drill-" + material + "-femur");
  }
  const CuttingSettings own = cutting("preset: drill-human-femur, normal_ratio: 0.5, " + kEdge);
  EXPECT_EQ(own.edge_force->cutting_edges, 6) << "what is given wins";
  EXPECT_THAT(changed_from_preset(own), ElementsAre("normal_ratio", "edge_force"));
  for (const std::string& with : {kSize, std::string("erosion: remove")}) {
    EXPECT_EQ(
        bad("preset: drill-human-femur, " + with),
        "s.yaml:17:4: cutting.preset: found drill-human-femur, which has an edge force; expected erosion exact and "
        "no size_effect, or another preset");
  }
}

TEST_F(Cutting, UnknownPreset) {
  EXPECT_EQ(bad("preset: literature"),
            "s.yaml:17:12: cutting.preset: found the text \"literature\"; expected assumed-low, assumed-mid, "
            "assumed-high, drill-human-femur or drill-artificial-femur");
}

TEST_F(Cutting, TableReplacesThePowerLaw) {
  const std::string yaml = resolved(kTable + ", " + kSize);
  EXPECT_THAT(yaml, HasSubstr("  specific_energy_table:\n    - density_g_cm3: 0\n      energy_j_mm3: 0\n"));
  EXPECT_THAT(yaml, Not(HasSubstr("specific_energy_j_mm3")));
  EXPECT_THAT(yaml, HasSubstr("  size_effect:\n    exponent: 0.3\n"));
  for (const std::string key :
       {"preset: assumed-mid", "specific_energy_j_mm3: 0.1", "density_exponent: 2", "reference_density_g_cm3: 1.8"}) {
    EXPECT_THAT(bad(kTable + ", " + key),
                HasSubstr("does not apply: specific_energy_table is given; expected one or the other"));
  }
}

TEST_F(Cutting, TableAscends) {
  EXPECT_EQ(bad("specific_energy_table: [{density_g_cm3: 1, energy_j_mm3: 0}]"),
            "s.yaml:17:4: cutting.specific_energy_table: found a list of 1; expected two or more points");
  EXPECT_THAT(bad("specific_energy_table: []"), HasSubstr("found a list of 0; expected two or more points"));
  for (const std::string second : {"1", "0.5"}) {
    EXPECT_THAT(bad("specific_energy_table: [{density_g_cm3: 1, energy_j_mm3: 0}, {density_g_cm3: " + second +
                    ", energy_j_mm3: 1}]"),
                HasSubstr("cutting.specific_energy_table.1.density_g_cm3: found " + second +
                          "; expected more than at the previous point, 1"));
  }
  EXPECT_THAT(bad("specific_energy_table: [{density_g_cm3: 1}]"), HasSubstr("energy_j_mm3: missing"));
  EXPECT_THAT(bad("specific_energy_table: [[0, 1], [1, 2]]"), HasSubstr("expected a section of keys"));
}

TEST_F(Cutting, SizeEffectOrEdgeForce) {
  EXPECT_EQ(bad(kSize), "");
  EXPECT_EQ(bad("erosion: exact, " + kEdge), "");
  EXPECT_EQ(bad("erosion: exact, " + kSize + ", " + kEdge),
            "s.yaml:17:88: cutting.edge_force: given together with size_effect; expected one of size_effect or "
            "edge_force");
}

TEST_F(Cutting, OptionsNeedTheirErosionAndLaw) {
  EXPECT_THAT(bad("erosion: wear, " + kEdge),
              HasSubstr("cutting.edge_force: does not apply: erosion is wear; expected it with erosion: exact only"));
  EXPECT_EQ(bad("law: per_point, erosion: exact, " + kEdge),
            "s.yaml:17:4: cutting.law: found per_point; expected energy, because cutting.edge_force is given");
  EXPECT_THAT(bad("law: per_point, " + kSize), HasSubstr("cutting.size_effect: does not apply: law is"));
  EXPECT_THAT(bad("law: per_point, friction_fraction: 0.2"),
              HasSubstr("cutting.friction_fraction: does not apply: law is"));
}

TEST_F(Cutting, ValuesOfOptions) {
  EXPECT_THAT(bad("size_effect: {exponent: 1.5, reference_mm: 0.05, cutting_edges: 6}"),
              HasSubstr("cutting.size_effect.exponent: found 1.5; expected a number, 0.001 to 1"));
  EXPECT_THAT(bad("size_effect: {exponent: 0.5, reference_mm: 0.05}"),
              HasSubstr("cutting.size_effect.cutting_edges: missing; expected this key"));
  EXPECT_THAT(bad("size_effect: {exponent: 0.5, reference_mm: 0.05, cutting_edges: 6, least_mm: 0.6}"),
              HasSubstr("cutting.size_effect.least_mm: found 0.6; expected no more than most_mm"));
  EXPECT_THAT(bad("erosion: exact, edge_force: {tangential_n_mm: 0, normal_n_mm: 1, cutting_edges: 6}"),
              HasSubstr("cutting.edge_force.tangential_n_mm: found 0; expected a number, 0.000001 to 1000 (N/mm)"));
  EXPECT_THAT(bad("friction_fraction: 1.1"),
              StartsWith("s.yaml:17:23: cutting.friction_fraction: found 1.1; expected"));
}

}  // namespace
}  // namespace reamsim::test
