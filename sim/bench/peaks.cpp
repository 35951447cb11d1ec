// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/peaks.h"

#include <algorithm>
#include <cmath>

namespace reamsim {
namespace embedded {
extern const char* const kernel_peaks;
}

namespace bench {

namespace {

constexpr int kRepetitions = 5;

/// The shortest time of a kernel, s.
double shortest(const cl::Kernel& kernel, const cl::Device& device, std::size_t items) {
  double best = INFINITY;
  for (int i = 0; i < kRepetitions; ++i) {
    std::vector<cl::Event> events;
    events.push_back(kernel.launch(device, items, 1));
    device.finish();
    best = std::min(best, cl::take_seconds(events).front());
  }
  return best;
}

}  // namespace

MachinePeaks measure_peaks(const cl::DeviceInfo& info) {
  constexpr std::size_t kVector = 16 * sizeof(cl_float), kItems = 4096, kVectors = 512;
  constexpr cl_int kRounds = 4096;
  constexpr double kOperations = 256;  // of a round
  const cl::Device device(info);
  const cl::Program program = device.build("peaks.cl", embedded::kernel_peaks);
  const cl::Buffer<cl_uchar> from(device, kItems * kVectors * kVector, "memory to copy");
  const cl::Buffer<cl_uchar> to(device, from.count(), "a copy of memory");
  cl::Kernel multiply_add(program, "fused_multiply_adds"), copy(program, "copy_memory");
  multiply_add.set_from(0, to, kRounds);
  copy.set_from(0, from, to, static_cast<cl_int>(kVectors));
  MachinePeaks out;
  out.gops = 1e-9 * kOperations * kRounds * kItems / shortest(multiply_add, device, kItems);
  out.gb_s = 1e-9 * 2 * static_cast<double>(from.count()) / shortest(copy, device, kItems);
  return out;
}

}  // namespace bench
}  // namespace reamsim
