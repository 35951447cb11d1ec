// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <sys/types.h>

#include <csignal>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace reamsim::test {

/// How a program is started.
struct ProgramCall {
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  ///< on top of ours
  std::string folder;                              ///< its working folder; "" = ours
  long file_size_limit = -1;                       ///< bytes that it may write into one file; -1 = no limit
  std::function<bool()> interrupt_when;            ///< interrupt_signal is sent once this is true
  bool closed_output = false;                      ///< started with standard output closed
  int interrupt_signal = SIGINT;
};

/// How it ended. A program that runs longer than a minute is killed.
struct ProgramResult {
  int status = -1;  ///< exit status; −1 when a signal ended it
  int signal = 0;
  std::string out;
  std::string err;
  double peak_mb = 0;  ///< the most memory that it held, MB = 10⁶ bytes
};

/// Starts a program, waits for it, and returns what it wrote.
ProgramResult run_program(const std::string& program, const ProgramCall& call);

}  // namespace reamsim::test
