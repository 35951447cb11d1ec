// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/run_id.h"

#include "sim/record/manifest.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

constexpr std::size_t kIdDigits = 16;  // 64 bits: a collision among a million runs has a probability of 3e-8

}  // namespace

const std::string& Checksums::of(const std::string& path) {
  std::string& sum = known_[path];
  if (sum.empty()) sum = sha256_of(path);
  return sum;
}

std::string run_id(const Scenario& scenario, const KeptFiles& keep, Checksums& checksums) {
  Scenario counted = scenario;
  counted.name.clear();
  counted.output = {};
  counted.output.force_basis = scenario.output.force_basis;
  if (!keep.pictures) counted.render = {};
  std::map<std::string, std::string> sums;
  for (const auto& [role, path] : input_files(scenario)) sums[path] = checksums.of(path);
  const auto sum_of = [&](const std::string& path) {
    const auto found = sums.find(path);
    return found == sums.end() ? path : found->second;
  };
  return sha256_of_text("reamsim " REAMSIM_VERSION "\n" + to_yaml(counted, sum_of)).substr(0, kIdDigits);
}

}  // namespace reamsim
