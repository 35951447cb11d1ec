#include "sim/device/opencl.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sim/base/error.h"

namespace reamsim::embedded {
extern const char* const kernel_shared_h;
extern const char* const kernel_bricks_h;
extern const char* const kernel_profile_h;
extern const char* const kernel_power_h;
extern const char* const kernel_cut_law_h;
extern const char* const kernel_outline_h;
extern const char* const kernel_cube_share_h;
extern const char* const kernel_clip_h;
extern const char* const kernel_distance_grid_h;
extern const char* const kernel_visit_h;
extern const char* const kernel_candidates_h;
extern const char* const kernel_brick_report_h;
extern const char* const kernel_published_h;
}  // namespace reamsim::embedded

namespace reamsim::cl {

namespace {

const char* error_name(cl_int status) {
  switch (status) {
    case CL_DEVICE_NOT_FOUND:
      return "no device found";
    case CL_DEVICE_NOT_AVAILABLE:
      return "device not available";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
      return "memory allocation failed";
    case CL_OUT_OF_RESOURCES:
      return "out of resources";
    case CL_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case CL_BUILD_PROGRAM_FAILURE:
      return "build failure";
    case CL_INVALID_WORK_GROUP_SIZE:
      return "invalid work-group size";
    case CL_INVALID_BUFFER_SIZE:
      return "invalid buffer size";
    case CL_INVALID_KERNEL_NAME:
      return "no such kernel in the program";
    default:
      return "OpenCL error";
  }
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw RunError("REAMSIM_KERNEL_DIR: cannot read " + path.string());
  return text.str();
}

/// The source of a kernel file: the embedded text, or the file in REAMSIM_KERNEL_DIR.
std::string kernel_source(const std::string& file, const char* embedded_source) {
  const char* dir = std::getenv("REAMSIM_KERNEL_DIR");
  if (dir == nullptr || *dir == '\0') return embedded_source;
  const auto path = std::filesystem::path(dir) / file;
  return std::filesystem::exists(path) ? read_text(path) : embedded_source;
}

std::string build_log(cl_program program, cl_device_id device) {
  std::size_t size = 0;
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
  std::string log(size, '\0');
  clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
  while (!log.empty() && (log.back() == '\0' || log.back() == '\n')) log.pop_back();
  return log;
}

}  // namespace

void check(cl_int status, const char* call) {
  if (status == CL_SUCCESS) return;
  throw RunError(std::string(call) + ": " + error_name(status) + " (" + std::to_string(status) + ")");
}

Device::Device(const DeviceInfo& info) : info_(info) {
  cl_int status = CL_SUCCESS;
  context_ = Context(clCreateContext(nullptr, 1, &info_.id, nullptr, nullptr, &status));
  check(status, "clCreateContext");
  queue_ = Queue(clCreateCommandQueue(context_.get(), info_.id, CL_QUEUE_PROFILING_ENABLE, &status));
  check(status, "clCreateCommandQueue");
}

Program Device::build(const std::string& name, const char* embedded_source, const std::string& options) const {
  // The headers' guards make their #include lines empty: a device has no folder to look in.
  const std::string text =
      kernel_source("shared.h", embedded::kernel_shared_h) + kernel_source("bricks.h", embedded::kernel_bricks_h) +
      kernel_source("profile.h", embedded::kernel_profile_h) + kernel_source("power.h", embedded::kernel_power_h) +
      kernel_source("cut_law.h", embedded::kernel_cut_law_h) + kernel_source("outline.h", embedded::kernel_outline_h) +
      kernel_source("cube_share.h", embedded::kernel_cube_share_h) + kernel_source("clip.h", embedded::kernel_clip_h) +
      kernel_source("distance_grid.h", embedded::kernel_distance_grid_h) +
      kernel_source("visit.h", embedded::kernel_visit_h) +
      kernel_source("candidates.h", embedded::kernel_candidates_h) +
      kernel_source("brick_report.h", embedded::kernel_brick_report_h) +
      kernel_source("published.h", embedded::kernel_published_h) + kernel_source(name, embedded_source);
  const char* source = text.c_str();
  cl_int status = CL_SUCCESS;
  Program program(clCreateProgramWithSource(context_.get(), 1, &source, nullptr, &status));
  check(status, "clCreateProgramWithSource");
  const std::string rounding = info_.rounds_division ? "-cl-fp32-correctly-rounded-divide-sqrt " : "";
  const std::string all_options = "-cl-std=CL1.2 " + rounding + options;
  status = clBuildProgram(program.get(), 1, &info_.id, all_options.c_str(), nullptr, nullptr);
  if (status == CL_SUCCESS) return program;
  throw RunError("kernel " + name + " does not build on " + info_.name + ": " + build_log(program.get(), info_.id));
}

void Device::finish() const {
  check(clFinish(queue_.get()), "clFinish");
}

Memory allocate_memory(const Device& device, std::size_t bytes, const char* what) {
  const auto mb = [](std::size_t n) { return std::to_string((n + 999'999) / 1'000'000) + " MB"; };
  const DeviceInfo& info = device.info();
  if (bytes > info.max_allocation_bytes) {
    throw RunError(std::string(what) + " needs " + mb(bytes) + " in one piece, but " + info.name +
                   " allocates at most " + mb(info.max_allocation_bytes) +
                   "; use a larger bone.voxel_mm or a smaller crop");
  }
  cl_int status = CL_SUCCESS;
  Memory memory(clCreateBuffer(device.context(), CL_MEM_READ_WRITE, bytes == 0 ? 1 : bytes, nullptr, &status));
  if (status != CL_SUCCESS) {
    throw RunError(std::string(what) + ": " + info.name + " has no room for " + mb(bytes) + " (" + error_name(status) +
                   ")");
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
    cl_ulong begin = 0, end = 0;
    check(clGetEventProfilingInfo(event.get(), CL_PROFILING_COMMAND_START, sizeof begin, &begin, nullptr),
          "clGetEventProfilingInfo");
    check(clGetEventProfilingInfo(event.get(), CL_PROFILING_COMMAND_END, sizeof end, &end, nullptr),
          "clGetEventProfilingInfo");
    seconds.push_back(1e-9 * static_cast<double>(end - begin));
  }
  events.clear();
  return seconds;
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
