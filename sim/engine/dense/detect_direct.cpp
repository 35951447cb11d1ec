#include "sim/engine/dense/detect_direct.h"

#include <algorithm>

#include "sim/tool/morton.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_direct;
}

namespace {

bool wide(const PointShell& shell) {
  return shell.resolution > kNarrowResolution;
}

/// 4 bytes a point, as the paper has it, or 8 beyond 1024 cells an axis.
cl::Buffer<cl_uint> upload_codes(const cl::Device& device, const PointShell& shell) {
  std::vector<cl_uint> words;
  words.reserve(shell.codes.size() * (wide(shell) ? 2 : 1));
  for (const std::uint64_t code : shell.codes) {
    words.push_back(static_cast<cl_uint>(code));
    if (wide(shell)) words.push_back(static_cast<cl_uint>(code >> 32));
  }
  cl::Buffer<cl_uint> buffer(device, std::max<std::size_t>(2, words.size()), "the point shell");
  if (!words.empty()) buffer.write(device, words.data(), words.size());
  return buffer;
}

}  // namespace

DetectDirect::DetectDirect(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                           const PointShell& shell, std::size_t work_group)
    : points_(shell.codes.size()),
      codes_(upload_codes(device, shell)),
      kernel_(device,
              device.build("detect_direct.cl", embedded::kernel_detect_direct, wide(shell) ? "-DRS_WIDE_CODES" : ""),
              "detect_direct", Argument::substep, work_group) {
  kernel_.set(Argument::codes, codes_);
  kernel_.set(Argument::point_count, static_cast<cl_uint>(points_));
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::bone, state.grades);
  kernel_.set(Argument::claims, state.claims);
  kernel_.set(Argument::contacts, state.contacts);
  kernel_.set(Argument::contact_count, batch.contact_count());
  kernel_.set(Argument::sums, batch.sums());
  state.profile.set(kernel_, Argument::edges);
}

void DetectDirect::enqueue(int slot) {
  kernel_.run(slot, points_);
}

}  // namespace reamsim
