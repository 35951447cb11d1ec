// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>

#include "sim/record/manifest.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Checksums of input files, each computed once.
class Checksums {
 public:
  /// As sha256_of().
  const std::string& of(const std::string& path);

 private:
  std::map<std::string, std::string> known_;
};

/// The name of a run's folder in a study: 16 hex digits of the SHA-256 of the version of the program and the resolved
/// scenario, in which the checksums of input files stand for their paths. The name of the scenario does not count; of
/// the output section only force_basis does, and the render section only where pictures are kept. Throws InputError
/// when an input cannot be read.
std::string run_id(const Scenario& scenario, const KeptFiles& keep, Checksums& checksums);

}  // namespace reamsim
