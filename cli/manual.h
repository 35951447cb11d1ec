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

/// What an exit status means for a command; "": for the program as a whole.
struct Status {
  std::string_view command;
  Entry entry;
};
/// Of any command, unless a later entry is of the command itself.
inline constexpr std::string_view kAnyCommand = "*";
inline constexpr std::array<Status, 12> kStatuses{
    {{kAnyCommand, {"0", "done"}},
     {kAnyCommand, {"1", "the command failed"}},
     {"", {"1", "the command failed; of verify: a figure exceeds its tolerance; of sweep run: a run failed"}},
     {"run", {"1", "the run failed"}},
     {"sweep run", {"1", "the command failed, or a run of the study did"}},
     {"verify", {"1", "the command failed, or a figure exceeds its tolerance"}},
     {kAnyCommand, {"2", "the input is wrong; the message says what, where, and what to do"}},
     {"",
      {"75",
       "of run, sweep run and uq: interrupted, with a checkpoint; the same command continues, of run with --resume"}},
     {"run", {"75", "interrupted, with a checkpoint: the same command with --resume continues"}},
     {"sweep run", {"75", "interrupted; the same command continues"}},
     {"uq", {"75", "interrupted; the same command continues"}},
     {kAnyCommand, {"130", "interrupted"}}}};

inline constexpr std::array<Entry, 9> kVariables{
    {{"NO_COLOR", "If set and not empty, messages on a terminal have no colours. Elsewhere they never have."},
     {"TERM", "With dumb, progress is printed as lines and messages have no colours."},
     {"POCL_CACHE_DIR", "Folder for compiled OpenCL kernels."},
     {"XDG_CACHE_HOME",
      "Without POCL_CACHE_DIR, kernels are in its folder pocl/kcache; without both, in .cache/pocl/kcache of HOME."},
     {"TMPDIR", "Folder for compiled kernels where none of these can be written; otherwise /tmp."},
     {"POCL_MAX_PTHREAD_COUNT", "Maximum number of threads of the OpenCL device PoCL."},
     {"POCL_AFFINITY", "1, the default of reamsim, binds the threads of PoCL to processors; 0 does not."},
     {"REAMSIM_PYTHON",
      "The Python that computes the statistics of fit, uq and sweep; otherwise /usr/bin/python3, or python3 of PATH."},
     {"HOME", "Replaces ${HOME} in a scenario, as any variable ${NAME} is replaced there."}}};

inline constexpr std::array<Entry, 5> kExamples{
    {{"reamsim check my.yaml", "Validates a scenario and estimates time and memory."},
     {"reamsim run my.yaml -o out/my", "Simulates it. Open out/my/report.html afterwards."},
     {"reamsim run my.yaml --set bone.voxel_mm=0.3 -o out/fine", "The same with smaller voxels."},
     {"reamsim render out/my --film", "Makes a film of the finished run."},
     {"reamsim cite out/my", "Prints what a paper about this run should cite."}}};

}  // namespace reamsim
