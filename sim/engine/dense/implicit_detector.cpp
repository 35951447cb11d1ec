#include "sim/engine/dense/implicit_detector.h"

#include <algorithm>

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_implicit;
}

ImplicitDetector::ImplicitDetector(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                                   const Profile& profile, const VoxelBox& bone, std::size_t work_group)
    : batch_(batch),
      tool_box_(profile.bounds()),
      bone_(bone),
      kernel_(device, device.build("detect_implicit.cl", embedded::kernel_detect_implicit), "detect_implicit", 1,
              work_group) {
  kernel_.set(0, batch.args());
  kernel_.set(4, state.grades);
  kernel_.set(5, state.contacts);
  kernel_.set(6, batch.contact_count());
  state.profile.set(kernel_, 7);
}

void ImplicitDetector::detect(int slot) {
  const VoxelBox voi = voxel_voi(batch_.args_of(slot), tool_box_, bone_);
  const Vec3i size = voi.size();
  const cl_int4 first = {{voi.first.x(), voi.first.y(), voi.first.z(), 0}};
  const cl_uint4 count = {
      {static_cast<cl_uint>(size.x()), static_cast<cl_uint>(size.y()), static_cast<cl_uint>(size.z()), 0}};
  kernel_.set(2, first);
  kernel_.set(3, count);
  // A launch has at least one item, so that every substep has its time; the kernel lets those beyond the VOI go.
  const auto voxels = static_cast<std::size_t>(size.cast<std::int64_t>().prod());
  kernel_.run(slot, voxels);
}

}  // namespace reamsim
