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
  EXPECT_THAT(listed.out, HasSubstr("without 64-bit atomics"));
  expect_done(run_with({{variable, "int64_atomics"}}, "auto"));
  const std::string forces = read("out/forces.csv");
  std::filesystem::remove_all(path("out"));
  expect_done(run_with({}, "auto"));
  EXPECT_EQ(read("out/forces.csv"), forces);
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
