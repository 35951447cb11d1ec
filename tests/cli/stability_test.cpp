// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

/// docs/stability.md, with a run of a scenario of version 1 that reamsim 0.1.0 simulated.
class Stability : public CliTest {
 protected:
  Stability() {
    std::filesystem::copy(REAMSIM_ROOT "/tests/cli/results_0_1_0", dir_ + "/old",
                          std::filesystem::copy_options::recursive);
  }
  ProgramResult call(const std::vector<std::string>& arguments) const {
    const ProgramResult result =
        reamsim({.arguments = arguments, .environment = {{"HOME", path("old")}}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << result.out << result.err;
    return result;
  }
  Json json(const std::string& name) const { return Json::parse(read(name)); }

  /// A CSV by the names of its columns.
  std::map<std::string, std::vector<double>> columns(const std::string& name) const {
    std::istringstream lines(read(name));
    std::string line, cell;
    std::vector<std::string> names;
    std::getline(lines, line);
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
    std::map<std::string, std::vector<double>> out;
    while (std::getline(lines, line)) {
      std::istringstream cells(line);
      for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) out[names.at(i)].push_back(std::stod(cell));
    }
    return out;
  }
};

/// Every key of `old` is one of `now`, with the same type; numbers count as one type.
void expect_same_keys(const Json& old, const Json& now, const std::string& path) {
  if (old.is_object()) {
    ASSERT_TRUE(now.is_object()) << path;
    for (const auto& [key, value] : old.items()) {
      ASSERT_TRUE(now.contains(key)) << path << "." << key << " was removed";
      expect_same_keys(value, now[key], path + "." + key);
    }
  } else if (old.is_array() && !old.empty()) {
    ASSERT_TRUE(now.is_array() && !now.empty()) << path;
    expect_same_keys(old[0], now[0], path + "[0]");
  } else {
    EXPECT_TRUE(old.type() == now.type() || (old.is_number() && now.is_number())) << path;
  }
}

TEST_F(Stability, AScenarioOfVersion1GivesTheSameColumnsKeysAndForces) {
  const ProgramResult run = call({"run", "old/s.yaml", "-o", "new"});
  EXPECT_THAT(run.err, HasSubstr("cutting.friction_share: outdated since format version 2"));
  expect_same_keys(json("old/results/summary.json"), json("new/summary.json"), "summary");
  const auto old = columns("old/results/forces.csv");
  const auto now = columns("new/forces.csv");
  ASSERT_GT(old.size(), 20U);
  for (const auto& [name, values] : old) {
    ASSERT_TRUE(now.contains(name)) << name << " was removed";
    ASSERT_EQ(now.at(name).size(), values.size()) << name;
    // Rounding may differ between versions, and balance is rounding alone.
    const double tolerance = name == "balance" ? 1e-4 : 1e-6;
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_NEAR(now.at(name)[i], values[i], tolerance * std::max(1.0, std::abs(values[i]))) << name << ", row " << i;
    }
  }
}

TEST_F(Stability, ResultsOfAnOlderVersionAreRead) {
  call({"reforce", "old/results", "--set", "cutting.specific_energy_j_mm3=0.3", "-o", "twice"});
  const double was = json("old/results/summary.json")["forces"]["peak_axial_force_n"];
  EXPECT_NEAR(json("twice/summary.json")["forces"]["peak_axial_force_n"].get<double>(), 2 * was, 1e-6 * was)
      << "0.15 J/mm3 is the default";
  // Its own forces, as if they had been measured: the constant of the law is found again.
  const auto old = columns("old/results/forces.csv");
  std::ofstream measured(path("measured.csv"));
  measured << "time_s,axial_force_n\n";
  for (std::size_t i = 0; i < old.at("time_s").size(); ++i) {
    measured << old.at("time_s")[i] << "," << old.at("axial_force_n")[i] << "\n";
  }
  measured.close();
  EXPECT_THAT(call({"fit", "old/results", "measured.csv", "--fixed-normal-ratio", "-o", "fit.json"}).out,
              HasSubstr("constants: fit.json"));
  EXPECT_TRUE(exists("fit.json"));
  EXPECT_THAT(call({"cite", "old/results"}).out, HasSubstr("version 0.1.0"));
  EXPECT_THAT(call({"compare", "old/results", "twice", "-o", "compared"}).out, HasSubstr("peak"));
  EXPECT_TRUE(exists("compared/runs.csv"));
  call({"render", "old/results", "--only", "plots"});
  EXPECT_TRUE(exists("old/results/plots/energy.png"));
}

TEST_F(Stability, ALaterFormatIsRefused) {
  write("s.yaml", with(kSmall, "version: 2", "version: 3"));
  expect_refused(reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}}), 2,
                 {"s.yaml:1:10", "version: found 3", "expected"});
}

}  // namespace
}  // namespace reamsim::test
