// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <new>
#include <optional>
#include <variant>
#include <vector>

#include "sim/api/reamsim/simulation.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/run/checkpoint.h"
#include "sim/run/frame_stepper.h"

namespace reamsim {

/// What tells one bone from another, before the first step.
struct BoneIdentity {
  VoxelGrid grid;
  std::uint32_t crc = 0;  ///< of densities and fill

  bool operator==(const BoneIdentity&) const = default;
  static auto fields(auto& self) { return std::tie(self.grid, self.crc); }
};

BoneIdentity identity_of(const Bone& bone);

/// Where a simulation stands, besides the fill of its bone.
struct Progress {
  StepState step;
  double time_s = 0;
  double removed_mm3 = 0;
  bool uneven = false;           ///< steps had a time of their own
  std::optional<ToolPose> pose;  ///< none before the first one

  static auto fields(auto& p) { return std::tie(p.step, p.time_s, p.removed_mm3, p.uneven, p.pose); }
};

struct Simulation::State::Parts {
  BoneIdentity bone;
  Progress progress;
  FillBricks before;  ///< the fill before the first step; empty in a state from a file
  /// In memory a copy of the fill, which shares what has not changed; of a file the bricks that steps have changed.
  std::variant<FillBricks, std::vector<PlacedBrick>> fill;

  /// For the bone whose fill before the first step is `start`. Throws InputError where a brick lies outside.
  [[nodiscard]] FillBricks fill_on(const FillBricks& start) const;
};

/// Calls work(), and turns its exceptions into those of the library.
template <class Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const InputError& error) {
    throw BadInput(error.what());
  } catch (const std::bad_alloc&) {
    throw RunFailure("not enough memory");
  } catch (const std::exception& error) {
    throw RunFailure(error.what());
  }
}

}  // namespace reamsim
