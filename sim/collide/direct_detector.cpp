#include "sim/collide/direct_detector.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_detect_direct;
}

DirectDetector::DirectDetector(const cl::Device& device, DeviceState& state, std::size_t work_group)
    : device_(device),
      points_(state.points),
      work_group_(work_group),
      program_(
          device.build("detect_direct.cl", embedded::kernel_detect_direct, state.wide_codes ? "-DRS_WIDE_CODES" : "")),
      kernel_(program_, "detect_direct") {
  kernel_.set(0, state.codes);
  kernel_.set(1, static_cast<cl_uint>(points_));
  kernel_.set(2, state.args);
  kernel_.set(4, state.bone);
  kernel_.set(5, state.claims);
  kernel_.set(6, state.contacts);
  kernel_.set(7, state.contact_count);
  kernel_.set(8, state.sums);
  kernel_.set(9, state.edges);
  kernel_.set(10, static_cast<cl_int>(state.edges.count()));
}

void DirectDetector::detect(int slot) {
  kernel_.set(3, static_cast<cl_uint>(slot));
  events_.push_back(kernel_.launch(device_, points_, work_group_));
}

std::vector<double> DirectDetector::take_seconds() {
  return cl::take_seconds(events_);
}

}  // namespace reamsim
