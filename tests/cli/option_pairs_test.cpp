// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// An option that would have no effect beside others is an error that names it, and no file is written.
#include <filesystem>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class OptionPairs : public CliTest {
 protected:
  OptionPairs() { write("s.yaml", kSmall); }

  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  void expect_named(const std::vector<std::string>& arguments, const std::string& option) const {
    const ProgramResult result = call(arguments);
    EXPECT_EQ(result.status, 2) << option << result.out << result.err;
    EXPECT_THAT(result.err, HasSubstr(option));
  }
};

TEST_F(OptionPairs, OfCommandsThatReadAScenario) {
  expect_named({"run", "s.yaml", "--quiet", "--verbose"}, "--verbose");
  expect_named({"run", "s.yaml", "--device", "serial", "--set", "engine.device=auto"}, "--device");
  expect_named({"check", "s.yaml", "--engine", "exact", "--set", "engine.type=direct"}, "--engine");
  expect_named({"check", "s.yaml", "--overwrite"}, "--overwrite");
  expect_named({"help", "run", "--format", "man"}, "--format");
  EXPECT_FALSE(exists("out"));
}

TEST_F(OptionPairs, OfStudies) {
  write("study.yaml", "version: 1\nbase: s.yaml\nvary:\n  - motion.plunge.depth_mm: [0.5, 1]\n");
  expect_named({"sweep", "submit", "study.yaml", "--parallel", "--to", "scripts", "--time-limit", "00:10:00"},
               "--time-limit");
  const std::string sample = "version: 1\nbase: s.yaml\nsample: {n: 8, of: {cutting.normal_ratio: {uniform: [0, 1]}}";
  write("uq.yaml", sample + ", method: latin_hypercube}\n");
  expect_named({"uq", "uq.yaml"}, "sample.method");
  write("uq.yaml", sample + "}\nkeep: [pictures]\n");
  expect_named({"uq", "uq.yaml"}, "keep");
  EXPECT_FALSE(exists("scripts"));
  EXPECT_FALSE(exists("out"));
}

TEST_F(OptionPairs, OfAFirstScenario) {
  write("bone.vdb", "");
  expect_named({"init", "bone.vdb", "-o", "my.yaml", "--side", "right"}, "bone.vdb: is a VDB file");
  std::filesystem::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path("bone.stl"));
  expect_named({"init", "bone.stl", "-o", "my.yaml", "--side", "left", "--threshold-hu", "300"}, "--threshold-hu");
  EXPECT_FALSE(exists("my.yaml"));
}

TEST_F(OptionPairs, OfAFit) {
  const auto fit = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"fit", "out", "measured.csv"});
    return more;
  };
  expect_named(fit({"--class-edges", "0.5,1"}), "--class-edges: has no effect with --model law");
  expect_named(fit({"--model", "classes", "--class-edges", "1,0.5"}), "--class-edges: found 0.5");
  expect_named(fit({"--model", "classes", "--class-edges", "0,1"}), "--class-edges: found 0");
  for (const char* same : {"same", "./same"}) expect_named(fit({"-o", "same", "--residuals", same}), "--residuals");
}

TEST_F(OptionPairs, OfPicturesDrawnAgain) {
  expect_done(run(kSmall));
  const auto render = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"render", "out"});
    return more;
  };
  expect_named(render({"--only", "pictures", "--film"}), "--film: has no effect");
  expect_named(render({"--only", "pictures", "--turntable", "8"}), "--turntable: has no effect");
  expect_named(render({"--only", "turntable", "--turntable", "0"}), "--turntable: found 0");
  expect_named(render({"--film-rate", "5"}), "--film-rate: has no effect");
  for (const char* size : {"--width", "--height"}) {
    expect_named(render({"--only", "plots", size, "200"}), std::string(size) + ": has no effect");
    expect_named(render({size, "0"}), std::string("render.") + (size + 2) + "_px");
  }
  expect_named(render({"--only", "meshes", "--camera", "oblique"}), "--camera: has no effect");
  EXPECT_FALSE(exists("out/reamed.stl"));
  EXPECT_EQ(call(render({"--only", "meshes"})).status, 0) << "though the run had none";
  EXPECT_TRUE(exists("out/reamed.stl"));
  EXPECT_EQ(call(render({"--only", "report", "--set", "render.report=false"})).status, 0);
  EXPECT_TRUE(exists("out/report.html"));
}

}  // namespace
}  // namespace reamsim::test
