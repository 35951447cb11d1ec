// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>

#include "sim/device/opencl.h"

namespace reamsim {

class Console;
struct EngineTuning;

// What a shell or a batch system may have set up in a way that libraries do not expect.

/// Opens closed standard streams; otherwise the next opened file would take their place and receive console text.
void open_standard_streams();

/// Signals by which libraries end the program where `ulimit -v` limits it get a message that says so, and status 1.
void explain_fatal_signals();

/// Returns `status`, or 1 with a message where a command that succeeded lost text; a reader that left (`| head`) may.
int flush_standard_output(int status);

/// The folder for compiled kernels of a command that uses `device`; none for "serial". Said where it is unusual.
std::unique_ptr<cl::KernelCache> prepare_opencl(const std::string& device, const Console& console);

/// The tuning of engines that tests set in REAMSIM_ENGINE_TUNING. Throws InputError.
EngineTuning tuning_of_environment();

/// What --version prints: program, commit, build, libraries, OpenCL devices of this machine, licence.
std::string version_text();

}  // namespace reamsim
