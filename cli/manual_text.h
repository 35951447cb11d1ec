// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <string_view>

namespace reamsim {

// What the help of the program and its man page say beside the commands.

/// A term and what it means.
struct Entry {
  std::string_view term;
  std::string_view meaning;
};

inline constexpr std::string_view kSummary = "simulate glenoid reaming";
inline constexpr std::string_view kDescription =
    "reamsim simulates glenoid reaming: it turns a scenario into cutting forces, pictures and an OpenVDB grid.";

inline constexpr std::array<Entry, 5> kExitStatuses{
    {{"0", "done"},
     {"1", "the run failed"},
     {"2", "the input is wrong, or no command was given; the message says what, where, and what to do"},
     {"75",
      "of run, sweep run and uq: interrupted, with a checkpoint; the same command continues, of run with --resume"},
     {"130", "interrupted"}}};

/// The commands that can end with status 75, and what it means there.
inline constexpr std::string_view kSuspended = "75";
inline constexpr std::array<Entry, 3> kSuspendable{
    {{"run", "interrupted, with a checkpoint: the same command with --resume continues"},
     {"sweep run", "interrupted; the same command continues"},
     {"uq", "interrupted; the same command continues"}}};

inline constexpr std::array<Entry, 6> kVariables{
    {{"NO_COLOR", "If set to anything but nothing, messages on a terminal have no colours. Elsewhere they never have."},
     {"TERM", "With dumb, progress is printed as lines and messages have no colours."},
     {"POCL_CACHE_DIR", "Folder for compiled OpenCL kernels; otherwise XDG_CACHE_HOME or .cache in the home folder."},
     {"POCL_MAX_PTHREAD_COUNT", "Most threads of the OpenCL device PoCL."},
     {"POCL_AFFINITY", "1, the default of reamsim, binds the threads of PoCL to processors; 0 does not."},
     {"HOME", "Replaces ${HOME} in a scenario, as any variable ${NAME} is replaced there."}}};

inline constexpr std::array<Entry, 5> kExamples{
    {{"reamsim check my.yaml", "Validates a scenario and estimates time and memory."},
     {"reamsim run my.yaml -o out/my", "Simulates it. Open out/my/report.html afterwards."},
     {"reamsim run my.yaml --set bone.voxel_mm=0.3 -o out/fine", "The same with smaller voxels."},
     {"reamsim render out/my --film", "Makes a film of the finished run."},
     {"reamsim cite out/my", "Prints what a paper about this run should cite."}}};

}  // namespace reamsim
