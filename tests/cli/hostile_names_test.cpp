// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// A name of file or run that a shell, gnuplot, HTML, a template, a printf format, YAML and a spreadsheet would act on.
const std::string kHostile =
    "=a'b\"c`touch pwned`$(touch pwned);system(\"touch pwned\")|&<script>alert(1)<\\x>{{title}}%s%n@[x](y)*_\xc3\xa9";

/// Names that cannot stand on one line of YAML, JSON or a message.
const std::vector<std::string> kUnprintable{"two\nname: lines", "escape\x1b[31m", "latin\xe9", "next\xc2\x85line",
                                            "right\xe2\x80\xaeleft"};

/// What `text` is as a double-quoted YAML text.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump();
}

class HostileNames : public CliTest {
 protected:
  HostileNames() { plots_ = true; }
  /// Nothing was run, and no markup file has the name as markup.
  void expect_only_text() const {
    for (const auto& entry : fs::recursive_directory_iterator(path("."))) {
      EXPECT_NE(entry.path().filename(), "pwned") << entry.path();
      const std::string kind = entry.path().extension().string();
      if (!entry.is_regular_file() || (kind != ".html" && kind != ".svg")) continue;
      EXPECT_THAT(file_bytes(entry.path().string()), Not(HasSubstr("<script>alert"))) << entry.path();
    }
  }
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(HostileNames, OfFilesAndRunsStayTextInEveryOutput) {
  fs::create_directory(path(kHostile));
  fs::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path(kHostile + "/" + kHostile + ".stl"));
  const std::string drawn =
      with(kSmall, "  enabled: false\n", "  width_px: 64\n  height_px: 64\n  cameras: [oblique]\n  report: true\n");
  const std::string mesh = REAMSIM_ROOT "/assets/reamer_flat.stl";
  const std::string escaped = with(kHostile, "$(", "$(");  // only ${ would name a variable
  const std::string yaml = with(drawn, mesh, quoted(escaped + ".stl")) + "name: " + quoted(kHostile) + "\n";
  write(kHostile + "/" + kHostile + ".yaml", yaml);
  const std::string scenario = kHostile + "/" + kHostile + ".yaml", first = kHostile + "/" + kHostile + "1";
  const ProgramResult result = call({"run", scenario, "-o", first});
  ASSERT_EQ(result.status, 0) << result.err;
  fs::copy(path(first), path(kHostile + "/" + kHostile + "2"), fs::copy_options::recursive);
  EXPECT_EQ(call({"compare", first, kHostile + "/" + kHostile + "2", "-o", kHostile + "/cmp"}).status, 0);
  EXPECT_EQ(call({"render", first, "--camera", "oblique"}).status, 0);
  // The scenario that the run wrote is the same run.
  const ProgramResult again = call({"run", first + "/scenario.yaml", "-o", "again", "--set", "render.enabled=false",
                                    "--set", "output.plots=false", "--set", "output.meshes=false"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(read("again/forces.csv"), read(first + "/forces.csv"));
  expect_only_text();
  EXPECT_THAT(read(kHostile + "/cmp/compare.csv"), HasSubstr(",\"'=a'b\"\"c`touch"));
  EXPECT_EQ(nlohmann::json::parse(read(first + "/summary.json")).at("scenario"), kHostile);
}

TEST_F(HostileNames, KeysOfAForeignSummaryAreText) {
  expect_done(run(kSmall));
  nlohmann::json summary = nlohmann::json::parse(read("out/summary.json"));
  summary["=1+1,\"x\""] = 1;
  summary["line\nbreak`touch pwned`"] = 2;
  write("out/summary.json", summary.dump());
  fs::copy(path("out"), path("copy"), fs::copy_options::recursive);
  EXPECT_EQ(call({"compare", "out", "copy", "-o", "cmp"}).status, 0);
  const std::string csv = read("cmp/compare.csv");
  EXPECT_THAT(csv, HasSubstr("\n\"'=1+1,\"\"x\"\"\",out,1,"));
  EXPECT_THAT(csv, HasSubstr("\nline\\x0abreak`touch pwned`,out,2,"));
  expect_only_text();
}

TEST_F(HostileNames, ThatAreNoUtf8OnOneLineAreRefusedAndShownAsBytes) {
  write("s.yaml", kSmall);
  for (const std::string& name : kUnprintable) {
    fs::create_directory(path(name));
    write(name + "/s.yaml", kSmall);
    fs::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path(name + "/m.stl"));
    std::vector<std::vector<std::string>> commands{
        {"run", name + "/s.yaml", "-o", "out"},
        {"run", "s.yaml", "-o", "out", "--set", "name=" + name},
        {name},
        {"check", name + "/s.yaml"},
        {"run", "s.yaml", "-o", name + "/out"},
        {"run", "s.yaml", "-o", "out", "--set", name + "=1"},
        {"run", "s.yaml", "-o", "out", "--set", "tool.mesh=" + name + "/m.stl"},
        {"run", "s.yaml", "-o", "out", "--engine", name},
        {"run", "s.yaml", "-o", "out", "--device", name},
        {"import", name + "/m.stl", "-o", "b.vdb"},
        {"render", name},
        {"compare", name, name}};
    // Every command looks at a line break, an escape and Latin-1; the other names in a file, a key and a command.
    if (name == kUnprintable[3] || name == kUnprintable[4]) commands.resize(3);
    for (const std::vector<std::string>& arguments : commands) {
      const ProgramResult result = call(arguments);
      EXPECT_EQ(result.status, 2) << ::testing::PrintToString(arguments) << result.err;
      EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
      EXPECT_THAT(result.err, Not(HasSubstr("\x1b")));
      EXPECT_THAT(result.err, Not(HasSubstr(name)));
      EXPECT_FALSE(exists("out"));
    }
  }
}

}  // namespace
}  // namespace reamsim::test
