#include "sim/cut/voxel_restorer.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_restore_voxels;
}

namespace {

constexpr std::size_t kGroup = 64;

}  // namespace

VoxelRestorer::VoxelRestorer(const cl::Device& device)
    : device_(device),
      hu_(state.hu.count() > 0),
      program_(device.build("restore_voxels.cl", embedded::kernel_restore_voxels, hu_ ? "-DREAMSIM_FLAGGED_HU" : "")),
      kernel_(program_, "restore_voxels") {
  if (hu_) {
    kernel_.set(2, state.hu);
  } else {
    kernel_.set(2, state.grades);
  }
  kernel_.set(3, state.fill);
  kernel_.set(4, static_cast<cl_int>(state.has_fill ? 1 : 0));
  kernel_.set(5, state.scale.of_air);
  kernel_.set(6, state.scale.per_grade);
}

void VoxelRestorer::restore(const Voxmap& voxmap, const RemovedFrames& gone) {
  if (gone.empty()) return;
  std::vector<PutBack> list;
  list.reserve(gone.size());
  for (const auto& [voxel, frame] : gone) {
    const cl_uint fill = voxmap.fill.get(voxmap.grid.coord(voxel));
    const cl_uint grade = fill == 0 ? 0 : voxmap.grade.get(voxmap.grid.coord(voxel));
    list.push_back({static_cast<cl_uint>(voxel), fill << 8 | grade});
  }
  cl::Buffer<PutBack> buffer(device_, list.size(), "the voxels to put back");
  buffer.write(device_, list.data(), list.size());
  kernel_.set(0, buffer);
  kernel_.set(1, static_cast<cl_uint>(list.size()));
  const cl::Event done = kernel_.launch(device_, list.size(), kGroup);
  device_.finish();
}

}  // namespace reamsim
