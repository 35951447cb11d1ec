// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Uncertainty: reruns only where forces do not follow from one run.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/cli/sweep_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Uq : public Sweep {
 protected:
  Uq() { write("s.yaml", with(read("s.yaml"), "engine:\n", "cutting: {specific_energy_j_mm3: 0.15}\nengine:\n")); }

  nlohmann::json uq(const std::string& sample) const {
    write("uq.yaml", "version: 1\nbase: s.yaml\nsample: " + sample + "\n");
    const ProgramResult result = reamsim({.arguments = {"uq", "uq.yaml", "-o", "uq", "--jobs", "2"},
                                          .environment = {},
                                          .folder = "",
                                          .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << result.err;
    return nlohmann::json::parse(read("uq/uq.json"));
  }
};

TEST_F(Uq, ConstantsOfTheLawNeedOneRun) {
  const auto json =
      uq("{n: 256, of: {cutting.specific_energy_j_mm3: {lognormal: [0.15, 0.3]}, cutting.normal_ratio: {uniform: [0.4, "
         "0.6]}}}");
  EXPECT_EQ(json["runs"], 1);
  expect_done(run(read("s.yaml")));
  const auto summary = nlohmann::json::parse(read("out/summary.json"));
  // Energy and torque are proportional to the specific energy; its quantiles are 0.15·exp(±0.3·1.645).
  const auto& energy = json["outputs"]["energy_mj"];
  const double median_mj = summary["energy_mj"];
  EXPECT_NEAR(energy["p50"].get<double>() / median_mj, 1, 0.01);
  EXPECT_NEAR(energy["p95"].get<double>() / median_mj, std::exp(0.3 * 1.645), 0.03);
  EXPECT_NEAR(energy["p05"].get<double>() / median_mj, std::exp(-0.3 * 1.645), 0.02);
  EXPECT_NEAR(energy["inputs"]["cutting.specific_energy_j_mm3"]["total"].get<double>(), 1, 0.05);
  EXPECT_NEAR(energy["inputs"]["cutting.normal_ratio"]["total"].get<double>(), 0, 1e-9);
  // The axial force depends on the ratio as well.
  const auto& force = json["outputs"]["peak_axial_force_n"];
  EXPECT_GT(force["inputs"]["cutting.normal_ratio"]["total"].get<double>(), 0.02);
  const std::vector<std::string> bands = lines("uq/uq.csv");
  EXPECT_THAT(bands[0], HasSubstr("time_s,axial_force_n_p05"));
  EXPECT_GT(bands.size(), 20U);
  for (const char* file : {"uq/uq.png", "uq/uq.svg", "uq/uq.pdf", "uq/uq.py"}) EXPECT_TRUE(exists(file)) << file;
}

TEST_F(Uq, OtherInputsNeedRuns) {
  const auto json =
      uq("{n: 8, of: {motion.plunge.depth_mm: {uniform: [0.5, 1]}, cutting.specific_energy_j_mm3: {lognormal: [0.15, "
         "0.3]}}}");
  EXPECT_EQ(json["runs"], 16) << "the constant needs no run of its own";
  EXPECT_EQ(json["samples"], 16);
  const auto& removed = json["outputs"]["removed_mm3"];
  EXPECT_GT(removed["inputs"]["motion.plunge.depth_mm"]["total"].get<double>(), 0.5);
  EXPECT_EQ(removed["inputs"]["cutting.specific_energy_j_mm3"]["total"], 0);
  EXPECT_GT(removed["inputs"]["motion.plunge.depth_mm"]["mean_in_highest_fifth"].get<double>(),
            removed["inputs"]["motion.plunge.depth_mm"]["mean_in_lowest_fifth"].get<double>());
}

// Effects of geometry alone on forces, with the force law of the base, would contradict those of all inputs.
TEST_F(Uq, ForcesHaveOneAnswer) {
  write("uq.yaml",
        "version: 1\nbase: s.yaml\nsample: {n: 16, of: {motion.plunge.depth_mm: {uniform: [0.5, 1]}, "
        "cutting.specific_energy_j_mm3: {uniform: [0.05, 0.3]}}}\n");
  const ProgramResult result =
      reamsim({.arguments = {"uq", "uq.yaml", "-o", "uq"}, .environment = {}, .folder = "", .interrupt_when = {}});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("Removed volume"), HasSubstr("those of the base's force law"),
                                HasSubstr("peak_axial_force_n: "), HasSubstr("±: 95 % sampling error")));
  for (const std::string& shown : {result.out, read("uq/effects.csv")}) {
    EXPECT_THAT(shown, AllOf(Not(HasSubstr("Peak axial force")), Not(HasSubstr("headline."))));
  }
  EXPECT_THAT(lines("uq/runs.csv")[0], HasSubstr("headline.peak_axial_force_n"));
  const auto input = nlohmann::json::parse(
      read("uq/uq.json"))["outputs"]["peak_axial_force_n"]["inputs"]["cutting.specific_energy_j_mm3"];
  EXPECT_GT(input["first_order_error"].get<double>(), 0.01);
  EXPECT_GT(input["total_error"].get<double>(), 0.01);
}

TEST_F(Uq, ConstantsInWhichForcesAreNotLinearNeedRuns) {
  write("s.yaml", "output: {force_basis: true}\n" + read("s.yaml"));
  // The small scenario cuts below this speed.
  const auto json =
      uq("{n: 8, of: {cutting.speed_floor_mm_s: {uniform: [1000, 4000]}, cutting.specific_energy_j_mm3: {lognormal: "
         "[0.15, 0.3]}}}\nset: {output.force_basis: true}");
  EXPECT_EQ(json["runs"], 16);
  const auto& torque = json["outputs"]["peak_spin_torque_nmm"];
  EXPECT_GT(torque["inputs"]["cutting.speed_floor_mm_s"]["total"].get<double>(), 0.1);
  const std::string runs = read("uq/runs.yaml");
  EXPECT_EQ(runs.find("force_basis"), runs.rfind("force_basis")) << runs;
}

TEST_F(Uq, SweepAndAnalysisLeaveTheFolderOfTheOtherAlone) {
  uq("{n: 4, of: {motion.plunge.depth_mm: {uniform: [0.5, 1]}}}");
  const std::vector<std::string> files{"uq/study.json", "uq/runs.csv", "uq/sweep.html", "uq/uq.json"};
  const auto contents = [&] {
    std::vector<std::string> out;
    for (const std::string& file : files) out.push_back(read(file));
    return out;
  };
  const std::vector<std::string> before = contents();
  for (const char* command : {"run", "collect"}) {
    for (const char* study : {"uq.yaml", "study.yaml"}) {
      expect_refused(sweep({command, study, "-o", "uq"}), 2,
                     {"uq: output folder: holds the results of `reamsim uq`", "choose another with -o"});
    }
    expect_refused(sweep({command, "uq/runs.yaml", "-o", "uq", "--set", "bone.voxel_mm=0.6"}), 2, {"`reamsim uq`"});
    EXPECT_EQ(contents(), before) << command;
  }
  EXPECT_EQ(sweep({"status", "uq.yaml", "-o", "uq"}).status, 0) << "it only reads";
  for (const char* command : {"run", "collect"}) {
    const ProgramResult own = sweep({command, "uq/runs.yaml", "-o", "uq"});
    EXPECT_EQ(own.status, 0) << own.err;
  }
  EXPECT_EQ(contents(), before) << "the study of its own runs";
  uq("{n: 4, of: {motion.plunge.depth_mm: {uniform: [0.5, 1]}}}");
  write("one.yaml", "version: 1\nbase: s.yaml\nset: {motion.plunge.depth_mm: 0.5}\n");
  EXPECT_EQ(sweep({"run", "one.yaml", "-o", "swept"}).status, 0);
  const std::string table = read("swept/runs.csv");
  expect_refused(
      reamsim({.arguments = {"uq", "uq.yaml", "-o", "swept"}, .environment = {}, .folder = "", .interrupt_when = {}}),
      2, {"swept: output folder: holds the results of `reamsim sweep run`", "choose another with -o"});
  EXPECT_EQ(read("swept/runs.csv"), table);
  EXPECT_FALSE(exists("swept/runs.yaml"));
}

TEST_F(Uq, StudiesThatAreNoUncertaintyAnalysisAreRefused) {
  const auto refused = [&](const std::string& lines) {
    write("uq.yaml", "version: 1\nbase: s.yaml\n" + lines);
    const ProgramResult result =
        reamsim({.arguments = {"uq", "uq.yaml", "-o", "uq"}, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(result.status, 2);
    EXPECT_FALSE(exists("uq"));
    return result.err;
  };
  EXPECT_THAT(refused("keep: forces\n"), HasSubstr("sample: missing"));
  EXPECT_THAT(
      refused(
          "vary: [{motion.plunge.depth_mm: [1]}]\nsample: {n: 8, of: {cutting.normal_ratio: {normal: [1, 0.1]}}}\n"),
      HasSubstr("vary: an uncertainty analysis has no such key"));
  EXPECT_THAT(refused("sample: {n: 8, method: saltelli, of: {cutting.normal_ratio: {normal: [1, 0.1]}}}\n"),
              AllOf(HasSubstr("uq.yaml:3:"), HasSubstr("`reamsim uq` draws the pairs"), HasSubstr("`reamsim sweep`")));
  // Samples that the key or the whole scenario refuses: nothing is simulated.
  EXPECT_THAT(
      refused("sample:\n  n: 8\n  of:\n    motion.plunge.depth_mm: {uniform: [0.5, 1]}\n"
              "    bone.phantom.density_g_cm3: {normal: [1.9, 0.3]}\n"),
      AllOf(HasSubstr("uq.yaml:7:5: bone.phantom.density_g_cm3: found 2."), HasSubstr("of 16 samples lie outside"),
            HasSubstr("to 2; expected a distribution within that range")));
  EXPECT_THAT(refused("sample: {n: 8, of: {cutting.normal_ratio: {normal: [0, 1]}}}\n"),
              HasSubstr("uq.yaml:3:21: cutting.normal_ratio: found -"))
      << "a constant";
  EXPECT_THAT(refused("set: {motion.plunge.entry_mm: [0, 0, 0]}\nsample: {n: 8, of: {motion.plunge.entry_mm: "
                      "{shift_sd_mm: 1e7}}}\n"),
              AllOf(HasSubstr("uq.yaml: sample.of: "), HasSubstr("runs are wrong, the first: ")));
  // Between 4 and 63, the analysis warns.
  write("uq.yaml", "version: 1\nbase: s.yaml\nsample: {n: 4, of: {cutting.normal_ratio: {uniform: [0.4, 0.6]}}}\n");
  const ProgramResult few =
      reamsim({.arguments = {"uq", "uq.yaml", "-o", "few"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(few.status, 0) << few.err;
  EXPECT_THAT(few.err, HasSubstr("sample.n is 4: with less than 64"));
  EXPECT_THAT(refused("sample: {n: 2, of: {cutting.normal_ratio: {normal: [1, 0.1]}}}\n"),
              HasSubstr("expected 4 or more"));
}

}  // namespace
}  // namespace reamsim::test
