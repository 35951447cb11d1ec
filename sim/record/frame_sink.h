#pragma once

#include <cstdint>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/record/results.h"

namespace reamsim {

/// Seconds that the stages of a frame took: broad phase on the host, detect and cut on the device.
struct FrameTimes {
  double broad_phase_s = 0;
  double detect_s = 0;
  double cut_s = 0;
};

/// Takes what a run gives while it goes: into files (Recorder), or into memory.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void frame(const FrameResult& result, const FrameTimes& times) = 0;
  /// The fill of the bone after `frame`, whose changes since the last call the sink may take.
  virtual void snapshot(std::int64_t frame, FillBricks& fill) = 0;
  virtual void removed(const RemovedFrames& voxels) = 0;
};

}  // namespace reamsim
