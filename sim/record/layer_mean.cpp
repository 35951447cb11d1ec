#include "sim/record/layer_mean.h"

namespace reamsim {

namespace {

/// The tool stands still where its step is below this fraction of the mean step.
constexpr double kStillFraction = 0.01;

}  // namespace

void LayerMean::drop_oldest() {
  sums_.axial_force_n -= frames_.front().values.axial_force_n;
  sums_.spin_torque_nmm -= frames_.front().values.spin_torque_nmm;
  frames_.pop_front();
}

LayerMean::Means LayerMean::add(const Vec3& position_mm, double axial_force_n, double spin_torque_nmm) {
  const double step = frames_.empty() ? 0 : (position_mm - last_mm_).norm();
  const double path = frames_.empty() ? 0 : frames_.back().path_mm + step;
  if (full_ && step * static_cast<double>(frames_.size()) < kStillFraction * voxel_mm_) drop_oldest();
  last_mm_ = position_mm;
  frames_.push_back({path, {axial_force_n, spin_torque_nmm, 1}});
  sums_.axial_force_n += axial_force_n;
  sums_.spin_torque_nmm += spin_torque_nmm;
  // A frame is dropped when the travel after its end amounts to a voxel.
  while (frames_.size() > 1 && path - frames_.front().path_mm >= voxel_mm_ * (1 - 1e-9)) {
    drop_oldest();
    full_ = true;
  }
  if (!full_) return {};
  const auto count = static_cast<double>(frames_.size());
  return {sums_.axial_force_n / count, sums_.spin_torque_nmm / count, frames_.size()};
}

}  // namespace reamsim
