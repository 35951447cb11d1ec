// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// fuzz_readers INPUTS SEED [texts|files [FOLDER]]: reads INPUTS damaged files and prints a table. Files with a
// complaint are kept in FOLDER. `texts` are what reamsim itself parses; `files`, the default, come from elsewhere.
// Exits with 1 if there are complaints.
#include <cstdio>
#include <cstdlib>

#include "reader_campaign.h"

int main(int argc, char** argv) {
  using namespace reamsim::test;
  if (argc < 3) {
    std::fprintf(stderr, "usage: fuzz_readers INPUTS SEED [texts|files [FOLDER for files with a complaint [FIRST]]]\n");
    return 2;
  }
  const Campaign campaign{.texts = argc > 3 && std::string(argv[3]) == "texts",
                          .inputs = std::atoi(argv[1]),
                          .seed = std::strtoull(argv[2], nullptr, 10),
                          .keep = argc > 4 ? argv[4] : "",
                          .first = argc > 5 ? std::atoi(argv[5]) : 0};
  std::size_t complaints = 0;
  ReaderFindings all;
  std::printf(
      "| reader | inputs | accepted | longest, s | most memory, MB | complaints |\n|---|---|---|---|---|---|\n");
  const auto print = [](const char* reader, const ReaderFindings& f, std::size_t count) {
    std::printf("| %s | %d | %d | %.2f | %.0f | %zu |\n", reader, f.inputs, f.accepted, f.slowest_s, f.largest_mb,
                count);
  };
  for (const auto& [reader, findings] : run_campaign(campaign)) {
    print(reader.c_str(), findings, findings.complaints.size());
    for (const std::string& complaint : findings.complaints)
      std::fprintf(stderr, "%s: %s\n", reader.c_str(), complaint.c_str());
    complaints += findings.complaints.size();
    all.inputs += findings.inputs;
    all.accepted += findings.accepted;
    all.slowest_s = std::max(all.slowest_s, findings.slowest_s);
    all.largest_mb = std::max(all.largest_mb, findings.largest_mb);
  }
  print("all", all, complaints);
  return complaints == 0 ? 0 : 1;
}
