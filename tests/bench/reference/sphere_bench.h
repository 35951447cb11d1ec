// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <vector>

namespace reamsim::reference {

/// `exact` and its references on the plunged sphere of `reamsim bench` (sim/bench/scene.h): frames at four
/// depths, in windows of smooth motion.
class SphereBench {
 public:
  SphereBench();
  ~SphereBench();

  /// Registers a benchmark per voxel size and program: sphere_0.25/exact, sphere_0.25/AVX-512, … The first one of a
  /// voxel size that runs measures all of its programs alternately, and throws RunError where their sums differ.
  void register_rows();
  /// Prints the medians, and the ratio of `exact` to each reference.
  void print_ratios() const;

 private:
  struct Size;
  std::vector<std::unique_ptr<Size>> sizes_;
};

}  // namespace reamsim::reference
