// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/device/opencl.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

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
  // Without warnings (-w), whose number PoCL would print on the console.
  const std::string all_options =
      "-cl-std=CL1.2 -cl-single-precision-constant -w " + folder_option + rounding + atomics + options;
  status = clBuildProgram(program.get(), 1, &info.id, all_options.c_str(), nullptr, nullptr);
  if (status == CL_SUCCESS) return program;
  throw DeviceError("kernel " + name + " does not build on " + info.name + " (" + info.platform_name + ", driver " +
                    info.driver + ") with the options " + all_options + ": " + build_log(program.get(), info.id));
}

}  // namespace

void check(cl_int status, const char* call) {
  if (status == CL_SUCCESS) return;
  throw DeviceError(std::string(call) + ": " + error_name(status) + " (" + std::to_string(status) + ")");
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
  if (status == CL_MEM_OBJECT_ALLOCATION_FAILURE || status == CL_INVALID_BUFFER_SIZE ||
      status == CL_OUT_OF_HOST_MEMORY) {
    throw InputError({}, key, need + "; " + info.name + " has not enough memory (" + error_name(status) + ")",
                     expected + ", or another engine.device");
  }
  check(status, "clCreateBuffer");
  return memory;
}

Kernel::Kernel(const Program& program, const char* name) {
  cl_int status = CL_SUCCESS;
  kernel_ = KernelHandle(clCreateKernel(program.get(), name, &status));
  check(status, "clCreateKernel");
}

std::size_t Kernel::largest_group(const DeviceInfo& info) const {
  std::size_t largest = 0;
  cl_ulong local = 0;
  const auto get = [&](cl_kernel_work_group_info which, auto& value) {
    check(clGetKernelWorkGroupInfo(kernel_.get(), info.id, which, sizeof value, &value, nullptr),
          "clGetKernelWorkGroupInfo");
  };
  get(CL_KERNEL_WORK_GROUP_SIZE, largest);
  get(CL_KERNEL_LOCAL_MEM_SIZE, local);
  if (local <= info.local_memory_bytes) return largest;
  throw RunError("a kernel needs " + std::to_string(local) + " bytes of local memory, and " + info.name + " has " +
                 std::to_string(info.local_memory_bytes) + ": choose another device, or serial");
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

SlotKernel::SlotKernel(const Device& device, const Program& program, const char* name, std::size_t group,
                       std::size_t items)
    : Kernel(program, name), device_(&device), group_(std::min(group, largest_group(device.info()))), items_(items) {}

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

}  // namespace reamsim::cl
