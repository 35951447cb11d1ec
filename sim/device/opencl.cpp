// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/device/opencl.h"

#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>
#include <thread>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/base/text.h"

namespace reamsim::cl {

namespace {

const char* error_name(cl_int status) {
  static const std::map<cl_int, const char*> kNames{{CL_DEVICE_NOT_FOUND, "no device found"},
                                                    {CL_DEVICE_NOT_AVAILABLE, "device not available"},
                                                    {CL_MEM_OBJECT_ALLOCATION_FAILURE, "memory allocation failed"},
                                                    {CL_OUT_OF_RESOURCES, "out of resources"},
                                                    {CL_OUT_OF_HOST_MEMORY, "out of host memory"},
                                                    {CL_BUILD_PROGRAM_FAILURE, "build failure"},
                                                    {CL_INVALID_WORK_GROUP_SIZE, "invalid work-group size"},
                                                    {CL_INVALID_BUFFER_SIZE, "invalid buffer size"},
                                                    {CL_INVALID_KERNEL_NAME, "no such kernel in the program"}};
  const auto found = kNames.find(status);
  return found == kNames.end() ? "OpenCL error" : found->second;
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw RunError("REAMSIM_KERNEL_DIR: cannot read " + path.string());
  return text.str();
}

std::string build_log(cl_program program, cl_device_id device) {
  std::size_t size = 0;
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
  std::string log(size, '\0');
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
  while (!log.empty() && (log.back() == '\0' || log.back() == '\n')) log.pop_back();
  return log;
}

/// Throws RunError with the compiler's log.
Program build_program(const DeviceInfo& info, cl_context context, const std::string& name, const char* source,
                      const std::string& options) {
  std::string text, folder_option;
  const char* folder = std::getenv("REAMSIM_KERNEL_DIR");
  if (folder != nullptr && *folder != '\0' && std::filesystem::exists(std::filesystem::path(folder) / name)) {
    text = read_text(std::filesystem::path(folder) / name);
    folder_option = "-I " + std::string(folder) + " ";
    source = text.c_str();
  }
  cl_int status = CL_SUCCESS;
  Program program(clCreateProgramWithSource(context, 1, &source, nullptr, &status));
  check(status, "clCreateProgramWithSource");
  const std::string rounding = info.rounds_division ? "-cl-fp32-correctly-rounded-divide-sqrt " : "";
  const std::string atomics = info.int64_atomics ? "-DRS_INT64_ATOMICS " : "";
  const std::string all_options =
      "-cl-std=CL1.2 -cl-single-precision-constant " + folder_option + rounding + atomics + options;
  status = clBuildProgram(program.get(), 1, &info.id, all_options.c_str(), nullptr, nullptr);
  if (status == CL_SUCCESS) return program;
  throw RunError("kernel " + name + " does not build on " + info.name + ": " + build_log(program.get(), info.id));
}

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

/// Capabilities that tests take from every device. Throws InputError for unknown ones.
bool is_taken_away(const std::string& capability) {
  constexpr const char* kWithout = "REAMSIM_DEVICE_WITHOUT";
  const char* const value = std::getenv(kWithout);
  if (value == nullptr || *value == '\0') return false;
  if (value != capability) throw InputError({}, kWithout, std::string("found ") + value, "expected " + capability);
  return true;
}

bool has_int64_atomics(cl_device_id id) {
  const std::vector<std::string> have = split(info_text(id, CL_DEVICE_EXTENSIONS, clGetDeviceInfo), ' ');
  return std::ranges::count(have, "cl_khr_int64_base_atomics") > 0 && !is_taken_away("int64_atomics");
}

/// What the device lacks of what the kernels need: the full profile of OpenCL 1.2, and no option of it.
std::string missing_of(cl_device_id id) {
  std::string missing;
  const auto need = [&](bool there, const std::string& what) {
    if (!there) missing += (missing.empty() ? "" : ", ") + what;
  };
  const std::string version = info_text(id, CL_DEVICE_VERSION, clGetDeviceInfo);  // "OpenCL 1.2 ..."
  need(info_text(id, CL_DEVICE_PROFILE, clGetDeviceInfo) == "FULL_PROFILE", "the full profile");
  need(version >= "OpenCL 1.2", "OpenCL 1.2 (found " + version + ")");
  need(info_value<cl_bool>(id, CL_DEVICE_COMPILER_AVAILABLE) == CL_TRUE, "a compiler");
  need(info_value<cl_bool>(id, CL_DEVICE_AVAILABLE) == CL_TRUE, "availability: the driver has locked it");
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
  info.gpu = (info_value<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0;
  info.compute_units = info_value<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.max_parts = info_value<cl_uint>(id, CL_DEVICE_PARTITION_MAX_SUB_DEVICES);
  info.max_work_group = max_work_items(id, info.gpu);
  info.global_memory_bytes = info_value<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = info_value<cl_ulong>(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.rounds_division =
      (info_value<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG) & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.int64_atomics = has_int64_atomics(id);
  info.missing = missing_of(id);
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

void check(cl_int status, const char* call) {
  if (status == CL_SUCCESS) return;
  throw RunError(std::string(call) + ": " + error_name(status) + " (" + std::to_string(status) + ")");
}

Device::Device(const DeviceInfo& info) : opened_(std::make_shared<Opened>()) {
  opened_->info = info;
  cl_int status = CL_SUCCESS;
  opened_->context = Context(clCreateContext(nullptr, 1, &info.id, nullptr, nullptr, &status));
  check(status, "clCreateContext");
  opened_->queue = Queue(clCreateCommandQueue(context(), info.id, CL_QUEUE_PROFILING_ENABLE, &status));
  check(status, "clCreateCommandQueue");
}

Program Device::build(const std::string& name, const char* source, const std::string& options) const {
  Program& program = opened_->programs[name + " " + options];
  if (program.get() == nullptr) program = build_program(info(), context(), name, source, options);
  check(clRetainProgram(program.get()), "clRetainProgram");
  return Program(program.get());
}

void Device::finish() const {
  check(clFinish(queue()), "clFinish");
}

Memory allocate_memory(const Device& device, std::size_t bytes, const char* what, const char* key) {
  const DeviceInfo& info = device.info();
  const std::string need = std::string(what) + " needs " + megabytes(bytes);
  const std::string expected =
      std::string(key) == kSizeKey ? "use larger voxels or a smaller crop" : "use a smaller value";
  if (bytes > info.max_allocation_bytes) {
    throw InputError(
        {}, key,
        need + " in one allocation; " + info.name + " supports at most " + megabytes(info.max_allocation_bytes),
        expected);
  }
  cl_int status = CL_SUCCESS;
  Memory memory(clCreateBuffer(device.context(), CL_MEM_READ_WRITE, bytes == 0 ? 1 : bytes, nullptr, &status));
  if (status != CL_SUCCESS) {
    throw InputError({}, key, need + "; " + info.name + " has not enough memory (" + error_name(status) + ")",
                     expected + ", or another engine.device");
  }
  return memory;
}

Kernel::Kernel(const Program& program, const char* name) {
  cl_int status = CL_SUCCESS;
  kernel_ = KernelHandle(clCreateKernel(program.get(), name, &status));
  check(status, "clCreateKernel");
}

Event Kernel::launch(const Device& device, std::size_t items, std::size_t group) const {
  const std::size_t global = (items + group - 1) / group * group;
  cl_event event = nullptr;
  check(clEnqueueNDRangeKernel(device.queue(), kernel_.get(), 1, nullptr, &global, &group, 0, nullptr, &event),
        "clEnqueueNDRangeKernel");
  return Event(event);
}

std::vector<double> take_seconds(std::vector<Event>& events) {
  std::vector<double> seconds;
  for (const Event& event : events) {
    const auto time = [&](cl_profiling_info which) {
      cl_ulong ns = 0;
      check(clGetEventProfilingInfo(event.get(), which, sizeof ns, &ns, nullptr), "clGetEventProfilingInfo");
      return ns;
    };
    seconds.push_back(1e-9 * static_cast<double>(time(CL_PROFILING_COMMAND_END) - time(CL_PROFILING_COMMAND_START)));
  }
  events.clear();
  return seconds;
}

void SlotKernel::run(int slot, std::size_t items) {
  set(0, static_cast<cl_uint>(slot));
  slots_.push_back(slot);
  events_.push_back(launch(*device_, std::max<std::size_t>(1, items), group_));
}

double SlotKernel::take_total_s() {
  const std::vector<double> by_slot = take_seconds();
  return std::accumulate(by_slot.begin(), by_slot.end(), 0.0);
}

std::vector<double> SlotKernel::take_seconds() {
  std::vector<double> by_slot;
  const std::vector<double> seconds = cl::take_seconds(events_);
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    const auto slot = static_cast<std::size_t>(slots_[i]);
    if (slot >= by_slot.size()) by_slot.resize(slot + 1, 0);
    by_slot[slot] += seconds[i];
  }
  slots_.clear();
  return by_slot;
}

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
