// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <sys/stat.h>
#include <unistd.h>

#include <array>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// What shells and batch systems set up, through a shell.
class Environment : public CliTest {
 protected:
  Environment() {
    write("s.yaml", kSmall + "output: {meshes: false}\n");
    // The engine whose kernels are compiled fastest.
    write("opencl.yaml", with(kSmall, "device: serial", "device: auto\n  type: direct") +
                             "cutting: {erosion: remove}\noutput: {meshes: false, plots: false}\n");
  }
  /// Runs a shell's command line in the folder, where "reamsim" is the program.
  ProgramResult shell(const std::string& line, std::map<std::string, std::string> environment = {}) const {
    const std::string function = "reamsim() { '" REAMSIM_PROGRAM "' \"$@\"; }; ";
    return run_program("/bin/bash", {.arguments = {"-c", function + line},
                                     .environment = std::move(environment),
                                     .folder = dir_,
                                     .interrupt_when = {}});
  }
  void remove_results() const {
    std::filesystem::remove_all(path("out"));
    std::filesystem::remove_all(path("out.partial"));
  }
  /// The folder for compiled kernels where TMPDIR is the folder of the test.
  std::string private_kernels() const { return path("reamsim-kernels-" + std::to_string(geteuid())); }
  bool has_opencl() const { return shell("reamsim devices").out.find("* ") != std::string::npos; }
};

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose own address space is larger
TEST_F(Environment, LimitedAddressSpaceRunsOrIsNamed) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  for (const int megabytes : {50, 100, 150, 200, 300, 400, 500, 700, 1000, 1500}) {
    for (const char* scenario : {"s.yaml", "opencl.yaml"}) {
      const ProgramResult result =
          shell("ulimit -v " + std::to_string(1000 * megabytes) + "; reamsim run --quiet -o out " + scenario);
      SCOPED_TRACE(std::to_string(megabytes) + " MB, " + scenario + ": " + result.err);
      const bool loaded = result.err.find("loading shared libraries") == std::string::npos;
      if (!loaded) {
        EXPECT_EQ(result.status, 127) << "of the system's loader, before the program";
      }
      if (loaded && result.status != 0) {
        EXPECT_EQ(result.status, 1);
        EXPECT_THAT(result.err, HasSubstr("reamsim: error: "));
        EXPECT_THAT(result.err, HasSubstr("the address space is limited"));
        EXPECT_THAT(result.err, HasSubstr("ulimit -v"));
        EXPECT_THAT(result.err, Not(HasSubstr("no OpenCL platform")));
      }
      remove_results();
    }
  }
}

TEST_F(Environment, DevicesUnderALimitSayWhyTheyAreHidden) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  const ProgramResult result = shell("ulimit -v 400000; reamsim devices");
  EXPECT_EQ(result.status, 1) << result.out;
  EXPECT_THAT(result.err, HasSubstr("limited to 410 MB (ulimit -v)"));
  EXPECT_THAT(result.err, HasSubstr("--device serial"));
}
#endif

TEST_F(Environment, KernelsAreInAFolderOfTheUserWhereACacheCannotBeWrittenOrThereIsNoHome) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  // Nobody can make a folder in /proc, not even root.
  const std::map<std::string, std::string> none{{"POCL_CACHE_DIR", ""}, {"XDG_CACHE_HOME", ""}, {"TMPDIR", dir_}};
  for (const auto& [name, value] : std::map<std::string, std::string>{
           {"POCL_CACHE_DIR", "/proc/cache"}, {"XDG_CACHE_HOME", "/proc"}, {"HOME", "/proc"}}) {
    auto environment = none;
    environment[name] = value;
    const ProgramResult result = shell("reamsim run --verbose -o out opencl.yaml", environment);
    expect_done(result);
    EXPECT_THAT(result.err, Not(AnyOf(HasSubstr("reamsim: "), HasSubstr("generated"))))
        << "nothing matters to the user";
    EXPECT_THAT(result.out, HasSubstr("/proc/"));
    EXPECT_THAT(result.out, HasSubstr("(" + name + ") cannot be written"));
    EXPECT_THAT(result.out, HasSubstr("compiled kernels are in " + private_kernels()));
    EXPECT_FALSE(std::filesystem::is_empty(private_kernels()));
    remove_results();
    const ProgramResult check = shell("reamsim check opencl.yaml", environment);
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_THAT(check.out, HasSubstr("for the simulation")) << "the time estimate needs a device";
  }
  std::filesystem::remove_all(private_kernels());
  const ProgramResult result = shell("unset HOME; reamsim run --verbose -o out opencl.yaml", none);
  expect_done(result);
  EXPECT_THAT(result.out, HasSubstr("HOME is not set; compiled kernels are in " + private_kernels()));
  EXPECT_FALSE(std::filesystem::is_empty(private_kernels()));
  using std::filesystem::perms;
  EXPECT_EQ(std::filesystem::status(private_kernels()).permissions(), perms::owner_all) << "nobody else may add code";
}

TEST_F(Environment, KernelsOfSomebodyElseAreNotRun) {
  if (!has_opencl()) GTEST_SKIP() << "no OpenCL device here";
  const std::map<std::string, std::string> none{{"POCL_CACHE_DIR", ""}, {"XDG_CACHE_HOME", ""}, {"TMPDIR", dir_}};
  // What others may write, and a link to elsewhere, in place of the folder.
  std::filesystem::create_directory(path("elsewhere"));
  for (const bool link : {false, true}) {
    std::filesystem::remove_all(private_kernels());
    if (link) std::filesystem::create_directory_symlink("elsewhere", private_kernels());
    if (!link) std::filesystem::create_directory(private_kernels());
    if (!link) std::filesystem::permissions(private_kernels(), std::filesystem::perms::all);
    const ProgramResult result = shell("unset HOME; reamsim run --verbose -o out opencl.yaml", none);
    expect_done(result);
    EXPECT_THAT(result.out, HasSubstr("compiled kernels are in " + path("reamsim-kernels-")));
    EXPECT_THAT(result.out, Not(HasSubstr("in " + private_kernels() + ":")));
    EXPECT_TRUE(std::filesystem::is_empty(private_kernels()));
    remove_results();
  }
  int left = 0;
  for (const auto& entry : std::filesystem::directory_iterator(dir_)) {
    left += entry.path().filename().string().starts_with("reamsim-kernels") ? 1 : 0;
  }
  EXPECT_EQ(left, 1) << "the temporary folder of a run remains";
}

TEST_F(Environment, NoHomeAndNoTemporaryFolder) {
  const std::string scenario = has_opencl() ? "opencl.yaml" : "s.yaml";
  expect_done(shell("unset HOME; reamsim run --quiet -o out " + scenario));
  remove_results();
  const std::map<std::string, std::string> missing{
      {"HOME", path("none")}, {"TMPDIR", path("none/tmp")}, {"XDG_CACHE_HOME", path("none/cache")}};
  const ProgramResult result = shell(
      "reamsim run --quiet -o out s.yaml --set render.enabled=true --set "
      "render.width_px=64 --set render.height_px=64 --set render.cameras=[oblique] --set render.report=false",
      missing);
  expect_done(result);
  EXPECT_THAT(result.err, Not(HasSubstr("reamsim: "))) << "the driver of OpenGL may say that it has no cache";
}

TEST_F(Environment, NoSys) {
  std::filesystem::create_directory(path("empty"));
  const std::string hidden = "unshare -m /bin/bash -c 'mount --bind empty /sys && ";
  if (geteuid() != 0 || shell(hidden + "true'").status != 0) GTEST_SKIP() << "needs the right to mount";
  const std::string program = "\"" REAMSIM_PROGRAM "\" ";
  expect_refused(shell(hidden + program + "run --quiet -o out opencl.yaml'"), 1, {"/sys", "--device serial"});
  expect_done(shell(hidden + program + "run --quiet -o out s.yaml'"));
}

TEST_F(Environment, ClosedStreamsReceiveNothing) {
  expect_done(shell("reamsim run --quiet -o out s.yaml"));
  const std::string forces = read("out/forces.csv");
  for (const char* closed : {"<&-", ">&-", "2>&-", "<&- >&-", "<&- >&- 2>&-"}) {
    remove_results();
    const ProgramResult result = shell(std::string("reamsim run -o out s.yaml ") + closed);
    expect_done(result);
    EXPECT_TRUE(read("out/forces.csv") == forces) << closed;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path("out"))) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".csv" && extension != ".json" && extension != ".yaml") continue;
      EXPECT_THAT(file_bytes(entry.path().string()), Not(HasSubstr("frames, "))) << entry.path() << closed;
    }
  }
}

TEST_F(Environment, FullStandardOutput) {
  for (const char* command : {"check s.yaml", "devices", "--help", "--version", "run --help", "run s.yaml -o out"}) {
    const ProgramResult result = shell(std::string("reamsim ") + command + " > /dev/full");
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_THAT(result.err, HasSubstr("reamsim: error: standard output: cannot be written")) << command;
  }
  EXPECT_TRUE(exists("out/summary.json")) << "results are not lost";
  EXPECT_FALSE(exists("out.partial"));
  EXPECT_EQ(shell("reamsim run nix.yaml > /dev/full").status, 2) << "a mistake comes first";
}

TEST_F(Environment, AReaderThatLeavesIsNoError) {
  for (const char* command : {"check s.yaml", "devices", "--help", "run s.yaml -o out"}) {
    const ProgramResult result = shell(std::string("set -o pipefail; reamsim ") + command + " | true");
    EXPECT_EQ(result.status, 0) << command << result.err;
  }
  EXPECT_TRUE(exists("out/summary.json"));
}

class OddFile : public Environment {
 protected:
  ProgramResult check(const std::string& file) const { return shell("reamsim check " + file); }

  /// A mesh and a CT in a folder without search permission, named by a scenario and by a command.
  void expect_inputs_below_a_closed_folder(const std::string& as_user) const {
    shell("mkdir closed; touch closed/a.stl closed/a.nrrd; chmod 000 closed");
    for (const char* file : {"closed/a.stl", "closed/a.nrrd"}) {
      const ProgramResult result = shell(as_user + " import " + file + " -o b.vdb");
      expect_refused(result, 2, {file, "cannot be read (Permission denied)"});
    }
    write("s.yaml", with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", "closed/a.stl"));
    expect_refused(shell(as_user + " check s.yaml"), 2, {"closed/a.stl cannot be read (Permission denied)"});
    shell("chmod 755 closed");
  }
};

TEST_F(OddFile, ScenarioFromAPipe) {
  expect_done(shell("reamsim run --quiet -o out <(cat s.yaml)"));
  const ProgramResult late = shell("mkfifo pipe; (sleep 0.5; cat s.yaml) > pipe & reamsim check pipe");
  EXPECT_EQ(late.status, 0) << late.err;
  const ProgramResult piped = shell("cat s.yaml | reamsim check /dev/stdin");
  EXPECT_EQ(piped.status, 0) << piped.err;
}

TEST_F(OddFile, ScenarioFromAPipeWithoutAWriter) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  expect_refused(check("pipe"), 2, {"pipe: is a pipe into which nothing was written for 10 s"});
}

TEST_F(OddFile, Scenario) {
  write("empty", "");
  expect_refused(check("empty"), 2, {"empty: is empty"});
  expect_refused(check("/dev/null"), 2, {"/dev/null: is empty"});
  expect_refused(check("."), 2, {".: is a folder"});
  const ProgramResult endless = check("/dev/zero");
  expect_refused(endless, 2, {"/dev/zero: larger than 4 MiB"});
  std::filesystem::resize_file(path("empty"), 10'000'000'000);
  const ProgramResult sparse = check("empty");
  expect_refused(sparse, 2, {"empty: larger than 4 MiB"});
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(endless.peak_mb, 300);
  EXPECT_LT(sparse.peak_mb, 300);
#endif
}

/// Each key that names a file, with a file that is none, or that has no contents.
TEST_F(OddFile, Inputs) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  const std::string csv = with(kSmall, "  plunge:\n", "  csv: {path: FILE}\n");
  const std::string no_plunge = csv.substr(0, csv.find("    approach_mm")) + csv.substr(csv.find("render:"));
  const std::array<std::string, 5> scenarios{with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", "FILE"), no_plunge,
                                             with_bone("  source: mesh\n  voxel_mm: 1\n  mesh: {path: FILE}\n"),
                                             with_bone("  source: ct\n  voxel_mm: 1\n  ct: {path: FILE}\n"),
                                             with_bone("  source: vdb\n  voxel_mm: 1\n  vdb: {path: FILE}\n")};
  for (const std::string& scenario : scenarios) {
    for (const char* file : {"pipe", "/dev/zero"}) {
      write("s.yaml", with(scenario, "FILE", file));
      expect_refused(check("s.yaml"), 2, {file, "is a pipe, a device or a socket"});
    }
    for (const char* name : {"sparse.stl", "sparse.csv", "sparse.nrrd", "sparse.nii", "sparse.vdb"}) {
      write(name, "");
      std::filesystem::resize_file(path(name), 10'000'000'000);
      write("s.yaml", with(scenario, "FILE", name));
      const ProgramResult result = check("s.yaml");
      expect_refused(result, 2, {name});
#ifndef __SANITIZE_ADDRESS__
      EXPECT_LT(result.peak_mb, 500) << name;
#endif
    }
  }
}

TEST_F(OddFile, Unreadable) {
  // Root may read all files: it hands the folder to another user, who may not.
  constexpr const char* kNobody = "65534";
  std::string as_user = "reamsim";
  if (geteuid() == 0) {
    if (shell("setpriv --version").status != 0) GTEST_SKIP() << "runs as root, without setpriv";
    as_user = std::string("setpriv --reuid ") + kNobody + " --clear-groups '" REAMSIM_PROGRAM "'";
    std::filesystem::permissions(dir_, std::filesystem::perms::all);
    if (shell(as_user + " --version").status != 0) GTEST_SKIP() << "runs as root, and others cannot reach the program";
  }
  shell("cp '" REAMSIM_ROOT "/assets/reamer_flat.stl' tool.stl; chmod 000 tool.stl");
  write("t.yaml", with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", "tool.stl"));
  expect_refused(shell(as_user + " check t.yaml"), 2, {"tool.mesh", "tool.stl cannot be read", "read permission"});
  shell("chmod 000 t.yaml; mkdir shut; chmod 555 shut");
  expect_refused(shell(as_user + " check t.yaml"), 2, {"t.yaml: cannot be read (Permission denied)"});
  write("s.yaml", with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", "near.stl"));
  shell("cp '" REAMSIM_ROOT "/assets/reamer_flat.stl' near.stl");
  expect_refused(shell(as_user + " run s.yaml -o shut/out"), 2, {"shut/out", "output folder"});
  expect_inputs_below_a_closed_folder(as_user);
}

}  // namespace
}  // namespace reamsim::test
