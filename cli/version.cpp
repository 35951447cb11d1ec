// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/version.h"

#include "cli/commit.h"
#include "cli/console.h"
#include "cli/environment.h"
#include "cli/library_versions.h"
#include "sim/base/error.h"
#include "sim/base/printable.h"
#include "sim/device/opencl.h"

namespace reamsim {

namespace {

std::string libraries_text() {
  std::string out;
  for (const LibraryVersion& library : kLibraryVersions) {
    out += (out.empty() ? "" : ", ") + std::string(library.name);
    if (!library.version.empty()) out += " " + std::string(library.version);
  }
  return out;
}

/// The drivers are loaded when the program runs, so no build knows them.
std::string opencl_text() {
  const Console console;
  const auto kernels = prepare_opencl("auto", console);
  std::string out;
  for (const cl::DeviceInfo& device : cl::list_devices()) {
    out += (out.empty() ? "" : "; ") + device.name + " (" + device.platform_name + ", driver " + device.driver + ")";
  }
  return out.empty() ? "no device" : printable(out);
}

/// The version is printed wherever it can be.
std::string opencl_text_or_why() {
  try {
    return opencl_text();
  } catch (const std::exception& error) {
    return "not available: " + printable(message_of(error));
  }
}

}  // namespace

std::string version_text() {
  const std::string commit = kCommit[0] == '\0' ? "" : std::string("commit ") + kCommit + ", ";
  return "reamsim " REAMSIM_VERSION "\n" + commit + std::string(kBuildType) + " build by " + std::string(kCompiler) +
         "\nlibraries: " + libraries_text() + "\nOpenCL: " + opencl_text_or_why() +
         "\nLicensed under the Apache License, Version 2.0. Copyright the reamsim authors.";
}

}  // namespace reamsim
