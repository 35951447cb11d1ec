#include "sim/engine/dense/detect_implicit.h"

#include <algorithm>

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_implicit;
}

DetectImplicit::DetectImplicit(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                               const Profile& profile, const VoxelBox& bone, std::size_t work_group)
    : batch_(batch),
      tool_box_(profile.bounds()),
      bone_(bone),
      kernel_(device, device.build("detect_implicit.cl", embedded::kernel_detect_implicit), "detect_implicit",
              Argument::substep, work_group) {
  kernel_.set(Argument::args, batch.args());
  kernel_.set(Argument::bone, state.grades);
  kernel_.set(Argument::contacts, state.contacts);
  kernel_.set(Argument::contact_count, batch.contact_count());
  state.profile.set(kernel_, Argument::edges);
}

void DetectImplicit::enqueue(int slot) {
  const VoxelBox voi = voxel_voi(batch_.args_of(slot), tool_box_, bone_);
  const Vec3i size = voi.size();
  const cl_int4 first = {{voi.first.x(), voi.first.y(), voi.first.z(), 0}};
  const cl_uint4 count = {
      {static_cast<cl_uint>(size.x()), static_cast<cl_uint>(size.y()), static_cast<cl_uint>(size.z()), 0}};
  kernel_.set(Argument::voi_min, first);
  kernel_.set(Argument::voi_size, count);
  // A launch has at least one item, so that every substep has its time; the kernel lets those beyond the VOI go.
  const auto voxels = static_cast<std::size_t>(size.cast<std::int64_t>().prod());
  kernel_.run(slot, voxels);
}

}  // namespace reamsim
