// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/console.h"
#include "sim/engine/common/engine_device.h"
#include "sim/record/kept_files.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/bone_cache.h"

namespace reamsim {

/// One run of a scenario into a folder.
struct RunRequest {
  Scenario scenario;
  std::string dir;
  bool overwrite = false;  ///< an older run in the folder is replaced once this one succeeds
  bool resume = false;     ///< an interrupted run is continued from its last checkpoint
  KeptFiles keep{};
  bool durable = true;  ///< the results are on the disk on return
};

/// What runs that follow one another in a process share.
struct RunResources {
  EngineDevices devices;
  BoneCache* bones = nullptr;  ///< only where the next run may have the same bone
};

/// Loads, simulates, writes and renders. Throws InputError, RunError, Interrupted, and Suspended where a checkpoint is
/// left; the message says what remains. Returns the frame after which an interrupted run was continued.
std::optional<std::int64_t> run_scenario(const RunRequest& request, RunResources& resources, const Console& console);

}  // namespace reamsim
