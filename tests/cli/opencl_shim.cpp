// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Preloaded before the OpenCL loader: shows devices other than those of this machine. REAMSIM_TEST_DEVICE is a list of
//   gpu      every device is a GPU
//   least    work-groups of 64, local memory of 32 KiB, allocations of 64 MB
//   slow     kernels report that they took a million times as long
//   twice    every device is listed twice
//   gone     no context can be made
//   fails=N  the Nth launch of a kernel, and all later ones, are out of resources
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

constexpr std::size_t kLeastGroup = 64;
constexpr cl_ulong kLeastLocal = 32 * 1024, kLeastAllocation = 64'000'000;
constexpr cl_ulong kSlower = 1'000'000;

/// The value of a setting: "" where it has none; nullopt-like "-" where it is not set.
std::string setting(const std::string& name) {
  const char* const all = std::getenv("REAMSIM_TEST_DEVICE");
  std::string text = std::string(",") + (all == nullptr ? "" : all) + ",";
  const std::size_t at = text.find("," + name);
  if (at == std::string::npos) return "-";
  const std::size_t begin = at + 1 + name.size();
  return text.substr(begin, text.find(',', begin) - begin);
}
bool has(const std::string& name) {
  return setting(name) != "-";
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
#define NEXT(function) next<decltype(&(function))>(#function)

template <class T>
void limit(void* value, T most) {
  T found{};
  if (value == nullptr) return;
  std::memcpy(&found, value, sizeof found);
  found = std::min(found, most);
  std::memcpy(value, &found, sizeof found);
}

}  // namespace

extern "C" {

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, std::size_t size, void* value, std::size_t* needed) {
  const cl_int status = NEXT(clGetDeviceInfo)(device, what, size, value, needed);
  if (what == CL_DEVICE_TYPE && has("gpu") && value != nullptr) {
    const cl_device_type gpu = CL_DEVICE_TYPE_GPU;
    std::memcpy(value, &gpu, sizeof gpu);
  }
  if (!has("least")) return status;
  if (what == CL_DEVICE_LOCAL_MEM_SIZE) limit<cl_ulong>(value, kLeastLocal);
  if (what == CL_DEVICE_MAX_MEM_ALLOC_SIZE) limit<cl_ulong>(value, kLeastAllocation);
  return status;
}

/// Limits of a kernel are below those of the device, as on GPUs whose kernels need many registers.
cl_int clGetKernelWorkGroupInfo(cl_kernel kernel, cl_device_id device, cl_kernel_work_group_info what, std::size_t size,
                                void* value, std::size_t* needed) {
  const cl_int status = NEXT(clGetKernelWorkGroupInfo)(kernel, device, what, size, value, needed);
  if (what == CL_KERNEL_WORK_GROUP_SIZE && has("least")) limit<std::size_t>(value, kLeastGroup);
  return status;
}

cl_int clGetDeviceIDs(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id* ids, cl_uint* count) {
  if (!has("twice")) return NEXT(clGetDeviceIDs)(platform, type, room, ids, count);
  cl_uint found = 0;
  const cl_int status = NEXT(clGetDeviceIDs)(platform, type, 0, nullptr, &found);
  if (status != CL_SUCCESS) return status;
  std::vector<cl_device_id> all(found);
  NEXT(clGetDeviceIDs)(platform, type, found, all.data(), nullptr);
  all.insert(all.end(), all.begin(), all.begin() + found);
  if (count != nullptr) *count = 2 * found;
  if (ids != nullptr) std::copy_n(all.begin(), std::min<std::size_t>(room, all.size()), ids);
  return CL_SUCCESS;
}

cl_context clCreateContext(const cl_context_properties* properties, cl_uint count, const cl_device_id* devices,
                           void (*notify)(const char*, const void*, std::size_t, void*), void* data, cl_int* status) {
  if (!has("gone")) return NEXT(clCreateContext)(properties, count, devices, notify, data, status);
  if (status != nullptr) *status = CL_DEVICE_NOT_AVAILABLE;
  return nullptr;
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const std::size_t* offset,
                              const std::size_t* global, const std::size_t* local, cl_uint count, const cl_event* wait,
                              cl_event* event) {
  static std::atomic<int> launches{0};
  if (has("fails=") && ++launches >= std::atoi(setting("fails=").c_str())) return CL_OUT_OF_RESOURCES;
  if (has("least")) {
    if (local == nullptr || *local > kLeastGroup) return CL_INVALID_WORK_GROUP_SIZE;
    cl_device_id device = nullptr;
    clGetCommandQueueInfo(queue, CL_QUEUE_DEVICE, sizeof device, &device, nullptr);
    cl_ulong memory = 0;
    clGetKernelWorkGroupInfo(kernel, device, CL_KERNEL_LOCAL_MEM_SIZE, sizeof memory, &memory, nullptr);
    if (memory > kLeastLocal) return CL_OUT_OF_RESOURCES;
  }
  return NEXT(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset, global, local, count, wait, event);
}

cl_int clGetEventProfilingInfo(cl_event event, cl_profiling_info what, std::size_t size, void* value,
                               std::size_t* needed) {
  const cl_int status = NEXT(clGetEventProfilingInfo)(event, what, size, value, needed);
  if (what == CL_PROFILING_COMMAND_START && has("slow") && status == CL_SUCCESS) {
    cl_ulong start = 0, end = 0;
    std::memcpy(&start, value, sizeof start);
    NEXT(clGetEventProfilingInfo)(event, CL_PROFILING_COMMAND_END, sizeof end, &end, nullptr);
    start = end - kSlower * (end - start);  // may wrap: only differences are used
    std::memcpy(value, &start, sizeof start);
  }
  return status;
}

}  // extern "C"
