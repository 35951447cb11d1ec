#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace reamsim::cl {

/// Throws RunError naming the call and OpenCL's error unless `status` is CL_SUCCESS.
void check(cl_int status, const char* call);

/// Sole owner of an OpenCL object. Release errors are ignored: a destructor has nobody to tell.
template <class T, cl_int(CL_API_CALL* Release)(T)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  ~Handle() {
    if (object_ != nullptr) Release(object_);
  }
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  [[nodiscard]] T get() const { return object_; }

 private:
  T object_ = nullptr;
};

using Context = Handle<cl_context, clReleaseContext>;
using Queue = Handle<cl_command_queue, clReleaseCommandQueue>;
using Program = Handle<cl_program, clReleaseProgram>;
using KernelHandle = Handle<cl_kernel, clReleaseKernel>;
using Memory = Handle<cl_mem, clReleaseMemObject>;
using Event = Handle<cl_event, clReleaseEvent>;

/// What the engine has to know of a device, and why it can or cannot be used.
struct DeviceInfo {
  cl_platform_id platform = nullptr;
  cl_device_id id = nullptr;
  std::string platform_name;
  std::string name;
  std::string driver;
  bool gpu = false;
  unsigned compute_units = 0;
  std::size_t max_work_group = 0;  ///< work-items that one of our kernels may have in a group
  std::size_t global_memory_bytes = 0;
  std::size_t max_allocation_bytes = 0;
  bool rounds_division = false;  ///< can divide and take roots of floats with correct rounding, as the host does
  std::string missing;           ///< extensions that the engine needs and the device lacks; empty: usable
};

/// Every device of every platform; empty where there is no platform.
std::vector<DeviceInfo> list_devices();

/// The device that `wanted` names: "auto" is the first usable GPU, else the first usable CPU; anything else is part of
/// a device's name, whatever the case. Throws RunError when there is no OpenCL device at all, InputError when none
/// matches or the match cannot be used.
DeviceInfo choose_device(const std::string& wanted);

/// One device with its context and an in-order queue.
class Device {
 public:
  explicit Device(const DeviceInfo& info);

  [[nodiscard]] const DeviceInfo& info() const { return info_; }
  [[nodiscard]] cl_context context() const { return context_.get(); }
  [[nodiscard]] cl_command_queue queue() const { return queue_.get(); }

  /// Builds a program from its source, or, where the environment variable REAMSIM_KERNEL_DIR names a folder with a file
  /// `name`, from that file. `options` go to the compiler, such as "-DNAME=1". Throws RunError with the compiler's log
  /// when it does not build.
  [[nodiscard]] Program build(const std::string& name, const char* source, const std::string& options = "") const;

  /// Waits until everything enqueued is done.
  void finish() const;

 private:
  DeviceInfo info_;
  Context context_;
  Queue queue_;
};

/// A device buffer of `count` elements of T.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Device& device, std::size_t count, const char* what) : count_(count) {
    memory_ = allocate(device, count * sizeof(T), what);
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t bytes() const { return count_ * sizeof(T); }
  [[nodiscard]] cl_mem get() const { return memory_.get(); }

  /// Copies `count` elements from `data`; returns at once when not `blocking` (data must then live until finish()).
  void write(const Device& device, const T* data, std::size_t count, std::size_t offset = 0, bool blocking = true) {
    check(clEnqueueWriteBuffer(device.queue(), memory_.get(), blocking ? CL_TRUE : CL_FALSE, offset * sizeof(T),
                               count * sizeof(T), data, 0, nullptr, nullptr),
          "clEnqueueWriteBuffer");
  }
  void read(const Device& device, T* data, std::size_t count, std::size_t offset = 0) const {
    check(clEnqueueReadBuffer(device.queue(), memory_.get(), CL_TRUE, offset * sizeof(T), count * sizeof(T), data, 0,
                              nullptr, nullptr),
          "clEnqueueReadBuffer");
  }
  /// Takes the first `count` elements of another buffer.
  void copy(const Device& device, const Buffer& from, std::size_t count) {
    check(clEnqueueCopyBuffer(device.queue(), from.get(), memory_.get(), 0, 0, count * sizeof(T), 0, nullptr, nullptr),
          "clEnqueueCopyBuffer");
  }
  /// Fills `count` elements with zero bits.
  void clear(const Device& device, std::size_t count) {
    const cl_uchar zero = 0;
    check(clEnqueueFillBuffer(device.queue(), memory_.get(), &zero, 1, 0, count * sizeof(T), 0, nullptr, nullptr),
          "clEnqueueFillBuffer");
  }

 private:
  static Memory allocate(const Device& device, std::size_t bytes, const char* what);

  std::size_t count_ = 0;
  Memory memory_;
};

/// Allocates device memory; RunError that says what it was for and what would fit.
Memory allocate_memory(const Device& device, std::size_t bytes, const char* what);

template <class T>
Memory Buffer<T>::allocate(const Device& device, std::size_t bytes, const char* what) {
  return allocate_memory(device, bytes, what);
}

/// A buffer of these elements. It is never empty: no element is uploaded as one of zeros.
template <class T>
Buffer<T> upload(const Device& device, std::vector<T> data, const char* what) {
  if (data.empty()) data.emplace_back();
  Buffer<T> buffer(device, data.size(), what);
  buffer.write(device, data.data(), data.size());
  return buffer;
}

/// A kernel with its arguments, which stay set between launches. A launcher names its kernel's parameters by an enum,
/// in the order in which the kernel declares them.
class Kernel {
 public:
  Kernel() = default;
  Kernel(const Program& program, const char* name);

  template <class Argument, class T>
  void set(Argument argument, const T& value) {
    check(clSetKernelArg(kernel_.get(), static_cast<cl_uint>(argument), sizeof(T), &value), "clSetKernelArg");
  }
  template <class Argument, class T>
  void set(Argument argument, const Buffer<T>& buffer) {
    set(argument, buffer.get());
  }
  /// Sets arguments that follow one another, the first of them `first`.
  template <class Argument, class... T>
  void set_from(Argument first, const T&... values) {
    auto argument = static_cast<cl_uint>(first);
    (set(argument++, values), ...);
  }
  /// Gives a __local argument its size.
  template <class Argument>
  void set_local(Argument argument, std::size_t bytes) {
    check(clSetKernelArg(kernel_.get(), static_cast<cl_uint>(argument), bytes, nullptr), "clSetKernelArg");
  }
  /// Launches at least `items` work-items in groups of `group`; the event tells when it ran.
  [[nodiscard]] Event launch(const Device& device, std::size_t items, std::size_t group) const;

 private:
  KernelHandle kernel_;
};

/// Seconds that each of these finished kernels ran on the device; forgets the events.
std::vector<double> take_seconds(std::vector<Event>& events);

/// A kernel that runs once per substep, in groups of a fixed size, and is told the substep's slot by one argument.
class SlotKernel : public Kernel {
 public:
  /// The device must outlive the kernel.
  template <class Argument>
  SlotKernel(const Device& device, const Program& program, const char* name, Argument slot, std::size_t group)
      : Kernel(program, name), device_(device), slot_argument_(static_cast<cl_uint>(slot)), group_(group) {}

  /// Enqueues at least `items` work-items for the substep in `slot`; with none, one group, so that every substep has
  /// its time: kernels let items beyond their range go.
  void run(int slot, std::size_t items) {
    set(slot_argument_, static_cast<cl_uint>(slot));
    slots_.push_back(slot);
    events_.push_back(launch(device_, items == 0 ? 1 : items, group_));
  }
  /// Seconds by slot since the last call, of all runs of a slot together. Call it when the queue has finished.
  std::vector<double> take_seconds();

 private:
  const Device& device_;
  cl_uint slot_argument_;
  std::size_t group_;
  std::vector<Event> events_;
  std::vector<int> slots_;  // of the events
};

}  // namespace reamsim::cl
