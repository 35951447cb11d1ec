// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Forces for other constants from the force basis of a run, and fits to measured forces.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

const std::string kWithBasis = kSmall + "output: {force_basis: true}\n";

/// The columns of a CSV file.
std::map<std::string, std::vector<double>> columns_of(const std::string& text) {
  std::istringstream lines(text);
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
  std::map<std::string, std::vector<double>> out;
  while (std::getline(lines, line)) {
    std::istringstream row(line);
    for (std::size_t i = 0; std::getline(row, cell, ','); ++i) out[names[i]].push_back(std::stod(cell));
  }
  return out;
}

class Reforce : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  void run_with_basis() const { expect_done(run(kWithBasis)); }
  /// `a` has the forces of `b`, to 10⁻⁵ of their peaks.
  void expect_same_forces(const std::string& a, const std::string& b) const {
    auto of_a = columns_of(read(a + "/forces.csv")), of_b = columns_of(read(b + "/forces.csv"));
    for (const auto& [name, values] : of_b) {
      ASSERT_EQ(of_a[name].size(), values.size()) << name;
      const std::vector<std::string> group =
          name.starts_with("force_")    ? std::vector<std::string>{"force_x_n", "force_y_n", "force_z_n"}
          : name.starts_with("torque_") ? std::vector<std::string>{"torque_x_nmm", "torque_y_nmm", "torque_z_nmm"}
                                        : std::vector<std::string>{name};
      double peak = name == "balance" ? 1 : 0;
      for (const std::string& member : group)
        for (const double value : of_b[member]) peak = std::max(peak, std::abs(value));
      for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(of_a[name][i], values[i], 1e-5 * peak) << name << i;
    }
  }
  void expect_wrong_input(const std::vector<std::string>& arguments, std::initializer_list<const char*> words) const {
    const ProgramResult result = call(arguments);
    EXPECT_EQ(result.status, 2) << result.out << result.err;
    for (const char* word : words) EXPECT_THAT(result.err, HasSubstr(word));
    EXPECT_FALSE(exists("other"));
    EXPECT_FALSE(exists("other.partial"));
  }
};

TEST_F(Reforce, ARunWithABasisHasTheSameResults) {
  meshes_ = true;
  expect_done(run(kSmall));
  fs::rename(path("out"), path("plain"));
  expect_done(run(kSmall, {"--set", "output.force_basis=true"}));
  EXPECT_TRUE(exists("out/force_basis.npy"));
  for (const char* file : {"forces.csv", "reamed.vdb", "reamed.vti", "reamed.stl"})
    EXPECT_TRUE(read(std::string("out/") + file) == read(std::string("plain/") + file)) << file;
  EXPECT_THAT(read("out/manifest.json"), HasSubstr("force_basis.npy"));
}

TEST_F(Reforce, GivesTheForcesOfTheRunAndOfReruns) {
  run_with_basis();
  const std::vector<std::vector<std::string>> cases{
      {},
      {"--set", "cutting.specific_energy_j_mm3=0.2"},
      {"--set", "cutting.preset=assumed-low"},
      {"--set", "cutting.preset=assumed-high", "--set", "cutting.normal_ratio=0.9"},
      {"--set",
       "cutting.specific_energy_table=[{density_g_cm3: 0.5, energy_j_mm3: 0.01}, {density_g_cm3: 1.9, "
       "energy_j_mm3: 0.3}]"}};
  for (const std::vector<std::string>& overrides : cases) {
    SCOPED_TRACE(overrides.empty() ? "own constants" : overrides.back());
    for (const char* dir : {"again", "other"}) fs::remove_all(path(dir));
    std::vector<std::string> rerun{"run", "s.yaml", "-o", "again"}, reforce{"reforce", "out", "-o", "other"};
    rerun.insert(rerun.end(), overrides.begin(), overrides.end());
    reforce.insert(reforce.end(), overrides.begin(), overrides.end());
    ASSERT_EQ(call(rerun).status, 0);
    const ProgramResult result = call(reforce);
    ASSERT_EQ(result.status, 0) << result.err;
    expect_same_forces("other", "again");
    const auto of_other = nlohmann::json::parse(read("other/summary.json")),
               of_again = nlohmann::json::parse(read("again/summary.json"));
    EXPECT_EQ(of_other["force_law"], of_again["force_law"]);
    for (const char* key : {"peak_axial_force_n", "rms_torque_nmm", "mean_force_n"})
      EXPECT_NEAR(of_other["forces"][key].get<double>() / of_again["forces"][key].get<double>(), 1, 1e-5) << key;
    // The scenario is that of the rerun, but for checksums and the like in its head.
    const std::string was = read("again/scenario.yaml"), is = read("other/scenario.yaml");
    EXPECT_EQ(is.substr(is.find("\ncutting:")), was.substr(was.find("\ncutting:")));
  }
  EXPECT_EQ(call({"compare", "out", "other", "-o", "compared"}).status, 0);
}

TEST_F(Reforce, ReplacesTheForcesOfTheRunWhenAsked) {
  run_with_basis();
  const std::string before = read("out/forces.csv");
  ASSERT_EQ(call({"reforce", "out", "--overwrite", "--set", "cutting.specific_energy_j_mm3=0.3"}).status, 0);
  EXPECT_NE(read("out/forces.csv"), before);
  EXPECT_THAT(read("out/scenario.yaml"), HasSubstr("specific_energy_j_mm3: 0.3"));
  EXPECT_EQ(call({"render", "out", "--only", "plots"}).status, 0);
  // From the new constants back to the old ones.
  ASSERT_EQ(call({"reforce", "out", "-o", "other", "--set", "cutting.specific_energy_j_mm3=0.15"}).status, 0);
  write("before.csv", before);
  fs::create_directory(path("was"));
  fs::copy(path("before.csv"), path("was/forces.csv"));
  expect_same_forces("other", "was");
  EXPECT_EQ(call({"run", "s.yaml", "-o", "out", "--overwrite"}).status, 0) << "the folder is still one of reamsim";
}

TEST_F(Reforce, RefusesWhatTheBasisDoesNotHold) {
  run_with_basis();
  const auto refused = [this](const std::string& override, std::initializer_list<const char*> words) {
    SCOPED_TRACE(override);
    expect_wrong_input({"reforce", "out", "-o", "other", "--set", override}, words);
  };
  refused("cutting.speed_floor_mm_s=20", {"speed_floor_mm_s", "is part of the force basis", "run the scenario again"});
  refused("cutting.size_effect={exponent: 0.3, reference_mm: 0.1, cutting_edges: 6}", {"size_effect", "not linear"});
  refused("cutting.edge_force={tangential_n_mm: 1, normal_n_mm: 2, cutting_edges: 6}",
          {"edge_force", "no part for it"});
  refused("cutting.erosion=remove", {"cutting.erosion"});
  refused("bone.density.ash_fraction=0.5", {"bone.density", "phantom"});
  refused("bone.voxel_mm=0.3", {"bone.voxel_mm", "expected cutting.KEY=VALUE"});
  refused("cutting.specific_energy_j_mm3=30", {"specific_energy_j_mm3", "10"});
  expect_wrong_input({"reforce", "out"}, {"no output given", "-o DIR"});
  expect_wrong_input({"reforce", "missing", "-o", "other"}, {"missing"});
  write("out/force_basis.npy", read("out/force_basis.npy").substr(0, 600));
  expect_wrong_input({"reforce", "out", "-o", "other"}, {"force_basis.npy", "damaged or truncated"});
  fs::remove_all(path("out"));
  expect_done(run(kSmall));
  expect_wrong_input({"reforce", "out", "-o", "other"}, {"output.force_basis", "run the scenario again with"});
}

TEST_F(Reforce, ABasisNeedsALawThatIsLinearInEnergy) {
  const std::vector<std::pair<std::string, const char*>> cases{
      {"cutting: {law: per_point}\n", "cutting.law"},
      {"cutting: {erosion: wear}\n", "cutting.erosion"},
      {"cutting: {erosion: remove}\nengine: {type: direct}\n", "engine.type"}};
  for (const auto& [lines, key] : cases) {
    SCOPED_TRACE(lines);
    std::string yaml = kSmall.substr(0, kSmall.find("engine:\n")) + "output: {force_basis: true}\n" + lines;
    expect_refused(run(yaml), 2, {key, "because output.force_basis is true"});
  }
}

TEST_F(Reforce, FitsTheForcesOfAnotherRun) {
  run_with_basis();
  ASSERT_EQ(call({"run", "s.yaml", "-o", "bench", "--set", "cutting.specific_energy_j_mm3=0.22", "--set",
                  "cutting.normal_ratio=0.8"})
                .status,
            0);
  fs::copy(path("bench/forces.csv"), path("measured.csv"));
  const ProgramResult fit = call({"fit", "out", "measured.csv", "-o", "fit.json", "--residuals", "residuals.csv"});
  ASSERT_EQ(fit.status, 0) << fit.err;
  EXPECT_THAT(fit.out, HasSubstr("cannot tell the exponent from u0"));
  const auto json = nlohmann::json::parse(read("fit.json"));
  EXPECT_EQ(json["constants"][0]["name"], "u0");
  EXPECT_NEAR(json["constants"][0]["value"].get<double>(), 0.22, 0.22e-4);
  EXPECT_EQ(json["constants"][1]["fitted"], false);
  EXPECT_NEAR(json["constants"][2]["value"].get<double>(), 0.8, 1e-4);
  EXPECT_EQ(json["covariance"].size(), 2U);
  for (const auto& [name, values] : columns_of(read("residuals.csv"))) {
    if (!name.starts_with("residual_force")) continue;
    for (const double value : values) EXPECT_NEAR(value, 0, 1e-3) << name;
  }
  EXPECT_EQ(call({"fit", "out", "measured.csv", "-o", "fit.json"}).status, 2) << "does not overwrite";
  EXPECT_EQ(call({"fit", "out", "measured.csv", "-o", "fit.json", "--overwrite"}).status, 0);
  write("late.csv", "time_s,axial_force_n\n1000,1\n");
  const ProgramResult late = call({"fit", "out", "late.csv"});
  EXPECT_EQ(late.status, 2);
  EXPECT_THAT(late.err, HasSubstr("no measured time lies in the time of contact"));
}

}  // namespace
}  // namespace reamsim::test
