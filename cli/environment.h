// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>

#include "sim/device/opencl.h"

namespace reamsim {

class Console;

// What a shell or a batch system may have set up in a way that libraries do not expect.

/// Opens closed standard streams; otherwise the next opened file would take their place and receive console text.
void open_standard_streams();

/// Where the address space is limited (`ulimit -v`), libraries end the program by a signal, without a reason.
/// Afterwards these signals end it with a message that names the limit, and exit status 1.
void explain_fatal_signals();

/// Writes what is left of standard output. Returns `status`, or 1 with a message where text was lost although the
/// command succeeded. A reader that has closed its end of a pipe (`| head`) is no error.
int flush_standard_output(int status);

/// The folder for compiled kernels of a command that uses `device`; none for "serial". Says where it is not the usual
/// one and the command is verbose.
std::unique_ptr<cl::KernelCache> prepare_opencl(const std::string& device, const Console& console);

/// What --version prints: program, commit, build, libraries, OpenCL devices of this machine, licence.
std::string version_text();

}  // namespace reamsim
