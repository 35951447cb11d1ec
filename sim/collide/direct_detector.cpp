#include "sim/collide/direct_detector.h"

#include <algorithm>

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_direct;
}

DirectDetector::DirectDetector(const cl::Device& device, const DenseState& state, const DeviceBatch& batch,
                               std::size_t work_group)
    : device_(device),
      points_(state.points),
      work_group_(work_group),
      program_(device.build("detect_direct.cl", embedded::kernel_detect_direct)),
      kernel_(program_, "detect_direct") {
  kernel_.set(0, state.codes);
  kernel_.set(1, static_cast<cl_uint>(points_));
  kernel_.set(2, batch.args());
  kernel_.set(4, state.bone);
  kernel_.set(5, state.claims);
  kernel_.set(6, state.contacts);
  kernel_.set(7, batch.contact_count());
  kernel_.set(8, batch.sums());
  state.profile.set(kernel_, 9);
}

void DirectDetector::detect(int slot) {
  kernel_.set(3, static_cast<cl_uint>(slot));
  // A launch has at least one item; the kernel lets those beyond the last point go.
  events_.push_back(kernel_.launch(device_, std::max<std::size_t>(1, points_), work_group_));
}

std::vector<double> DirectDetector::take_seconds() {
  return cl::take_seconds(events_);
}

}  // namespace reamsim
