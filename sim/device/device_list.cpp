// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/device/device_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/base/text.h"
#include "sim/device/opencl.h"

namespace reamsim::cl {

namespace {

template <class Id, class Query>
std::string info_text(Id id, cl_uint parameter, Query query) {
  std::size_t size = 0;
  if (query(id, parameter, 0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  query(id, parameter, size, text.data(), nullptr);
  return text.substr(0, text.find('\0'));
}

template <class T>
T info_value(cl_device_id id, cl_device_info parameter) {
  T value{};
  clGetDeviceInfo(id, parameter, sizeof(T), &value, nullptr);
  return value;
}

/// Whether tests take this capability from every device. Throws InputError for unknown ones.
bool is_taken_away(const std::string& capability) {
  constexpr const char* kWithout = "REAMSIM_DEVICE_WITHOUT";
  constexpr std::array kKnown{"fp64", "int64_atomics", "rounded_division"};
  const char* const value = std::getenv(kWithout);
  if (value == nullptr || *value == '\0') return false;
  const std::vector<std::string> without = split(value, ',');
  for (const std::string& name : without) {
    if (std::ranges::count(kKnown, name) > 0) continue;
    throw InputError({}, kWithout, "found " + name, fmt::format("expected some of {}", fmt::join(kKnown, ",")));
  }
  return std::ranges::count(without, capability) > 0;
}

/// What the device lacks of what the kernels need: the full profile of OpenCL 1.2, and no option of it.
std::string missing_of(cl_device_id id) {
  std::string missing;
  const auto need = [&](bool there, const std::string& what) {
    if (!there) missing += (missing.empty() ? "" : ", ") + what;
  };
  const std::string version = info_text(id, CL_DEVICE_VERSION, clGetDeviceInfo);  // "OpenCL 1.2 ..."
  need(info_text(id, CL_DEVICE_PROFILE, clGetDeviceInfo) == "FULL_PROFILE",
       "the full profile of OpenCL (another driver of this device may have it)");
  need(version >= "OpenCL 1.2", "OpenCL 1.2 (found " + version + "; a newer driver may have it)");
  need(info_value<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE) == CL_TRUE,
       "a compiler of kernels (install the driver with its compiler)");
  need(info_value<cl_bool>(id, CL_DEVICE_AVAILABLE) == CL_TRUE, "availability (another program may hold it)");
  need(info_value<cl_bool>(id, CL_DEVICE_ENDIAN_LITTLE) == CL_TRUE, "little-endian memory");
  return missing;
}

/// Limit of the work-items in a group. On a CPU, PoCL keeps the private memory of all work-items of a group on one
/// thread's stack, here some 4 kB each: 2048 of them overflow it, although the device reports that limit.
std::size_t max_work_items(cl_device_id id, bool gpu) {
  constexpr std::size_t kMaxOnCpu = 256;
  const auto most = info_value<std::size_t>(id, CL_DEVICE_MAX_WORK_GROUP_SIZE);
  return gpu ? most : std::min(most, kMaxOnCpu);
}

DeviceInfo describe(cl_platform_id platform, cl_device_id id) {
  DeviceInfo info;
  info.platform = platform;
  info.id = id;
  info.platform_name = info_text(platform, CL_PLATFORM_NAME, clGetPlatformInfo);
  info.name = info_text(id, CL_DEVICE_NAME, clGetDeviceInfo);
  info.driver = info_text(id, CL_DRIVER_VERSION, clGetDeviceInfo);
  info.version = info_text(id, CL_DEVICE_VERSION, clGetDeviceInfo);
  info.gpu = (info_value<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0;
  info.compute_units = info_value<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.max_parts = info_value<cl_uint>(id, CL_DEVICE_PARTITION_MAX_SUB_DEVICES);
  info.max_work_group = max_work_items(id, info.gpu);
  info.global_memory_bytes = info_value<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = info_value<cl_ulong>(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.local_memory_bytes = info_value<cl_ulong>(id, CL_DEVICE_LOCAL_MEM_SIZE);
  info.unified_memory = info_value<cl_bool>(id, CL_DEVICE_HOST_UNIFIED_MEMORY) == CL_TRUE;
  const auto rounding = info_value<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG);
  info.rounds_division = (rounding & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0 && !is_taken_away("rounded_division");
  const std::vector<std::string> extensions = split(info_text(id, CL_DEVICE_EXTENSIONS, clGetDeviceInfo), ' ');
  const auto has = [&](const char* extension) { return std::ranges::count(extensions, extension) > 0; };
  info.int64_atomics = has("cl_khr_int64_base_atomics") && !is_taken_away("int64_atomics");
  info.fp64 = has("cl_khr_fp64") && !is_taken_away("fp64");
  info.missing = missing_of(id);
  return info;
}

std::vector<cl_platform_id> platforms() {
  cl_uint count = 0;
  if (clGetPlatformIDs(0, nullptr, &count) != CL_SUCCESS || count == 0) return {};
  std::vector<cl_platform_id> out(count);
  check(clGetPlatformIDs(count, out.data(), nullptr), "clGetPlatformIDs");
  return out;
}

std::vector<cl_device_id> devices_of(cl_platform_id platform) {
  cl_uint count = 0;
  if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS || count == 0) return {};
  std::vector<cl_device_id> out(count);
  check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, out.data(), nullptr), "clGetDeviceIDs");
  return out;
}

/// "PLATFORM: NAME".
std::string full_name(const DeviceInfo& device) {
  return device.platform_name + ": " + device.name;
}

std::string names(const std::vector<DeviceInfo>& devices) {
  std::vector<std::string> out;
  for (const auto& device : devices) out.push_back('"' + full_name(device) + '"');
  return fmt::format("{}", fmt::join(out, ", "));
}

DeviceInfo choose_automatically(const std::vector<DeviceInfo>& devices) {
  for (const bool gpu : {true, false}) {
    for (const auto& device : devices) {
      if (device.gpu == gpu && device.missing.empty()) return device;
    }
  }
  throw RunError("no OpenCL device meets the requirements of the engine (" + devices.front().name + " lacks " +
                 devices.front().missing + "); --device serial runs without OpenCL");
}

/// Address space that a driver takes beside a small scenario, mostly without using it: libraries of the compiler and a
/// first compilation, 0.7 GB with PoCL 3.1, and the stacks of a thread for each core.
std::uint64_t driver_address_space() {
  constexpr std::uint64_t kLibraries = 800'000'000, kStack = 16'000'000;
  return kLibraries + kStack * std::thread::hardware_concurrency();
}

/// A driver that runs out of address space hides its devices, or aborts the program.
void require_address_space() {
  const auto limit = address_space_limit();
  const std::uint64_t used = address_space_in_use();
  if (!limit || *limit >= used + driver_address_space()) return;
  throw RunError(address_space_note() + ", of which " + megabytes(used) + " are taken; OpenCL needs " +
                 megabytes(driver_address_space()) + " more: raise the limit, or use --device serial");
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  require_address_space();
  if (!std::filesystem::exists("/sys/devices/system"))  // PoCL ends the program
    throw RunError("/sys is not mounted, and OpenCL drivers need it: mount it, or use --device serial");
  std::vector<DeviceInfo> devices;
  for (cl_platform_id platform : platforms()) {
    for (cl_device_id id : devices_of(platform)) devices.push_back(describe(platform, id));
  }
  return devices;
}

std::vector<std::string> platforms_without_device() {
  std::vector<std::string> out;
  for (cl_platform_id platform : platforms()) {
    if (!devices_of(platform).empty()) continue;
    const std::string name = info_text(platform, CL_PLATFORM_NAME, clGetPlatformInfo);
    const std::string what = name == "rusticl"
                                 ? "set RUSTICL_ENABLE to the driver of the GPU, such as iris, radeonsi or "
                                   "nouveau, or to llvmpipe for the processor"
                                 : "its GPU may be missing, in use, or closed to this user (join the "
                                   "groups video and render)";
    out.push_back(name + " shows no device: " + what);
  }
  return out;
}

DeviceInfo choose_device(const std::string& wanted) {
  const auto devices = list_devices();
  if (devices.empty()) {
    throw RunError(
        "no OpenCL platform found: install a driver (Debian: pocl-opencl-icd, or that of the GPU), or use --device "
        "serial");
  }
  if (wanted == "auto") return choose_automatically(devices);
  const std::size_t mark = std::min(wanted.rfind('#'), wanted.size());
  const auto number = mark < wanted.size() ? whole_number(wanted.substr(mark + 1)) : std::uint64_t{1};
  const std::string text = lower_case(number ? wanted.substr(0, mark) : wanted);
  std::uint64_t matches = 0;
  for (const auto& device : devices) {
    if (lower_case(full_name(device)).find(text) == std::string::npos || ++matches != number.value_or(1)) continue;
    if (device.missing.empty()) return device;
    throw InputError({}, "engine.device", "\"" + wanted + "\" is " + device.name + ", which lacks " + device.missing,
                     "choose another device or serial");
  }
  throw InputError(
      {}, "engine.device", "\"" + wanted + "\" matches no OpenCL device",
      "expected auto, serial or part of one of " + names(devices) +
          (matches > 0 ? fmt::format("; {} match the name, and #N at its end takes the Nth", matches) : ""));
}

DeviceInfo part_of(const DeviceInfo& device, unsigned compute_units) {
  if (device.max_parts == 0) throw RunError(device.name + ": the device cannot be divided");
  const cl_device_partition_property by_count[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                   static_cast<cl_device_partition_property>(compute_units),
                                                   CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
  cl_device_id id = nullptr;
  check(clCreateSubDevices(device.id, by_count, 1, &id, nullptr), "clCreateSubDevices");
  DeviceInfo out = device;
  out.id = id;
  out.compute_units = compute_units;
  out.part = std::shared_ptr<void>(id, [](void* part) { clReleaseDevice(static_cast<cl_device_id>(part)); });
  return out;
}

std::vector<std::pair<std::string, std::string>> capabilities_of(const DeviceInfo& device) {
  const auto yes_or = [](bool has, const char* otherwise) { return std::string(has ? "yes" : otherwise); };
  return {
      {"device", device.name},
      {"platform", device.platform_name},
      {"driver", device.driver},
      {"version", device.version},
      {"type", device.gpu ? "GPU" : "CPU"},
      {"compute units", std::to_string(device.compute_units)},
      {"memory", megabytes(device.global_memory_bytes)},
      {"largest allocation", megabytes(device.max_allocation_bytes)},
      {"memory shared with the host", yes_or(device.unified_memory, "no")},
      {"local memory of a work-group", fmt::format("{} KiB", device.local_memory_bytes / 1024)},
      {"largest work-group used", std::to_string(device.max_work_group)},
      {"64-bit atomics", yes_or(device.int64_atomics, "no: sums by two atomics of 32 bits")},
      {"correctly rounded division", yes_or(device.rounds_division, "no: forces may differ in the last digits")},
      {"double precision (not used)", yes_or(device.fp64, "no")},
      {"kernels", device.gpu ? "GPU shape: a work-group per brick" : "CPU shape: a work-item per brick, in vectors"},
      {"missing", device.missing.empty() ? "nothing" : device.missing}};
}

}  // namespace reamsim::cl
