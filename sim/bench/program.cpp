// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/measure.h"

#include <fmt/core.h>
#include <algorithm>
#include <bit>
#include <map>
#include <optional>

#include "kernels/published.h"
#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/dense/dense_state.h"
#include "sim/tool/point_shell.h"

namespace reamsim::embedded {
extern const char* const kernel_published;
}

namespace reamsim::bench {

namespace {

/// Work-items per group of the published kernels, where the device can run as many.
constexpr std::size_t kGroup = 256;

/// The arguments of the published kernels for a substep, in shell cells and voxels. `voi` in T, mm; without it the
/// whole shell. Throws InputError unless the bone is a cube.
PublishedFrame published_frame(const Substep& substep, const std::optional<Aabb>& voi, const Tool& tool,
                               const VoxelGrid& grid) {
  if (grid.dims != Vec3i::Constant(grid.dims.x())) throw InputError("the published methods need a cubic lattice");
  const PointShell& shell = tool.shell;
  // The VOI in cells is that of the engines.
  const SubstepArgs args =
      voi ? make_args(substep, *voi, shell, grid, bench_cutting(), false) : args_without_voi(substep, tool, grid);
  const Rigid bone_from_tool = substep.pose.bone_from_tool();
  const Vec3 first_cell = shell.origin_mm + Vec3::Constant(0.5 * shell.cell_mm);
  const Vec3 origin = (bone_from_tool * first_cell - grid.origin_mm) / grid.voxel_mm;
  const Mat3 step = bone_from_tool.linear() * (shell.cell_mm / grid.voxel_mm);
  const Vec3 center = (Vec3(0, 0, kReamerMm) - first_cell) / shell.cell_mm;
  PublishedFrame frame{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) frame.voxel_from_cell[3 * i + j] = static_cast<float>(step(i, j));
    frame.voxel_origin[i] = static_cast<float>(origin[i]);
    frame.cap_center[i] = static_cast<float>(center[i]);
    frame.voi_min[i] = args.voi_min[i];
    frame.voi_max[i] = args.voi_max[i];
  }
  frame.side = grid.dims.x();
  return frame;
}

/// A published program. After a single frame restore() puts back the voxels that this frame removed, and need not
/// upload the whole bone.
class PublishedProgram : public Program {
 public:
  BatchSample run(std::span<const Substep> frames, bool use_voi) override {
    BatchSample sample;
    for (const Substep& frame : frames) run_one(frame, use_voi, sample);
    return sample;
  }

  void restore() override {
    if (frames_ > 1) {
      restore_all();
    } else if (frames_ == 1) {
      const cl::Event done = restore_.launch(device_, points_, group_of(restore_));
    }
    device_.finish();
    frames_ = 0;
  }

 protected:
  /// `has_voi`: points outside the VOI are culled, else the boxes alone are tested.
  PublishedProgram(const std::string& engine, const cl::DeviceInfo& info, const BenchSetup& setup, bool has_voi)
      : Program({engine, "published"}, setup),
        device_(info),
        program_(device_.build("published.cl", embedded::kernel_published,
                               fmt::format("-DAIR_HU={:.8e}f", static_cast<float>(kScale.of_air)))),
        points_(setup.tool->shell.codes.size()),
        frame_(device_, 1, "the frame"),
        restore_(program_, ("restore_" + engine).c_str()),
        has_voi_(has_voi) {}

  /// A power of two.
  std::size_t group_of(const cl::Kernel& kernel) {
    const auto [group, is_new] = groups_.try_emplace(&kernel, kGroup);
    if (is_new) group->second = std::min(kGroup, std::bit_floor(kernel.largest_group(device_.info())));
    return group->second;
  }
  /// Runs the kernels on the frame that was written, and adds contacts and force to `sample`.
  virtual void detect(std::vector<cl::Event>& events, BatchSample& sample) = 0;
  /// Restores the whole bone.
  virtual void restore_all() = 0;

  inline static const HuScale kScale{DensityMapping{}};
  bool count_contacts_ = false;  ///< in PublishedFrame::contacts
  cl::Device device_;
  cl::Program program_;
  std::size_t points_;
  cl::Buffer<PublishedFrame> frame_;
  cl::Kernel restore_;  ///< of the voxels of the last frame

 private:
  void run_one(const Substep& frame, bool use_voi, BatchSample& sample) {
    const Stopwatch stopwatch;
    const Rigid tool_from_bone = frame.pose.bone_from_tool().inverse();
    const bool overlap = boxes_overlap(setup_.tool_box, setup_.bone_box, tool_from_bone);
    const std::optional<Aabb> voi =
        overlap && has_voi_ ? volume_of_interest(setup_.tool_box, setup_.bone_box, tool_from_bone) : std::nullopt;
    std::vector<cl::Event> events;
    if (overlap && (voi || !has_voi_)) {
      const Stopwatch upload;
      host_frame_ = published_frame(frame, use_voi ? voi : std::nullopt, *setup_.tool, setup_.voxmap->grid);
      host_frame_.count_contacts = count_contacts_ ? 1 : 0;
      frame_.write(device_, &host_frame_, 1, 0, false);
      sample.upload_s += upload.seconds();
      detect(events, sample);
      ++frames_;
    }
    sample.total_s += stopwatch.seconds();
    for (const double s : cl::take_seconds(events)) sample.kernel_s += s;
  }

  PublishedFrame host_frame_{};  ///< lives until the non-blocking write is done
  bool has_voi_;
  std::map<const cl::Kernel*, std::size_t> groups_;
  int frames_ = 0;  ///< that may have removed voxels since the bone was whole
};

class PublishedDirect final : public PublishedProgram {
 public:
  PublishedDirect(const cl::DeviceInfo& info, const BenchSetup& setup, bool count)
      : PublishedProgram("direct", info, setup, true),
        kernel_(program_, "published_direct"),
        codes_(device_, points_, "the point shell"),
        whole_(cl::upload(device_, dense_remaining_grades(*setup.voxmap), "the whole voxmap")),
        bone_(device_, static_cast<std::size_t>(setup.voxmap->grid.size()), "the voxmap") {
    const PointShell& shell = setup_.tool->shell;
    if (shell.resolution > kNarrowResolution) throw InputError("the published shell has at most 1024 cells an edge");
    count_contacts_ = count;
    const std::vector<cl_uint> codes(shell.codes.begin(), shell.codes.end());
    codes_.write(device_, codes.data(), codes.size());
    restore_all();
    kernel_.set_from(0, codes_, static_cast<cl_uint>(points_), frame_, bone_);
    restore_.set_from(0, codes_, static_cast<cl_uint>(points_), frame_, whole_, bone_);
  }

  [[nodiscard]] StructureBytes bytes() const override { return {bone_.bytes(), codes_.bytes()}; }

 private:
  void restore_all() override { bone_.copy(device_, whole_, bone_.count()); }

  void detect(std::vector<cl::Event>& events, BatchSample& sample) override {
    events.push_back(kernel_.launch(device_, points_, group_of(kernel_)));
    PublishedFrame result;
    frame_.read(device_, &result, 1);
    sample.contacts += result.contacts;
    for (int i = 0; i < 3; ++i) sample.force[i] += static_cast<double>(result.force[i]) / RS_PUBLISHED_SCALE;
  }

  cl::Kernel kernel_;
  cl::Buffer<cl_uint> codes_;
  cl::Buffer<cl_uchar> whole_, bone_;
};

/// Groups of the first pass of the reduction; the second pass is one group.
constexpr std::size_t kPartialSums = 64;

/// Per level of the descent and octant the step in the index of a voxel. Throws InputError unless the edge is a power
/// of two.
std::vector<cl_uint> descent_steps(const VoxelGrid& grid) {
  if (!std::has_single_bit(static_cast<unsigned>(grid.dims.x()))) {
    throw InputError("the octree's cube has " + std::to_string(grid.dims.x()) +
                     " voxels an edge; expected a power of two");
  }
  std::vector<cl_uint> steps;
  for (const cl_uint4& child : octree_children(grid)) steps.push_back(child.s[3]);
  return steps;
}

class PublishedOctree final : public PublishedProgram {
 public:
  PublishedOctree(const cl::DeviceInfo& info, const BenchSetup& setup)
      : PublishedProgram("octree", info, setup, false),
        detect_(program_, "published_octree"),
        reduce_(program_, "published_reduce"),
        hu_(device_, static_cast<std::size_t>(setup.voxmap->grid.size()), "the voxmap's HU"),
        collided_(device_, hu_.count(), "the voxmap's collision flags"),
        shell_(cl::upload(device_, cell_numbers(setup.tool->shell), "the point shell")),
        steps_(cl::upload(device_, descent_steps(setup.voxmap->grid), "the look-up table")),
        forces_(device_, 4 * points_, "the points' forces"),
        partial_(device_, 4 * kPartialSums, "the partial sums"),
        sum_(device_, 4, "the sum") {
    upload_hu(device_, dense_remaining_grades(*setup.voxmap), kScale, hu_);
    restore_all();
    detect_.set_from(0, shell_, static_cast<cl_uint>(points_), frame_, hu_, collided_, steps_,
                     static_cast<cl_int>(steps_.count() / 8), forces_);
    reduce_.set_local(3, kGroup * 4 * sizeof(float));
    restore_.set_from(0, shell_, static_cast<cl_uint>(points_), frame_, collided_);
  }

  [[nodiscard]] StructureBytes bytes() const override { return {hu_.bytes() + collided_.bytes(), shell_.bytes()}; }

 private:
  void restore_all() override { collided_.clear(device_, collided_.count()); }

  cl::Event reduce(const cl::Buffer<float>& in, std::size_t count, const cl::Buffer<float>& out, std::size_t groups) {
    reduce_.set_from(0, in, static_cast<cl_uint>(count), out);
    const std::size_t group = group_of(reduce_);
    return reduce_.launch(device_, groups * group, group);
  }

  void detect(std::vector<cl::Event>& events, BatchSample& sample) override {
    events.push_back(detect_.launch(device_, points_, group_of(detect_)));
    events.push_back(reduce(forces_, points_, partial_, kPartialSums));
    events.push_back(reduce(partial_, kPartialSums, sum_, 1));
    float result[4];
    sum_.read(device_, result, 4);
    sample.contacts += static_cast<std::int64_t>(result[3]);
    sample.force += Vec3(result[0], result[1], result[2]);
  }

  cl::Kernel detect_, reduce_;
  cl::Buffer<float> hu_;
  cl::Buffer<cl_uchar> collided_;
  cl::Buffer<float> shell_;
  cl::Buffer<cl_uint> steps_;
  cl::Buffer<float> forces_, partial_, sum_;
};

class EngineProgram final : public Program {
 public:
  EngineProgram(const Label& label, const std::string& device, const BenchSetup& setup)
      : Program(label, setup), engine_(make_engine(settings(label.engine, device), *setup.voxmap, *setup.tool)) {}

  BatchSample run(std::span<const Substep> frames, bool use_voi) override {
    BatchSample sample;
    const Stopwatch stopwatch;
    for (const Substep& frame : frames) enqueue(frame, use_voi, sample);
    collect(sample);
    sample.total_s = stopwatch.seconds();
    keep_removed();  // bookkeeping of the benchmark
    return sample;
  }

  void restore() override {
    engine_->restore_voxels(*setup_.voxmap, removed_);
    removed_.clear();
  }

  [[nodiscard]] StructureBytes bytes() const override { return engine_->structure_bytes(); }

 private:
  static Scenario settings(const std::string& engine, const std::string& device) {
    Scenario scenario;
    scenario.name = "bench";
    scenario.engine.type = *from_name<EngineKind>(engine);
    scenario.engine.device = device;
    scenario.cutting = bench_cutting();
    return scenario;
  }

  void enqueue(const Substep& frame, bool use_voi, BatchSample& sample) {
    const auto voi = broad_phase(setup_.tool_box, setup_.bone_box, frame.pose.bone_from_tool().inverse());
    if (!voi) return;
    if (engine_->full()) {
      collect(sample);
      keep_removed();
    }
    const Stopwatch upload;
    const VoxelGrid& grid = setup_.voxmap->grid;
    engine_->enqueue(use_voi ? make_args(frame, *voi, setup_.tool->shell, grid, bench_cutting(), false)
                             : args_without_voi(frame, *setup_.tool, grid),
                     nullptr);
    sample.upload_s += upload.seconds();
  }

  void collect(BatchSample& sample) {
    const Batch batch = engine_->collect();
    for (const StageTimes& times : batch.times) sample.kernel_s += times.detect_s + times.cut_s;
    for (const SubstepSums& sums : batch.sums) {
      sample.voxels += sums.contacts;
      sample.removed += static_cast<double>(sums.removed) / RS_WHOLE_FILL;
      sample.force += force_of(sums);
    }
  }

  void keep_removed() {
    const RemovedFrames removed = engine_->take_removed();
    removed_.insert(removed_.end(), removed.begin(), removed.end());
  }

  std::unique_ptr<Engine> engine_;
  RemovedFrames removed_;  ///< since the bone was whole
};

}  // namespace

std::unique_ptr<Program> make_program(const Label& label, const std::string& device, const BenchSetup& setup,
                                      bool count) {
  if (label.variant == "deterministic") return std::make_unique<EngineProgram>(label, device, setup);
  const cl::DeviceInfo info = cl::choose_device(device);
  if (label.engine == "octree") return std::make_unique<PublishedOctree>(info, setup);
  return std::make_unique<PublishedDirect>(info, setup, count);
}

}  // namespace reamsim::bench
