#include "sim/engine/dense/restore_voxels.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_restore_voxels;
}

namespace {

constexpr std::size_t kGroup = 64;

}  // namespace

VoxelRestorer::VoxelRestorer(const cl::Device& device)
    : device_(device),
      program_(device.build("restore_voxels.cl", embedded::kernel_restore_voxels)),
      bytes_(program_, "restore_bytes"),
      halves_(program_, "restore_halves"),
      words_(program_, "restore_words") {}

void VoxelRestorer::put(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel) {
  if (entries.empty()) return;
  cl::Buffer<Entry> list(device_, entries.size(), "the voxels to put back");
  list.write(device_, entries.data(), entries.size());
  kernel.set_from(0, list, static_cast<cl_uint>(entries.size()), values);
  const cl::Event done = kernel.launch(device_, entries.size(), kGroup);
  device_.finish();
}

}  // namespace reamsim
