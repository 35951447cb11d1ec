// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "sim/base/text.h"
#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

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
  for (const char* file :
       {"compare.csv", "runs.csv", "curves.csv", "compare.png", "compare.svg", "compare.pdf", "compare.gp"}) {
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
  for (const char* words : {"coarse", "Axial force (N)", "Spin torque", "Removed volume",
                            "Time since first contact (s)", "Tool depth since first contact (mm)"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
  const std::string curves = read("out/curves.csv");
  for (const char* begin : {"\n1,", "\n2,", "\n3,"}) EXPECT_THAT(curves, HasSubstr(begin));
}

/// The characters of the longest line.
std::size_t widest_line(const std::string& text) {
  std::size_t widest = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    widest = std::max(widest, text_width(text.substr(at, end - at)));
    at = end + 1;
  }
  return widest;
}

TEST_F(Compare, KeysThatDifferAreColumns) {
  make_run("one", kSmall);
  make_run("two", with(kSmall, "depth_mm: 1", "depth_mm: 0.5") + "output:\n  vti: false\n");
  make_run("three", with(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 1"), "approach_mm: 0.5",
                         "entry_mm: [-1, 0, 0]\n    approach_mm: 0.5"));
  const ProgramResult result = compare({"one", "two", "three"});
  EXPECT_EQ(result.status, 0) << result.err;
  const std::string table = read("out/runs.csv");
  EXPECT_THAT(table, HasSubstr("run,label,bone.voxel_mm,motion.plunge.entry_mm,motion.plunge.depth_mm,force_law."));
  EXPECT_THAT(table, HasSubstr("\n1,one,0.5,\"[0, 0, 0]\",1,"));
  EXPECT_THAT(table, HasSubstr("\n2,two,0.5,\"[0, 0, 0]\",0.5,"));
  EXPECT_THAT(table, HasSubstr("\n3,three,1,\"[-1, 0, 0]\",1,"));
  EXPECT_EQ(table.find("bone.voxel_mm"), table.rfind("bone.voxel_mm")) << "no two columns of one name";
  EXPECT_THAT(table, Not(HasSubstr("output"))) << "a key without effect on numbers";
  EXPECT_THAT(result.out, HasSubstr("depth_mm"));
  EXPECT_LE(widest_line(result.out), 100u) << result.out;
}

TEST_F(Compare, TimeCountsFromTheFirstContact) {
  make_run("near", with(kSmall, "approach_mm: 0.5", "approach_mm: 0.1"));
  make_run("far", with(kSmall, "approach_mm: 0.5", "approach_mm: 2"));
  ASSERT_EQ(compare({"near", "far"}).status, 0);
  std::istringstream curves(read("out/curves.csv"));
  std::string line;
  std::getline(curves, line);
  EXPECT_EQ(line, "run,time_s,depth_mm,contact,axial_force_n,spin_torque_nmm,removed_mm3,contact_time_s");
  // Contact begins 0.38 s later; then force, depth and removed volume are the same at the same time since contact.
  std::map<long, std::vector<double>> near;
  int met = 0;
  while (std::getline(curves, line)) {
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    const long frame = std::lround(100 * row[7]);
    if (row[0] == 1) near[frame] = row;
    if (row[0] == 1 || row[3] == 0) continue;
    ASSERT_TRUE(near.contains(frame)) << line;
    EXPECT_NEAR(row[1] - near[frame][1], 0.38, 1e-9);
    for (const std::size_t column : {2, 4, 6}) EXPECT_NEAR(row[column], near[frame][column], 1e-6 * row[column] + 1e-9);
    ++met;
  }
  EXPECT_GE(met, 18) << "frames in contact";
}

TEST_F(Compare, ManyRunsHaveARampAndALegendOfNumbers) {
  const std::string long_name = "a run whose name is longer than a column of the table may be wide";
  std::vector<std::string> dirs;
  for (int i = 0; i < 21; ++i) {
    dirs.push_back(i == 7 ? long_name : "r" + std::to_string(i));
    std::filesystem::path copy = path(dirs.back());
    if (i == 0) {
      make_run("r0", kSmall);
    } else {
      std::filesystem::copy(path("r0"), copy, std::filesystem::copy_options::recursive);
    }
    const std::string energy = "specific_energy_j_mm3: ";
    write(dirs.back() + "/scenario.yaml", with(read("r0/scenario.yaml"), i == 0 ? "version" : energy + "0.15",
                                               i == 0 ? "version" : energy + std::to_string(0.1 + 0.01 * i)));
  }
  const ProgramResult result = compare(dirs);
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_LE(widest_line(result.out), 100u) << result.out;
  EXPECT_THAT(result.out, HasSubstr(" 8 [1] "));
  EXPECT_THAT(result.out, HasSubstr("\n[1] " + long_name + "\n"));
  EXPECT_THAT(result.out, HasSubstr("specific_energy_j_mm3"));
  EXPECT_THAT(read("out/compare.gp"), HasSubstr("colored_by = 'cutting.specific_energy_j_mm3'"));
  EXPECT_THAT(read("out/compare.svg"), HasSubstr("cutting.specific_energy_j_mm3"));
  dirs.pop_back();
  EXPECT_EQ(compare(dirs, {"--overwrite"}).status, 0);
  EXPECT_THAT(read("out/compare.gp"), HasSubstr("colored_by = ''")) << "20 runs have a style each";
  EXPECT_EQ(compare(dirs, {"--overwrite", "--color-by", "removed_mm3"}).status, 0);
  EXPECT_THAT(read("out/compare.gp"), HasSubstr("colored_by = 'removed_mm3'"));
}

TEST_F(Compare, AWrongKeyForColoursIsRefused) {
  make_run("one", kSmall);
  make_run("two", with(kSmall, "depth_mm: 1", "depth_mm: 0.5"));
  expect_refused(compare({"one", "two"}, {"--color-by", "bone.voxle_mm"}), 2,
                 {"--color-by", "bone.voxle_mm", "runs.csv"});
}

TEST_F(Compare, AnInputThatChangedUnderOnePathIsAParameter) {
  const std::string yaml = with(kSmall, REAMSIM_ROOT "/assets/reamer_flat.stl", path("tool.stl"));
  for (const char* name : {"flat", "convex"}) {
    std::filesystem::copy(std::string(REAMSIM_ROOT "/assets/reamer_") + name + ".stl", path("tool.stl"),
                          std::filesystem::copy_options::overwrite_existing);
    make_run(name, yaml);
  }
  make_run("other", with(kSmall, "reamer_flat", "reamer_hemispherical"));
  ASSERT_EQ(compare({"flat", "convex"}).status, 0);
  const std::string csv = read("out/runs.csv");
  EXPECT_THAT(csv, HasSubstr("tool.mesh (contents)"));
  const auto sum_of = [&](const std::string& name) {
    const std::string scenario = read(name + "/scenario.yaml");
    const std::size_t line = scenario.find("  tool.mesh  ");
    return scenario.substr(scenario.rfind(' ', line - 1) + 1, 12);
  };
  EXPECT_NE(sum_of("flat"), sum_of("convex"));
  EXPECT_THAT(csv, ::testing::AllOf(HasSubstr("sha256:" + sum_of("flat")), HasSubstr("sha256:" + sum_of("convex"))));
  // Other paths say enough.
  std::filesystem::remove_all(path("out"));
  ASSERT_EQ(compare({"flat", "other"}).status, 0);
  EXPECT_THAT(read("out/runs.csv"), ::testing::AllOf(HasSubstr("tool.mesh"), Not(HasSubstr("contents"))));
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
