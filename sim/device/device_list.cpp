// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <string_view>
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
  text.resize(text.find('\0') == std::string::npos ? text.size() : text.find('\0'));
  return text;
}

template <class T>
T info_value(cl_device_id id, cl_device_info parameter) {
  T value{};
  clGetDeviceInfo(id, parameter, sizeof(T), &value, nullptr);
  return value;
}

std::string missing_extensions(cl_device_id id) {
  const std::string have = " " + info_text(id, CL_DEVICE_EXTENSIONS, clGetDeviceInfo) + " ";
  std::string missing;
  for (const char* extension : {"cl_khr_fp64", "cl_khr_int64_base_atomics"}) {
    if (have.find(std::string(" ") + extension + " ") != std::string::npos) continue;
    missing += (missing.empty() ? "" : ", ") + std::string(extension);
  }
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
  info.gpu = (info_value<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0;
  info.compute_units = info_value<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.max_parts = info_value<cl_uint>(id, CL_DEVICE_PARTITION_MAX_SUB_DEVICES);
  info.max_work_group = max_work_items(id, info.gpu);
  info.global_memory_bytes = info_value<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = info_value<cl_ulong>(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.rounds_division =
      (info_value<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG) & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.missing = missing_extensions(id);
  return info;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string names(const std::vector<DeviceInfo>& devices) {
  std::string out;
  for (const auto& device : devices) out += (out.empty() ? "\"" : ", \"") + device.name + "\"";
  return out;
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
  cl_uint platform_count = 0;
  if (clGetPlatformIDs(0, nullptr, &platform_count) != CL_SUCCESS || platform_count == 0) return devices;
  std::vector<cl_platform_id> platforms(platform_count);
  check(clGetPlatformIDs(platform_count, platforms.data(), nullptr), "clGetPlatformIDs");
  for (cl_platform_id platform : platforms) {
    cl_uint count = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS || count == 0) continue;
    std::vector<cl_device_id> ids(count);
    check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr), "clGetDeviceIDs");
    for (cl_device_id id : ids) devices.push_back(describe(platform, id));
  }
  return devices;
}

DeviceInfo choose_device(const std::string& wanted) {
  const auto devices = list_devices();
  if (devices.empty()) {
    throw RunError(
        "no OpenCL platform found: install a driver (Debian: pocl-opencl-icd, or that of the GPU), or use --device "
        "serial");
  }
  if (wanted == "auto") return choose_automatically(devices);
  for (const auto& device : devices) {
    if (lower(device.name).find(lower(wanted)) == std::string::npos) continue;
    if (device.missing.empty()) return device;
    throw InputError({}, "engine.device", "\"" + wanted + "\" is " + device.name + ", which lacks " + device.missing,
                     "choose another device or serial");
  }
  throw InputError({}, "engine.device", "\"" + wanted + "\" matches no OpenCL device",
                   "expected auto, serial or part of one of " + names(devices));
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

}  // namespace reamsim::cl
