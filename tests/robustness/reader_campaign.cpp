// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "reader_campaign.h"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "mutate.h"
#include "seeds.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

namespace {

namespace fs = std::filesystem;

std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

void add(const Verdict& verdict, ReaderFindings& findings) {
  ++findings.inputs;
  findings.accepted += verdict.accepted ? 1 : 0;
  findings.slowest_s = std::max(findings.slowest_s, verdict.seconds);
  findings.largest_mb = std::max(findings.largest_mb, verdict.peak_mb);
}

std::string damaged_bytes(const Seed& seed, const std::string& name, const std::string& whole, Random& random) {
  const bool text = seed.text && (name.ends_with(".yaml") || name.ends_with(".csv") || name.ends_with(".json"));
  std::string out = text ? mutated_text(whole, random) : mutated(whole, random);
  return seed.repair ? seed.repair(name, std::move(out)) : out;
}

}  // namespace

std::string complaint_about(const Verdict& verdict, const std::string& named) {
  if (verdict.signal != 0) return fmt::format("signal {}", verdict.signal);
  if (!verdict.failure.empty()) return "not an input error: " + verdict.failure;
  if (verdict.seconds > kMostSeconds) return fmt::format("{:.1f} s", verdict.seconds);
  if (verdict.peak_mb > kMostMemory_mb) return fmt::format("{:.0f} MB", verdict.peak_mb);
  if (verdict.accepted) return "";
  std::istringstream lines(verdict.message);  // one for each mistake
  for (std::string line; std::getline(lines, line);) {
    if (line.find(named) == std::string::npos) return "does not name the file: " + verdict.message;
  }
  return verdict.message.empty() ? "says nothing" : "";
}

std::map<std::string, ReaderFindings> run_campaign(const Campaign& campaign) {
  const TempDir folder;
  const std::vector<Seed> seeds = campaign.texts ? write_text_seeds(folder.path()) : write_seeds(folder.path());
  Random random(campaign.seed);
  std::map<std::string, ReaderFindings> out;
  for (int n = 0; n < campaign.inputs; ++n) {
    const Seed& seed = seeds[static_cast<std::size_t>(n) % seeds.size()];
    const std::string name = seed.files[random() % seed.files.size()];
    const std::string path = seed.folder + "/" + name;
    const std::string whole = read_bytes(path);
    const std::string damaged = damaged_bytes(seed, name, whole, random);
    if (n < campaign.first) continue;
    write_bytes(path, damaged);
    Verdict verdict = supervised([&] { seed.read(path); });
    // Other programs may have kept the processor busy.
    if (verdict.signal == 0 && verdict.seconds > kMostSeconds) verdict = supervised([&] { seed.read(path); });
    ReaderFindings& findings = out[seed.reader];
    add(verdict, findings);
    if (const std::string complaint = complaint_about(verdict, seed.named.empty() ? name : seed.named);
        !complaint.empty()) {
      findings.complaints.push_back(fmt::format("input {}: {}", n, complaint));
      const std::string kept = fmt::format("{}/{}_{}", campaign.keep, n, fs::path(name).filename().string());
      if (!campaign.keep.empty()) write_bytes(kept, damaged);
    }
    write_bytes(path, whole);
  }
  return out;
}

}  // namespace reamsim::test
