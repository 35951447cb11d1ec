#include <algorithm>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class Compare : public CliTest {
 protected:
  ProgramResult compare(const std::vector<std::string>& dirs, const std::vector<std::string>& more = {}) const {
    ProgramCall call{.arguments = {"compare"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), dirs.begin(), dirs.end());
    call.arguments.insert(call.arguments.end(), {"-o", "out"});
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    return reamsim(call);
  }
  /// A run's results in the folder `name`.
  void make_run(const std::string& name, const std::string& yaml) const {
    expect_done(run(yaml));
    std::filesystem::rename(path("out"), path(name));
  }
  /// What compare.csv says of a metric and a run: value, difference, relative difference.
  std::vector<std::string> row(const std::string& metric, const std::string& label) const {
    const std::string csv = read("out/compare.csv");
    const std::string start = "\n" + metric + "," + label + ",";
    const std::size_t at = csv.find(start);
    EXPECT_NE(at, std::string::npos) << start;
    if (at == std::string::npos) return {"", "", ""};
    const std::size_t from = at + start.size();
    const std::string cells = csv.substr(from, csv.find('\n', from) - from);
    const std::size_t first = cells.find(',');
    const std::size_t second = cells.find(',', first + 1);
    return {cells.substr(0, first), cells.substr(first + 1, second - first - 1), cells.substr(second + 1)};
  }
};

TEST_F(Compare, RunsOfOtherFrameRatesBonesAndErosionsCompare) {
  make_run("coarse", with(kSmall, "frame_rate_hz: 100", "frame_rate_hz: 50"));
  make_run("fine, \"deep\"",
           with(with(kSmall, "depth_mm: 1", "depth_mm: 1.5"), "size_mm: [10, 10, 6]", "size_mm: [12, 9, 7]"));
  make_run("whole", kSmall + "cutting:\n  erosion: remove\n");
  const ProgramResult result = compare({"coarse", "fine, \"deep\"", "whole"});
  EXPECT_EQ(result.status, 0) << result.err;
  for (const char* file : {"compare.csv", "curves.csv", "compare.png", "compare.svg", "compare.pdf", "compare.gp"}) {
    EXPECT_TRUE(exists(std::string("out/") + file)) << file;
  }
  EXPECT_FALSE(exists("out.partial"));
  const std::string deep = "\"fine, \"\"deep\"\"\"";
  const double first = number_after(read("coarse/summary.json"), "\"removed_mm3\": ");
  const double second = number_after(read("fine, \"deep\"/summary.json"), "\"removed_mm3\": ");
  EXPECT_DOUBLE_EQ(std::stod(row("removed_mm3", "coarse")[0]), first);
  EXPECT_EQ(row("removed_mm3", "coarse")[1], "0");
  EXPECT_DOUBLE_EQ(std::stod(row("removed_mm3", deep)[1]), second - first);
  EXPECT_DOUBLE_EQ(std::stod(row("removed_mm3", deep)[2]), (second - first) / first);
  EXPECT_GT(second, 1.2 * first) << "the runs differ";
  EXPECT_THAT(result.out, HasSubstr("removed_mm3"));
  EXPECT_THAT(result.out, HasSubstr("fine, \"deep\""));
  const std::string svg = read("out/compare.svg");
  for (const char* words :
       {"coarse", "Axial force (N)", "Spin torque", "Removed volume", "Time (s)", "Tool depth (mm)"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
  const std::string curves = read("out/curves.csv");
  for (const char* begin : {"\n1,", "\n2,", "\n3,"}) EXPECT_THAT(curves, HasSubstr(begin));
}

TEST_F(Compare, WrongFoldersAreRefusedAndNothingIsWritten) {
  make_run("one", kSmall);
  std::filesystem::create_directory(path("empty"));
  write("file", "text");
  expect_refused(compare({"one"}), 2, {"give two or more"});
  expect_refused(compare({"one", "missing"}), 2, {"missing: ", "folder not found"});
  expect_refused(compare({"one", "file"}), 2, {"file: ", "folder not found"});
  expect_refused(compare({"one", "empty"}), 2, {"empty: ", "summary.json"});
  expect_refused(compare({"one", "./one/../one"}), 2, {"folder given twice"});
}

TEST_F(Compare, DamagedResultsAreRefusedAndNothingIsWritten) {
  make_run("one", kSmall);
  const auto damaged = [&](const char* file, const std::string& text) {
    std::filesystem::remove_all(path("two"));
    std::filesystem::copy(path("one"), path("two"), std::filesystem::copy_options::recursive);
    write(std::string("two/") + file, text);
    return compare({"one", "two"});
  };
  expect_refused(damaged("summary.json", read("one/summary.json").substr(0, 200)), 2, {"two/summary.json", "damaged"});
  expect_refused(damaged("summary.json", "[]"), 2, {"two/summary.json", "damaged"});
  expect_refused(damaged("forces.csv", "frame,time_s\n1,2\n"), 2, {"two/forces.csv", "no such column"});
  expect_refused(damaged("forces.csv", read("one/forces.csv").substr(0, 900)), 2, {"two/forces.csv"});
  expect_refused(damaged("scenario.yaml", "cutting: [\n"), 2, {"two/scenario.yaml"});
}

TEST_F(Compare, AnOldFolderIsLeftAloneWithoutOverwrite) {
  make_run("one", kSmall);
  make_run("two", with(kSmall, "depth_mm: 1", "depth_mm: 1.2"));
  ASSERT_EQ(compare({"one", "two"}).status, 0);
  write("out/compare.csv", "old");
  const ProgramResult refused = compare({"one", "two"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("--overwrite"));
  EXPECT_EQ(read("out/compare.csv"), "old");
  EXPECT_EQ(compare({"one", "two"}, {"--overwrite", "--quiet"}).status, 0);
  EXPECT_NE(read("out/compare.csv"), "old");
  EXPECT_TRUE(exists("out/compare.png"));
}

TEST_F(Compare, AFoldersNameRunsNoCommand) {
  make_run("one", kSmall);
  for (const std::string name :
       {"z`touch PWN` $(touch PWN) 'touch PWN'", "@PWN \"; system 'touch PWN' #", "a'\nb{:Bold c}"}) {
    std::filesystem::copy(path("one"), path(name), std::filesystem::copy_options::recursive);
    const ProgramResult result = compare({"one", name});
    EXPECT_EQ(result.status, 0) << result.err;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(dir_)) {
      EXPECT_NE(entry.path().filename(), "PWN") << name << ": " << entry.path();
    }
    std::filesystem::remove_all(path("out"));
  }
}

}  // namespace
}  // namespace reamsim::test
