// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

class VerifyCommand : public CliTest {
 protected:
  ProgramResult verify(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"verify", "--quick"});
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(VerifyCommand, UnknownDevice) {
  expect_refused(verify({"--device", "nonexistent", "-o", "out"}), 2, {"nonexistent"});
}

TEST_F(VerifyCommand, FolderThatCannotBeMade) {
  write("file", "not a folder");
  expect_refused(verify({"-o", "file/out"}), 2, {"file/out", "output folder"});
}

}  // namespace
}  // namespace reamsim::test
