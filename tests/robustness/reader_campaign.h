// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "supervised.h"

namespace reamsim::test {

/// What every damaged file has to satisfy.
inline constexpr double kMostSeconds = 10;
inline constexpr double kMostMemory_mb = 2000;

/// What is wrong with how a reader took a file; "" if nothing is.
std::string complaint_about(const Verdict& verdict, const std::string& named);

/// The findings of one reader.
struct ReaderFindings {
  int inputs = 0;
  int accepted = 0;  ///< read without an error: the damage did not matter
  double slowest_s = 0;
  double largest_mb = 0;
  std::vector<std::string> complaints;
};

struct Campaign {
  bool texts = false;  ///< what reamsim itself parses, instead of files of foreign origin
  int inputs = 0;
  std::uint64_t seed = 1;
  std::string keep;  ///< a folder for files with a complaint; "" = none
  int first = 0;     ///< inputs before this one are made but not read
};

/// Reads damaged files, taking the readers in turn. The same campaign has the same inputs.
std::map<std::string, ReaderFindings> run_campaign(const Campaign& campaign);

}  // namespace reamsim::test
