#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/exact/visit_plan.h"

namespace reamsim {

/// Signed distances to a tool's surface over coarse cells of (r, z); see CoarseGrid in kernels/bricks.h.
struct CoarseDistance {
  CoarseGrid grid{};
  std::vector<float> mm;  ///< at the cells' centres
};

/// Covers every point within the longest reach of kernels/list_bricks.cl, and `slack_mm` more, of the profile.
CoarseDistance make_coarse_distance(const Profile& profile, double voxel_mm, double slack_mm);

/// The bricks that the tool's surface can meet in a visit; see kernels/list_bricks.cl.
class ListBricks {
 public:
  /// `slack_mm`: a surface that clips may lie so far outside the profile.
  ListBricks(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const Profile& profile,
             double slack_mm, std::size_t work_group);

  /// Enqueues the listing of a visit's bricks, and returns how many there are.
  std::size_t list(const VisitPlan& visit, VisitCounts counts);
  /// Seconds that the listings since the last call took.
  double take_seconds();

  [[nodiscard]] const cl::Buffer<cl_uint>& listed() const { return listed_; }
  [[nodiscard]] const cl::Buffer<VisitCounts>& counts() const { return counts_; }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    substep,
    first_super,
    supers,
    shift_mm,
    coarse,
    distances,
    occupancy,
    slot_of_brick,
    bricks,
    listed,
    counts
  };

  const cl::Device& device_;
  std::size_t work_group_;
  float slack_mm_;
  cl::Buffer<CoarseGrid> grid_;
  cl::Buffer<float> distances_;
  cl::Buffer<cl_uint> listed_;
  cl::Buffer<VisitCounts> counts_;
  cl::Kernel kernel_;
  std::vector<cl::Event> events_;
};

}  // namespace reamsim
