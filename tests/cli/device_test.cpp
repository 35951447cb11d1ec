// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class Device : public CliTest {
 protected:
  ProgramResult run_with(const std::map<std::string, std::string>& environment, const std::string& device) const {
    write("s.yaml", kSmall);
    return reamsim({.arguments = {"run", "s.yaml", "-o", "out", "--device", device},
                    .environment = environment,
                    .folder = "",
                    .interrupt_when = {}});
  }
  /// An OpenCL loader that finds no platform.
  std::map<std::string, std::string> no_opencl() const {
    std::filesystem::create_directories(path("no-vendors"));
    return {{"OCL_ICD_VENDORS", path("no-vendors")}, {"OCL_ICD_FILENAMES", ""}};
  }
  bool has_opencl() const {
    const ProgramResult result =
        reamsim({.arguments = {"devices"}, .environment = {}, .folder = "", .interrupt_when = {}});
    return result.out.find("auto selects") != std::string::npos && result.out.find("* ") != std::string::npos;
  }
};

TEST_F(Device, NoOpenClPlatform) {
  expect_refused(run_with(no_opencl(), "auto"), 1, {"OpenCL", "--device serial"});
}

TEST_F(Device, SerialNeedsNoOpenCl) {
  expect_done(run_with(no_opencl(), "serial"));
}

TEST_F(Device, DevicesWithoutOpenCl) {
  const ProgramResult result =
      reamsim({.arguments = {"devices"}, .environment = no_opencl(), .folder = "", .interrupt_when = {}});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("serial"));
}

TEST_F(Device, ADeviceWithoutAtomicsOf64BitsGivesTheSameForces) {
  const std::string variable = "REAMSIM_DEVICE_WITHOUT";
  expect_refused(run_with({{variable, "int63_atomics"}}, "auto"), 2, {"REAMSIM_DEVICE_WITHOUT", "int64_atomics"});
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device";
  const ProgramResult listed = reamsim(
      {.arguments = {"devices"}, .environment = {{variable, "int64_atomics"}}, .folder = "", .interrupt_when = {}});
  EXPECT_THAT(listed.out, HasSubstr("two atomics of 32 bits"));
  expect_done(run_with({{variable, "int64_atomics"}}, "auto"));
  const std::string forces = read("out/forces.csv");
  std::filesystem::remove_all(path("out"));
  expect_done(run_with({}, "auto"));
  EXPECT_EQ(read("out/forces.csv"), forces);
}

/// Devices other than that of this machine (opencl_shim.cpp).
class OtherDevice : public Device {
 protected:
  void SetUp() override {
    Device::SetUp();
    if (!has_opencl()) GTEST_SKIP() << "no OpenCL device";
    std::filesystem::remove_all(path("out"));
  }
  static std::map<std::string, std::string> shown(const std::string& settings, const std::string& without = "") {
    return {
        {"LD_PRELOAD", REAMSIM_OPENCL_SHIM}, {"REAMSIM_TEST_DEVICE", settings}, {"REAMSIM_DEVICE_WITHOUT", without}};
  }
  ProgramResult call(const std::vector<std::string>& arguments, const std::string& settings) const {
    return reamsim({.arguments = arguments, .environment = shown(settings), .folder = "", .interrupt_when = {}});
  }
  /// forces.csv of kSmall with these settings of the scenario.
  std::string forces(const std::vector<std::string>& settings, const std::map<std::string, std::string>& environment) {
    write("s.yaml", kSmall);
    std::vector<std::string> arguments{"run", "s.yaml", "-o", "out", "--overwrite"};
    for (const std::string& setting : settings) arguments.push_back("--set=" + setting);
    expect_done(reamsim({.arguments = arguments, .environment = environment, .folder = "", .interrupt_when = {}}));
    return read("out/forces.csv");
  }
};

TEST_F(OtherDevice, AGpuWithNothingOptionalGivesTheBytesOfSerial) {
  const std::vector<std::vector<std::string>> engines{
      {"engine.type=exact"},
      {"engine.type=bricked", "cutting.erosion=remove"},
      {"engine.type=bricked", "cutting.erosion=wear", "cutting.wear_g_cm3_per_s=30"},
      {"engine.type=bricked", "cutting.erosion=remove", "cutting.law=per_point"},
      {"engine.type=direct", "cutting.erosion=remove"},
      {"engine.type=octree", "cutting.erosion=remove", "cutting.law=per_point"},
      {"engine.type=implicit", "cutting.erosion=remove"}};
  for (std::vector<std::string> settings : engines) {
    SCOPED_TRACE(settings.front() + " " + settings.back());
    const std::string expected = forces(settings, {});
    settings.push_back("engine.device=auto");
    EXPECT_EQ(forces(settings, shown("gpu,least", "fp64,int64_atomics,rounded_division")), expected);
  }
}

TEST_F(OtherDevice, LongKernelsOfAGpuAreSplitAndGiveTheSameBytes) {
  const std::string expected = forces({}, {});
  EXPECT_EQ(forces({"engine.device=auto"}, shown("gpu,slow")), expected);
}

TEST_F(OtherDevice, OutOfResourcesKeepsWhatIsFinishedAndGoesOn) {
  const std::string expected = forces({}, {});
  std::filesystem::remove_all(path("out"));
  const std::vector<std::string> run{"run",
                                     "s.yaml",
                                     "-o",
                                     "out",
                                     "--device",
                                     "auto",
                                     "--resume",
                                     "--set=output.checkpoint_s=0.001",
                                     "--set=engine.batch_frames=1"};
  const ProgramResult failed = call(run, "fails=20");
  EXPECT_EQ(failed.status, 1);
  for (const char* part : {"out of resources", "out.partial", "is saved", "--resume"})
    EXPECT_THAT(failed.err, HasSubstr(part));
  const ProgramResult resumed = call(run, "");
  expect_done(resumed);
  EXPECT_THAT(resumed.out, HasSubstr("continued after frame"));
  EXPECT_EQ(read("out/forces.csv"), expected);
}

TEST_F(OtherDevice, OneOfTwoOfTheSameNameIsChosenByItsNumber) {
  write("s.yaml", kSmall);
  if (call({"devices"}, "").out.find("[Portable Computing Language") == std::string::npos) GTEST_SKIP() << "no PoCL";
  const auto run_on = [&](const std::string& device) {
    return call({"run", "s.yaml", "-o", "out", "--overwrite", "--device", device}, "twice");
  };
  expect_done(run_on("portable computing#2"));
  std::filesystem::remove_all(path("out"));
  expect_refused(run_on("portable computing#3"), 2, {"engine.device", "2 match the name", "#N"});
}

TEST_F(OtherDevice, AStudyGoesOnWhereADeviceIsGone) {
  write("s.yaml", kSmall);
  write("study.yaml",
        "version: 1\nbase: s.yaml\nvary:\n  - motion.plunge.depth_mm: [0.5, 0.6, 0.7, 0.8]\nkeep: [summary]\n");
  const auto sweep = [&](const std::string& devices, const std::string& settings, const std::string& out) {
    return call({"sweep", "run", "study.yaml", "-o", out, "--jobs", "1", "--devices", devices}, settings);
  };
  expect_refused(sweep("serial,nonexistent", "", "refused"), 2, {"engine.device", "nonexistent"});
  EXPECT_FALSE(exists("refused"));
  const ProgramResult partial = sweep("serial,auto", "gone", "out");
  EXPECT_EQ(partial.status, 1);
  EXPECT_THAT(partial.out + partial.err, HasSubstr("device not available"));
  EXPECT_THAT(partial.err, HasSubstr("runs failed; the others are complete; the same command repeats"));
  const ProgramResult lost = sweep("auto", "gone", "lost");
  EXPECT_EQ(lost.status, 1);
  EXPECT_THAT(lost.err, HasSubstr("no device is left"));
  // One that fails in mid run leaves a checkpoint, from which another device goes on.
  const auto sweep_with_checkpoints = [&](const std::string& devices, const std::string& settings) {
    return call({"sweep", "run", "--devices", devices, "study.yaml", "-o", "failed", "--jobs", "1",
                 "--set=output.checkpoint_s=0.001", "--set=engine.batch_frames=1"},
                settings);
  };
  EXPECT_EQ(sweep_with_checkpoints("auto", "fails=20").status, 1);
  const ProgramResult continued = sweep_with_checkpoints("serial", "");
  EXPECT_EQ(continued.status, 0) << continued.err;
  EXPECT_THAT(continued.out, HasSubstr("continued after frame"));
  EXPECT_EQ(sweep("serial,auto", "", "out").status, 0);
  EXPECT_EQ(sweep("serial", "", "serial").status, 0);
  const auto sums = [&](const std::string& folder) {
    const std::string table = read(folder + "/effects.csv");
    EXPECT_FALSE(table.empty());
    return table;
  };
  EXPECT_EQ(sums("out"), sums("serial"));
}

TEST_F(Device, NameThatMatchesNothing) {
  expect_refused(run_with({}, "nonexistent"), 2, {"engine.device", "nonexistent", "serial"});
}

TEST_F(Device, KernelThatDoesNotBuildShowsItsLog) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  std::filesystem::create_directory(path("kernels"));
  write("kernels/cut_exact.cl", "__kernel void cut_exact(__global int* out) { *out = no_such_name; }\n");
  const ProgramResult result = run_with({{"REAMSIM_KERNEL_DIR", path("kernels")}}, "auto");
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_THAT(result.err, HasSubstr("reamsim: error: "));
  EXPECT_THAT(result.err, HasSubstr("cut_exact"));
  EXPECT_THAT(result.err, HasSubstr("no_such_name")) << "the compiler's log";
  EXPECT_FALSE(exists("out"));
  EXPECT_FALSE(exists("out.partial"));
}

TEST_F(Device, OpenClAgreesWithSerialToTheLastByte) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  expect_done(run_with({}, "auto"));
  const std::string forces = read("out/forces.csv");
  std::filesystem::remove_all(path("out"));
  expect_done(run_with({}, "serial"));
  EXPECT_TRUE(read("out/forces.csv") == forces);
}

}  // namespace
}  // namespace reamsim::test
