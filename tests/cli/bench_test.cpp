#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

class BenchCommand : public CliTest {
 protected:
  ProgramResult bench(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"bench", "--quick", "-o", "out"});
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(BenchCommand, UnwritableJson) {
  expect_refused(bench({"--json", "no-such-folder/bench.json"}), 2, {"no-such-folder/bench.json", "--json"});
}

TEST_F(BenchCommand, UnknownEngine) {
  expect_refused(bench({"--engines", "direct,sparse"}), 2, {"--engines", "sparse", "bricked", "implicit"});
}

TEST_F(BenchCommand, UnknownDevice) {
  expect_refused(bench({"--device", "nonexistent"}), 2, {"nonexistent"});
}

TEST_F(BenchCommand, FolderThatCannotBeMade) {
  write("file", "not a folder");
  const ProgramResult result = reamsim(
      {.arguments = {"bench", "--quick", "-o", "file/out"}, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_refused(result, 2, {"file/out", "output folder"});
}

}  // namespace
}  // namespace reamsim::test
