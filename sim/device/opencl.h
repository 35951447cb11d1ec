// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <memory>
#include <ranges>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "sim/base/error.h"
#include "sim/device/device_list.h"

namespace reamsim::cl {

/// A device has failed a call: out of resources, reset, or lost. Its context is of no further use.
class DeviceError : public RunError {
 public:
  using RunError::RunError;
};

/// Throws DeviceError naming the call and OpenCL's error unless `status` is CL_SUCCESS.
void check(cl_int status, const char* call);

/// Sole owner of an OpenCL object, which the function releases; ignores errors of the release.
template <class T, auto Function>
using Handle = std::unique_ptr<std::remove_pointer_t<T>, std::integral_constant<decltype(Function), Function>>;

using Context = Handle<cl_context, clReleaseContext>;
using Queue = Handle<cl_command_queue, clReleaseCommandQueue>;
using Program = Handle<cl_program, clReleaseProgram>;
using KernelHandle = Handle<cl_kernel, clReleaseKernel>;
using Memory = Handle<cl_mem, clReleaseMemObject>;
using Event = Handle<cl_event, clReleaseEvent>;

/// One device with its context and an in-order queue. Copies share both, and the programs that any of them has built;
/// engines that run one after another open the device and compile their kernels once.
class Device {
 public:
  explicit Device(const DeviceInfo& info);

  [[nodiscard]] const DeviceInfo& info() const { return opened_->info; }
  [[nodiscard]] cl_context context() const { return opened_->context.get(); }
  [[nodiscard]] cl_command_queue queue() const { return opened_->queue.get(); }

  /// Builds a program from `source`, or from the file `name` in the folder REAMSIM_KERNEL_DIR (environment) if it
  /// exists, with compiler options such as "-DNAME=1". Throws RunError with the compiler's log.
  [[nodiscard]] Program build(const std::string& name, const char* source, const std::string& options = "") const;

  void finish() const { check(clFinish(queue()), "clFinish"); }

 private:
  struct Opened {
    DeviceInfo info;
    Context context;
    Queue queue;
    std::map<std::string, Program> programs;  ///< by name and options
  };
  std::shared_ptr<Opened> opened_;
};

/// The key of a scenario that most decides how much memory a device needs.
inline constexpr const char* kSizeKey = "bone.voxel_mm";

/// Allocates device memory. Where the device has not that much, throws InputError for `key`, which decides how much it
/// is, with the purpose `what` and the limit of the device.
Memory allocate_memory(const Device& device, std::size_t bytes, const char* what, const char* key = kSizeKey);

/// A device buffer of `count` elements of T.
template <class T>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Device& device, std::size_t count, const char* what, const char* key = kSizeKey)
      : count_(count), memory_(allocate_memory(device, count * sizeof(T), what, key)) {}

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t bytes() const { return count_ * sizeof(T); }
  [[nodiscard]] cl_mem get() const { return memory_.get(); }

  /// Copies `count` elements from `data`. Without `blocking` it returns at once, and `data` must live until finish().
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
  /// Copies the first `count` elements of another buffer.
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
  std::size_t count_ = 0;
  Memory memory_;
};

/// The device memory of some buffers, bytes.
template <class... T>
std::size_t bytes_of(const std::tuple<Buffer<T>...>& buffers) {
  return std::apply([](const auto&... buffer) { return (buffer.bytes() + ...); }, buffers);
}

/// A buffer with these elements; with a single zero element where `data` is empty.
template <class Range, class T = std::ranges::range_value_t<Range>>
Buffer<T> upload(const Device& device, const Range& data, const char* what, const char* key = kSizeKey) {
  const std::size_t count = std::size(data);
  Buffer<T> buffer(device, std::max<std::size_t>(1, count), what, key);
  if (count > 0) {
    buffer.write(device, std::data(data), count);
  } else {
    buffer.clear(device, 1);
  }
  return buffer;
}

/// A kernel with its arguments, which stay set between launches. Kernels declare the parameters that change with every
/// launch first, so that a launcher sets the others once, from the first constant one on.
class Kernel {
 public:
  Kernel() = default;
  Kernel(const Program& program, const char* name);

  template <class T>
  void set(cl_uint argument, const T& value) {
    // NOLINTNEXTLINE(bugprone-sizeof-expression): the argument is the handle of a buffer itself
    check(clSetKernelArg(kernel_.get(), argument, sizeof(T), &value), "clSetKernelArg");
  }
  template <class T>
  void set(cl_uint argument, const Buffer<T>& buffer) {
    set(argument, buffer.get());
  }
  /// Sets consecutive arguments, beginning with number `first`. A tuple or a vector sets one argument per element.
  template <class... T>
  void set_from(cl_uint first, const T&... values) {
    (set_next(first, values), ...);
  }
  /// Sets the size of a __local argument.
  void set_local(cl_uint argument, std::size_t bytes) {
    check(clSetKernelArg(kernel_.get(), argument, bytes, nullptr), "clSetKernelArg");
  }
  /// The largest work-group in which the device can run the kernel. Throws RunError where it has not enough local
  /// memory.
  [[nodiscard]] std::size_t largest_group(const DeviceInfo& info) const;
  /// Launches at least `items` work-items in groups of `group`. The event holds the time of the run.
  [[nodiscard]] Event launch(const Device& device, std::size_t items, std::size_t group) const;

 private:
  template <class T>
  void set_next(cl_uint& next, const T& value) {
    set(next++, value);
  }
  template <class... T>
  void set_next(cl_uint& next, const std::tuple<T...>& values) {
    std::apply([&](const auto&... value) { (set_next(next, value), ...); }, values);
  }
  template <class T>
  void set_next(cl_uint& next, const std::vector<T>& values) {
    for (const T& value : values) set_next(next, value);
  }

  KernelHandle kernel_;
};

/// Run times of these finished kernels, in seconds. Empties `events`.
std::vector<double> take_seconds(std::vector<Event>& events);

/// A kernel that runs for single substeps in groups of a fixed size. Its first parameter is the substep's slot.
class SlotKernel : public Kernel {
 public:
  static constexpr cl_uint kAfterSlot = 1;  ///< number of the first argument behind the slot

  /// `items`: work-items of a run, where all runs have as many. Groups are smaller than `group` where the device cannot
  /// run the kernel in such large ones. The device must outlive the kernel. Throws RunError where the kernel needs more
  /// local memory than the device has.
  SlotKernel(const Device& device, const Program& program, const char* name, std::size_t group, std::size_t items = 1);

  /// Enqueues at least `items` work-items for the substep in `slot`. With 0 items one group runs, so that every substep
  /// has a time; kernels ignore work-items beyond their range.
  void run(int slot, std::size_t items);
  void run(int slot) { run(slot, items_); }
  /// Run times by slot since the last call, in seconds. The queue must have finished.
  std::vector<double> take_seconds();
  /// Their sum, in seconds.
  double take_total_s();

 private:
  const Device* device_;
  std::size_t group_, items_;
  std::vector<Event> events_;
  std::vector<int> slots_;  // of the events
};

/// A folder for compiled kernels. PoCL keeps them in POCL_CACHE_DIR, else in XDG_CACHE_HOME/pocl/kcache, else in
/// HOME/.cache/pocl/kcache, and has no device where it cannot write there. In that case, and where none of these
/// variables is set, POCL_CACHE_DIR is set to a folder of this user in TMPDIR or /tmp, which later runs find again.
/// Create it before the first call of OpenCL and before other threads.
class KernelCache {
 public:
  /// Throws InputError where there is no writable folder at all.
  KernelCache();
  ~KernelCache();
  KernelCache(const KernelCache&) = delete;
  KernelCache& operator=(const KernelCache&) = delete;

  /// Why the usual folder is not used, and which is instead; "": it is used.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  std::string temporary_;  ///< removed at the end; "" where the folder is kept
  std::string note_;
};

}  // namespace reamsim::cl
