// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

/// Help, man page and completion, which are made of the same texts.
const std::string kScenarios = REAMSIM_ROOT "/trajectories", kStudies = kScenarios + "/studies";

class Manual : public CliTest {
 protected:
  std::string out_of(const std::vector<std::string>& arguments) const {
    const ProgramResult result =
        reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result.out;
  }
  /// A shell in the folder.
  std::string shell(const std::string& program, const std::string& script) const {
    const ProgramResult result = run_program(
        program,
        {.arguments = {"-c", script}, .environment = {{"LC_ALL", "C.UTF-8"}}, .folder = dir_, .interrupt_when = {}});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return result.out;
  }
  /// Names of shipped files, from the folder itself.
  static std::vector<std::string> stems_of(const std::string& folder) {
    std::vector<std::string> out;
    if (folder == kStudies) {
      for (const auto& entry : std::filesystem::directory_iterator(kScenarios + "/validation")) {
        std::filesystem::path file = entry.path();
        if (file.extension() == ".yaml" && std::filesystem::exists(file.replace_extension(".csv")))
          out.push_back("validation/" + file.stem().string());
      }
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".yaml") out.push_back(entry.path().stem());
    }
    std::ranges::sort(out);
    return out;
  }
  /// What bash completes at the end of these words after the program, by its own completion of programs.
  std::vector<std::string> completed(const std::string& words) {
    if (!exists("completion")) write("completion", out_of({"help", "--format", "bash"}));
    std::istringstream lines(
        shell("/bin/bash", "source ./completion; COMP_WORDS=(" REAMSIM_PROGRAM " " + words +
                               "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _reamsim; "
                               "[ ${#COMPREPLY[@]} -eq 0 ] || printf '%s\\n' \"${COMPREPLY[@]}\""));
    std::vector<std::string> out;
    for (std::string line; std::getline(lines, line);) out.push_back(line);
    std::ranges::sort(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
};

TEST_F(Manual, HelpOfACommand) {
  EXPECT_EQ(out_of({"help", "run"}), out_of({"run", "--help"}));
  EXPECT_EQ(out_of({"help", "sweep", "submit"}), out_of({"sweep", "submit", "--help"}));
  EXPECT_EQ(out_of({"help"}), out_of({"--help"}));
  expect_refused(reamsim({.arguments = {"help", "polish"}, .environment = {}, .folder = "", .interrupt_when = {}}), 2,
                 {"polish: unknown command; expected run,", " or help"});
}

TEST_F(Manual, Status75OnlyWhereACommandCanEndSo) {
  const std::string line = "\n  75 ", resumed = "the same command with --resume continues";
  EXPECT_THAT(out_of({"help"}),
              HasSubstr(line + "                         of run, sweep run, uq and validate: interrupted, with"));
  EXPECT_THAT(out_of({"help", "run"}), AllOf(HasSubstr(line), HasSubstr(resumed)));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"help", "sweep", "run"}, {"help", "uq"}, {"help", "validate"}}) {
    EXPECT_THAT(out_of(command), AllOf(HasSubstr(line), Not(HasSubstr(resumed))));
  }
  for (const char* command : {"check", "render", "compare", "reforce", "fit", "import", "init", "preview", "bench",
                              "verify", "devices", "cite", "help"}) {
    EXPECT_THAT(out_of({"help", command}), AllOf(HasSubstr("\n  130 "), Not(HasSubstr(line)))) << command;
  }
  for (const char* command : {"plan", "status", "collect", "submit"}) {
    EXPECT_THAT(out_of({"help", "sweep", command}), Not(HasSubstr(line))) << command;
  }
}

TEST_F(Manual, StatusOneIsWhatItMeansForTheCommand) {
  const auto status_one = [&](const std::vector<std::string>& command) {
    const std::string text = out_of(command);
    const std::size_t begin = text.find("\n  1 ") + 1;
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  EXPECT_THAT(status_one({"help", "run"}), HasSubstr("the run failed"));
  EXPECT_THAT(status_one({"help", "verify"}), HasSubstr("a figure exceeds its tolerance"));
  EXPECT_THAT(status_one({"help", "sweep", "run"}), HasSubstr("a run of the study did"));
  EXPECT_THAT(status_one({"help", "check"}), Not(HasSubstr("run")));
}

TEST_F(Manual, HelpHasNoNotationOfTheParser) {
  for (const std::string command : {"run", "check", "render", "compare", "reforce", "fit", "sweep run", "sweep plan",
                                    "sweep submit", "uq", "import", "init", "preview", "bench", "verify", "cite"}) {
    const std::size_t space = command.find(' ');
    std::vector<std::string> words{"help", command.substr(0, space)};
    if (space != std::string::npos) words.push_back(command.substr(space + 1));
    const std::string text = out_of(words);
    for (const char* notation : {":INT", ":FLOAT", "TEXT:", "Excludes", "Needs", " x 3", "[Option", "{mp4}"}) {
      EXPECT_THAT(text, Not(HasSubstr(notation))) << command;
    }
  }
  EXPECT_THAT(out_of({"help", "sweep", "run"}), HasSubstr("(1 to 1024)"));
  EXPECT_THAT(out_of({"help", "bench"}), HasSubstr("(not with --exact, --latency)"));
  EXPECT_THAT(out_of({"help", "render"}), HasSubstr("  --film[=VALUE]  "));
}

TEST_F(Manual, TheManPageIsCleanAndHasEveryCommandAndOption) {
  write("reamsim.1", out_of({"help", "--format", "man"}));
  const std::string warnings = "man --warnings -l ./reamsim.1 2>&1 >/dev/null";
  EXPECT_EQ(shell("/bin/bash", warnings), "");
  const std::string page = shell("/bin/bash", "MANWIDTH=200 man -l ./reamsim.1 | col -b");
  for (const char* text : {"reamsim sweep submit [OPTIONS] STUDY", "--time-limit HH:MM:SS", "--parallel",
                           "-V, --version", "--picture FILE.png", "auto|exact|bricked|direct|octree|implicit",
                           "EXIT STATUS", "of run, sweep run, uq and validate: interrupted", "NO_COLOR"}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
  EXPECT_THAT(page, Not(HasSubstr("worker"))) << "which only reamsim starts";
  // A planted mistake shows that the check can fail.
  write("reamsim.1", read("reamsim.1") + ".SOMETHING\n");
  EXPECT_THAT(shell("/bin/bash", warnings), HasSubstr("SOMETHING"));
}

TEST_F(Manual, BashCompletesCommandsOptionsAndValues) {
  EXPECT_THAT(completed("r"), UnorderedElementsAre("reforce", "render", "run"));
  EXPECT_THAT(completed("sweep s"), UnorderedElementsAre("status", "submit"));
  EXPECT_THAT(completed("check --p"), UnorderedElementsAre("--picture"));
  EXPECT_THAT(completed("sweep submit --s"), UnorderedElementsAre("--set", "--shards", "--slurm", "--snakemake"));
  EXPECT_THAT(completed("run --engine ''"), Contains("octree"));
  EXPECT_THAT(completed("render --only p"), UnorderedElementsAre("pictures", "plots"));
  EXPECT_THAT(completed("help sw"), UnorderedElementsAre("sweep"));
  EXPECT_THAT(completed("run --set ''"), IsEmpty()) << "a key, not a file";
  EXPECT_THAT(completed("-"), UnorderedElementsAre("--help", "--version", "-V", "-h"));
  EXPECT_EQ(shell("/bin/bash", "bash -n ./completion"), "");
  EXPECT_THAT(shell("/bin/bash", "source ./completion; complete -p reamsim"), HasSubstr("_reamsim"));
}

TEST_F(Manual, BashCompletesFiles) {
  write("my.yaml", "");
  write("my scan.nrrd", "");
  std::filesystem::create_directory(path("mydir"));
  EXPECT_THAT(completed("run my"), UnorderedElementsAre("my.yaml", "mydir"));
  EXPECT_THAT(completed("render my"), UnorderedElementsAre("mydir"));
  EXPECT_THAT(completed("import my"), UnorderedElementsAre("my scan.nrrd", "my.yaml", "mydir"));
  EXPECT_THAT(completed("run my.yaml -o m"), UnorderedElementsAre("mydir"));
  EXPECT_THAT(completed("check --picture m"), Contains("my.yaml"));
}

TEST_F(Manual, ListsShippedNames) {
  const auto lines_of = [](const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += name + "\n";
    return out;
  };
  EXPECT_EQ(out_of({"help", "--format", "scenarios"}), lines_of(stems_of(kScenarios)));
  EXPECT_EQ(out_of({"help", "--format", "studies"}), lines_of(stems_of(kStudies)));
}

TEST_F(Manual, BashCompletesShippedNames) {
  const std::vector<std::string> scenarios = stems_of(kScenarios), studies = stems_of(kStudies);
  EXPECT_THAT(scenarios, Contains("default"));
  for (const char* command : {"run ''", "check ''", "bench --latency ''"}) {
    EXPECT_EQ(completed(command), scenarios) << command;
  }
  for (const char* command : {"sweep plan ''", "sweep run ''", "sweep submit ''", "uq ''", "validate ''"}) {
    EXPECT_EQ(completed(command), studies) << command;
  }
  write("default_of_mine.nrrd", "");
  for (const char* command : {"import def", "preview def"}) {
    EXPECT_THAT(completed(command), UnorderedElementsAre("default", "default_of_mine.nrrd")) << command;
  }
  EXPECT_THAT(completed("init def"), UnorderedElementsAre("default_of_mine.nrrd")) << "a bone, no scenario";
  EXPECT_THAT(completed("run ./def"), IsEmpty());
}

TEST_F(Manual, ZshCompletes) {
  const std::string zsh = "/usr/bin/zsh";
  if (!std::filesystem::exists(zsh)) GTEST_SKIP() << "zsh is not installed";
  std::filesystem::create_directory(path("functions"));
  write("functions/_reamsim", out_of({"help", "--format", "zsh"}));
  EXPECT_EQ(shell(zsh, "zsh -n functions/_reamsim"), "");
  // An interactive zsh on a terminal of its own, in which Tab is pressed; what the terminal shows, for 20 s at most.
  const std::string script = R"(zmodload zsh/zpty
typeset -F SECONDS
until_shown() {
  local part all=; local -F end=$(( SECONDS + 20 ))
  while (( SECONDS < end )) && [[ $all != *$1* ]]; do
    if zpty -r -t z part; then all+=$part; else sleep 0.05; fi
  done
  print -r -- "$all"
}
zpty -b z 'TERM=vt100 zsh -f -i'
zpty -w z 'PS1=; path=(PROGRAM_FOLDER $path) fpath=($PWD/functions $fpath); autoload -U compinit; compinit -u -D; bindkey "^I" complete-word; echo rea""dy'
until_shown ready >/dev/null
zpty -n -w z "$1"$'\t'
until_shown "$2"
zpty -d z
)";
  write("tab.zsh", with(script, "PROGRAM_FOLDER", std::filesystem::path(REAMSIM_PROGRAM).parent_path().string()));
  const auto tab = [&](const std::string& line, const std::string& word) {
    return shell(zsh, "zsh tab.zsh '" + line + "' '" + word + "'");
  };
  EXPECT_THAT(tab("reamsim ver", "verify"), HasSubstr("verify"));
  EXPECT_THAT(tab("reamsim run --res", "--resume"), HasSubstr("--resume"));
  EXPECT_THAT(tab("reamsim sweep subm", "submit"), HasSubstr("submit"));
  EXPECT_THAT(tab("reamsim run half", "half_space"), HasSubstr("half_space"));
  EXPECT_THAT(tab("reamsim sweep run reso", "resolution"), HasSubstr("resolution"));
  EXPECT_THAT(tab("reamsim import half", "half_space"), HasSubstr("half_space"));
  EXPECT_THAT(tab(REAMSIM_PROGRAM " check half", "half_space"), HasSubstr("half_space")) << "by its path";
}

}  // namespace
}  // namespace reamsim::test
