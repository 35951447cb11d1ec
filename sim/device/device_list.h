// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace reamsim::cl {

/// The capabilities of a device.
struct DeviceInfo {
  cl_platform_id platform = nullptr;
  cl_device_id id = nullptr;
  std::string platform_name;
  std::string name;
  std::string driver;
  std::string version;  ///< "OpenCL 3.0 ..."
  bool gpu = false;
  unsigned compute_units = 0;
  unsigned max_parts = 0;          ///< it can be divided into; 0: not at all, as with PoCL 7.1 on a processor
  std::size_t max_work_group = 0;  ///< limit for the kernels of this program
  std::size_t global_memory_bytes = 0;
  std::size_t max_allocation_bytes = 0;
  std::size_t local_memory_bytes = 0;  ///< of a work-group
  bool unified_memory = false;         ///< shared with the host
  bool rounds_division = false;        ///< division and square root of floats are correctly rounded, as on the host
  bool int64_atomics = false;          ///< cl_khr_int64_base_atomics; without, kernels add in two halves of 32 bits
  bool fp64 = false;                   ///< double precision, which no kernel uses
  std::string missing;                 ///< what the device lacks of the full profile of OpenCL 1.2; empty: usable
  std::shared_ptr<void> part;          ///< owns `id` where it is a part of a device
};

/// The devices of all platforms. Throws RunError where a limit of the address space or a missing /sys hides them.
/// The environment variable REAMSIM_DEVICE_WITHOUT takes capabilities away: fp64, int64_atomics, rounded_division.
std::vector<DeviceInfo> list_devices();

/// For each platform that shows no device, its name and what the user can do.
std::vector<std::string> platforms_without_device();

/// The device that `wanted` names: "auto" is the first usable GPU, else the first usable CPU. Other text is a part of
/// "PLATFORM: NAME" of the device, in either case; "#2" at its end takes the second one that matches. Throws RunError
/// when there is no OpenCL device, InputError when none matches or the match is not usable.
DeviceInfo choose_device(const std::string& wanted);

/// A part of a device with fewer compute units. Throws RunError where the device cannot be divided.
DeviceInfo part_of(const DeviceInfo& device, unsigned compute_units);

/// The capability table of a device: what it has, and which kernels it gets, as names and values.
std::vector<std::pair<std::string, std::string>> capabilities_of(const DeviceInfo& device);

}  // namespace reamsim::cl
