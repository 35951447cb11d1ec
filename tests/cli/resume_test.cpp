// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Runs that are interrupted and continued end with the bytes of a run without interruption.
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kSuspended = 75, kInterrupted = 130;

/// Thousands of frames, with snapshots.
const std::string kLong =
    with(with(with(kSmall, "feed_mm_s: 5", "feed_mm_s: 0.06"), "  enabled: false\n",
              "  enabled: false\n  every_frames: 999\n"),
         "engine:\n  device: serial\n", "engine:\n  batch_frames: 10\noutput:\n  checkpoint_s: 0.05\n");

class Resume : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& more, const std::function<bool()>& when = {},
                     int signal = SIGINT) const {
    ProgramCall call{
        .arguments = {"run", "s.yaml", "--quiet"}, .environment = {}, .folder = "", .interrupt_when = when};
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    call.interrupt_signal = signal;
    return reamsim(call);
  }

  /// Rows of the log in a folder, and the header.
  std::ptrdiff_t rows(const std::string& dir) const {
    if (!exists(dir + "/forces.csv")) return 0;
    const std::string log = read(dir + "/forces.csv");
    return std::ranges::count(log, '\n');
  }
  auto has_rows(const std::string& dir, std::ptrdiff_t least) const {
    return [this, dir, least] { return rows(dir) > least; };
  }
  /// Once the log in "cut.partial" has this fraction of the bytes of that in "whole". It is not read, over and over,
  /// which would slow the run down.
  auto has_written(double fraction) const {
    const auto bytes = static_cast<double>(fs::file_size(path("whole/forces.csv")));
    return [this, least = fraction * bytes] {
      std::error_code none_yet;
      const auto written = fs::file_size(path("cut.partial/forces.csv"), none_yet);
      return !none_yet && static_cast<double>(written) > least;
    };
  }

  /// Both folders hold the same results; times and memory may differ.
  void expect_same_results(const std::string& a, const std::string& b) const {
    for (const auto& entry : fs::recursive_directory_iterator(path(a))) {
      const std::string file = fs::relative(entry.path(), path(a)).string();
      if (!entry.is_regular_file() || file == "timings.csv" || file == "scenario.yaml") continue;
      if (file == "summary.json" || file.ends_with(".pdf")) continue;  // a PDF holds its date
      EXPECT_TRUE(read(a + "/" + file) == read(b + "/" + file)) << file;
    }
    auto summary_a = nlohmann::json::parse(read(a + "/summary.json")),
         summary_b = nlohmann::json::parse(read(b + "/summary.json"));
    for (const char* key : {"timings_s", "memory_mb", "inputs"}) {
      summary_a.erase(key);
      summary_b.erase(key);
    }
    EXPECT_EQ(summary_a, summary_b);
    EXPECT_EQ(std::distance(fs::recursive_directory_iterator(path(a)), {}),
              std::distance(fs::recursive_directory_iterator(path(b)), {}));
  }
};

TEST_F(Resume, ResultsThatWereCompleteWhenTheirProcessWasKilledAreMoved) {
  write("s.yaml", kSmall);
  expect_done(run(kSmall));
  const std::string forces = read("out/forces.csv");
  fs::rename(path("out"), path("out.partial"));
  const ProgramResult other =
      reamsim({.arguments = {"run", "s.yaml", "-o", "out", "--resume", "--set", "motion.plunge.depth_mm=2"},
               .environment = {},
               .folder = "",
               .interrupt_when = {}});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("holds the complete results of another scenario"));
  EXPECT_EQ(read("out.partial/forces.csv"), forces);
  const ProgramResult same = run(kSmall, {"--resume"});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_THAT(same.out, HasSubstr("the results were complete"));
  EXPECT_EQ(read("out/forces.csv"), forces);
  EXPECT_FALSE(exists("out.partial"));
}

TEST_F(Resume, EndsWithTheSameBytesForEveryErosionAndEngine) {
  const std::string teeth =
      with(kLong, "/assets/reamer_flat.stl\n", "/assets/reamer_convex_edges.stl\n  spin: resolved\n");
  const std::string passes = kLong.substr(0, kLong.find("  plunge:\n")) +
                             "  passes:\n"
                             "  - plunge: {approach_mm: 0.3, feed_mm_s: 0.06, depth_mm: 0.4, retract_mm: 2}\n"
                             "  - tool: {mesh: " REAMSIM_ROOT
                             "/assets/reamer_hemispherical.stl, scale: 0.3}\n"
                             "    plunge: {approach_mm: 0, feed_mm_s: 0.06, depth_mm: 0.8, retract_mm: 2}\n" +
                             kLong.substr(kLong.find("render:\n"));
  const std::vector<std::pair<std::string, std::string>> cases{
      {"exact", kLong},
      {"several passes", passes},
      {"force basis", with(passes, "output:\n", "output:\n  force_basis: true\n")},
      {"force basis of removed voxels",
       with(kLong, "output:\n", "output:\n  force_basis: true\n") + "cutting: {erosion: remove}\n"},
      {"exact with teeth",
       with(with(teeth, "plunge:\n", "plunge:\n    spin_rpm: 100\n"), "feed_mm_s: 0.06", "feed_mm_s: 0.4")},
      {"serial", with(kLong, "batch_frames: 10\n", "batch_frames: 10\n  device: serial\n")},
      {"bricked", kLong + "cutting: {erosion: remove}\n"},
      {"wear", kLong + "cutting: {erosion: wear, wear_g_cm3_per_s: 2}\n"},
      {"direct", with(kLong, "engine:\n", "engine:\n  type: direct\n") + "cutting: {erosion: remove}\n"}};
  for (const auto& [name, yaml] : cases) {
    SCOPED_TRACE(name);
    for (const char* dir : {"whole", "cut", "cut.partial"}) fs::remove_all(path(dir));
    write("s.yaml", yaml);
    ASSERT_EQ(call({"-o", "whole"}).status, 0);
    const std::ptrdiff_t all = rows("whole");
    const std::vector<double> fractions =
        (name == "exact" || name == "several passes") ? std::vector{0.2, 0.6} : std::vector{0.3};
    for (const double fraction : fractions) {
      ProgramResult cut = call({"-o", "cut", "--resume"}, has_written(fraction));
      // On a busy machine the signal may come after the last frame.
      for (int again = 0; again < 3 && cut.status == kInterrupted; ++again) {
        fs::remove_all(path("cut.partial"));
        cut = call({"-o", "cut", "--resume"}, has_written(fraction));
      }
      EXPECT_EQ(cut.status, kSuspended) << cut.err;
      EXPECT_THAT(cut.err, HasSubstr("--resume continues"));
      EXPECT_LT(rows("cut.partial"), all);
    }
    const ProgramResult done = call({"-o", "cut", "--resume"});
    ASSERT_EQ(done.status, 0) << done.err;
    expect_same_results("whole", "cut");
  }
}

TEST_F(Resume, KilledRunsContinueFromTheirLastCheckpoint) {
  write("s.yaml", kLong);
  ASSERT_EQ(call({"-o", "whole"}).status, 0);
  for (const double fraction : {0.15, 0.4, 0.7}) {
    EXPECT_EQ(call({"-o", "cut", "--resume"}, has_written(fraction), SIGKILL).signal, SIGKILL);
    EXPECT_TRUE(exists("cut.partial/scenario.yaml"));
  }
  ASSERT_EQ(call({"-o", "cut", "--resume"}).status, 0);
  expect_same_results("whole", "cut");
}

TEST_F(Resume, AnUnfinishedRunCanBeRenderedAndCompared) {
  plots_ = true;  // and meshes
  const std::string drawn =
      with(kLong, "enabled: false", "width_px: 96\n  height_px: 72\n  cameras: [oblique]\n  report: false");
  write("s.yaml", with(drawn, "voxel_mm: 0.5", "voxel_mm: 0.2"));  // slow enough to be interrupted
  ASSERT_EQ(call({"-o", "whole"}).status, 0);
  const auto has_pictures = [this] { return exists("cut.partial/frames/000999.png"); };
  ASSERT_EQ(call({"-o", "cut"}, has_pictures).status, kSuspended);
  fs::remove_all(path("cut.partial/frames"));
  const ProgramResult render =
      reamsim({.arguments = {"render", "cut.partial"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(render.status, 0) << render.err;
  EXPECT_TRUE(exists("cut.partial/reamed.png"));
  EXPECT_TRUE(read("cut.partial/frames/000999.png") == read("whole/frames/000999.png"));
  const ProgramResult compare = reamsim(
      {.arguments = {"compare", "whole", "cut.partial"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(compare.status, 0) << compare.err;
  EXPECT_THAT(compare.out, HasSubstr("removed_mm3"));
  ASSERT_EQ(call({"-o", "cut", "--resume"}).status, 0);
  expect_same_results("whole", "cut");
}

// As an attempt leaves it that is killed after its simulation; the next one continues from a checkpoint before that.
TEST_F(Resume, AGridOfAnEarlierAttemptDoesNotMakeARunLookFinished) {
  write("s.yaml", kLong);
  ASSERT_EQ(call({"-o", "cut"}, has_rows("cut.partial", 1500)).status, kSuspended);
  write("cut.partial/reamed.vdb", "of an earlier attempt");
  const auto has_begun = [this] { return !exists("cut.partial/reamed.vdb"); };
  ASSERT_NE(call({"-o", "cut", "--resume"}, has_begun, SIGKILL).status, 0) << "the grid stayed until it was replaced";
  const ProgramResult render =
      reamsim({.arguments = {"render", "cut.partial", "--only", "pictures", "--width", "96", "--height", "72"},
               .environment = {},
               .folder = "",
               .interrupt_when = {}});
  EXPECT_EQ(render.status, 0) << render.err;
}

TEST_F(Resume, ADamagedCheckpointFallsBackToTheOther) {
  write("s.yaml", with(kLong, "checkpoint_s: 0.05", "checkpoint_s: 0.01"));  // two of them early in the run
  ASSERT_EQ(call({"-o", "whole"}).status, 0);
  const auto both = [this] { return exists("cut.partial/checkpoint-0.bin") && exists("cut.partial/checkpoint-1.bin"); };
  ASSERT_EQ(call({"-o", "cut"}, both).status, kSuspended);
  for (const char* file : {"cut.partial/checkpoint-0.bin", "cut.partial/checkpoint-1.bin"}) {
    fs::copy(path("cut.partial"), path("copy"), fs::copy_options::recursive);
    std::string bytes = read(file);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    write(file, bytes);
    const ProgramResult done = call({"-o", "cut", "--resume"});
    ASSERT_EQ(done.status, 0) << done.err;
    expect_same_results("whole", "cut");
    fs::remove_all(path("cut"));
    fs::rename(path("copy"), path("cut.partial"));
  }
}

TEST_F(Resume, ALogWithAPassThatNoRunHasIsRefused) {
  write("s.yaml", kLong);
  ASSERT_EQ(call({"-o", "cut"}, has_rows("cut.partial", 100)).status, kSuspended);
  std::string log = read("cut.partial/forces.csv");
  const std::size_t end = log.find('\n', log.find('\n') + 1);  // of the first row, whose last column is the pass
  ASSERT_EQ(log.substr(end - 2, 2), ",1");
  log[end - 1] = '0';
  write("cut.partial/forces.csv", log);
  expect_refused(call({"-o", "cut", "--resume"}), 2, {"forces.csv:2: pass: out of range"});
}

TEST_F(Resume, AnotherScenarioOrInputIsRefusedByName) {
  fs::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path("tool.stl"));
  const std::string yaml = with(kLong, REAMSIM_ROOT "/assets/reamer_flat.stl", "tool.stl");
  write("s.yaml", yaml);
  ASSERT_EQ(call({"-o", "out"}, has_rows("out.partial", 200)).status, kSuspended);
  const auto expect_named = [this](const std::vector<std::string>& more, const std::string& name) {
    std::vector<std::string> arguments{"-o", "out", "--resume"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = call(arguments);
    EXPECT_EQ(result.status, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(name));
    EXPECT_THAT(result.err, HasSubstr("has changed since the checkpoint"));
    EXPECT_TRUE(exists("out.partial/checkpoint-0.bin")) << "kept";
  };
  expect_named({"--set", "motion.plunge.depth_mm=0.9"}, "motion.plunge.depth_mm");
  expect_named({"--set", "cutting.friction_fraction=0.4"}, "cutting.friction_fraction");
  fs::copy(REAMSIM_ROOT "/assets/reamer_convex.stl", path("tool.stl"), fs::copy_options::overwrite_existing);
  expect_named({}, "tool.stl");
  fs::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path("tool.stl"), fs::copy_options::overwrite_existing);
  EXPECT_EQ(call({"-o", "out", "--resume", "--set", "output.checkpoint_s=30"}).status, 0) << "changes no result";
}

TEST_F(Resume, WithoutACheckpointItStartsAtTheFirstFrame) {
  write("s.yaml", kSmall);
  EXPECT_EQ(call({"-o", "out", "--resume"}).status, 0);
  EXPECT_EQ(call({"-o", "out", "--resume"}).status, 2) << "finished";
  fs::create_directory(path("new.partial"));
  write("new.partial/forces.csv", "frame\n");
  write("new.partial/checkpoint-0.bin", "damaged");
  EXPECT_EQ(call({"-o", "new", "--resume"}).status, 0);
  EXPECT_EQ(read("out/forces.csv"), read("new/forces.csv"));
}

TEST_F(Resume, EverySignalOfABatchSystemSavesTheRun) {
  write("s.yaml", with(kLong, "dwell_s: 0", "dwell_s: 3600"));
  for (const int signal : {SIGTERM, SIGHUP, SIGUSR1}) {
    SCOPED_TRACE(signal);
    const std::string dir = "out" + std::to_string(signal);
    EXPECT_EQ(call({"-o", dir}, has_rows(dir + ".partial", 100), signal).status, kSuspended);
    EXPECT_TRUE(exists(dir + ".partial/checkpoint-0.bin"));
  }
  EXPECT_EQ(call({"-o", "none", "--set", "output.checkpoint_s=0"}, has_rows("none.partial", 100)).status, 130);
  EXPECT_FALSE(exists("none.partial/checkpoint-0.bin"));
}

TEST_F(Resume, EveryCommandEndsSoonAfterASignal) {
  // Loading this bone takes several seconds.
  write("s.yaml", with(with_bone("  source: phantom\n  side: left\n  voxel_mm: 0.08\n"), "  device: serial\n",
                       "  batch_frames: 1\n"));
  const std::vector<std::vector<std::string>> commands{{"run", "s.yaml", "-o", "out"},
                                                       {"check", "s.yaml"},
                                                       {"import", "s.yaml", "-o", "bone.vdb"},
                                                       {"verify", "-o", "verification"},
                                                       {"bench", "-o", "benchmark"}};
  using Clock = std::chrono::steady_clock;
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command.front());
    const auto start = Clock::now();
    Clock::time_point signalled;
    const auto when = [&] {
      if (Clock::now() - start < std::chrono::milliseconds(700)) return false;
      signalled = Clock::now();
      return true;
    };
    const ProgramResult result =
        reamsim({.arguments = command, .environment = {}, .folder = "", .interrupt_when = when});
    EXPECT_EQ(result.status, 130) << result.err;
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - signalled).count(), 2) << "on a busy machine";
    EXPECT_EQ(std::distance(fs::directory_iterator(path(".")), {}), 1) << "nothing but the scenario is left";
  }
}

}  // namespace
}  // namespace reamsim::test
