// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "sim/engine/common/engine.h"
#include "tests/bench/reference/targets.h"

namespace reamsim::reference {

/// What `exact` is measured against: the same visits and windows in C++ without OpenCL, over memory of its own, with
/// the same bytes as results. Envelope of revolution, energetic law without edge force, and bone whose voxels are whole
/// at first.
class ExactReference final : public Engine {
 public:
  /// `threads`: with the caller's. Throws RunError on other settings of cutting, resolved cutting edges, or bone that
  /// is partly removed.
  ExactReference(const BoneView& bone, const Tool& tool, const CuttingSettings& cutting, Target target,
                 unsigned threads);
  ~ExactReference() override;
  ExactReference(const ExactReference&) = delete;
  ExactReference& operator=(const ExactReference&) = delete;

  using Engine::enqueue;
  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override;
  [[nodiscard]] bool full() const override;
  Batch collect() override;
  RemovedFrames take_removed() override;
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override;
  void restore(const BoneView& bone) override;
  /// The instruction set.
  [[nodiscard]] std::string device() const override;
  [[nodiscard]] std::size_t device_bytes() const override;
  [[nodiscard]] StructureBytes structure_bytes() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reamsim::reference
