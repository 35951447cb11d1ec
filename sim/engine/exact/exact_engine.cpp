// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engine.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "sim/engine/common/bone_faces.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/tables.h"
#include "sim/engine/exact/brick_batch_plan.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_exact;
extern const char* const kernel_list_bricks;
}  // namespace embedded

namespace {

/// On a CPU the items of a group run one after another, each with some 60 KB on the stack.
constexpr std::size_t kMostItemsOnStack = 16;

std::size_t group_size(const KernelOptions& options) {
  return options.shape == KernelShape::cpu ? std::min(options.work_group, kMostItemsOnStack) : options.work_group;
}

/// Work-items of a cut; on a CPU each takes bricks until none is left.
std::size_t items_of(const cl::DeviceInfo& info, const KernelOptions& options) {
  return options.shape == KernelShape::cpu ? info.compute_units * group_size(options) : cut_items(info, options);
}

cl::Program cut_program(const cl::Device& device, const BrickLayout& layout, const KernelOptions& options, bool teeth) {
  const std::string defines = cut_defines(layout, options.shape) + (teeth ? " -DRS_DISTANCE_GRID" : "");
  return device.build("cut_exact.cl", embedded::kernel_cut_exact, defines);
}

/// The most records of removed voxels in a visit: the 64 voxels of a block can be removed in as many substeps.
std::size_t max_records(std::size_t listed, int substeps) {
  return listed * 8 * static_cast<std::size_t>(std::min(substeps, 64));
}

/// The largest number of records of removed voxels in a visit; where more are possible it has fewer substeps.
constexpr std::size_t kMaxRecords = 8'000'000;

/// Where a GPU draws a screen, its watchdog ends kernels after two seconds. A GPU begins with visits of this many
/// substeps, and later has so many that a cut takes less than `kLongestCut_s`.
constexpr int kFirstVisit = 32;
constexpr double kLongestCut_s = 0.5;

/// The batch has no list of removed voxels, because every visit has one.
constexpr DeviceBatch::RemovedList kNoList{.words = 1, .room = 1, .per_substep = 1, .in_total = 1};

std::optional<DeviceTeeth> make_teeth(const cl::Device& device, const Tool& tool, const BoneView& bone,
                                      double bulge_mm) {
  if (!tool.teeth) return std::nullopt;
  return upload_teeth(device, *tool.teeth, bone.voxmap.grid.voxel_mm, bulge_mm,
                      device_bricks_bytes(bone, FillStore::pages));
}

/// `exact` over the bricks in reach of the tool's surface; see kernels/list_bricks.cl and kernels/cut_exact.cl.
class ExactEngine final : public Engine {
 public:
  ExactEngine(const cl::Device& device, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : device_(device),
        options_(choose_options(device.info(), scenario.engine.tuning)),
        grid_(bone.voxmap.grid),
        extent_(bone_extent(bone.voxmap)),
        outline_(make_outline_table(tool.profile, grid_.voxel_mm)),
        slack_mm_(tool.clip_slack_mm() + outline_.bulge_mm),
        tool_box_(tool.clip_bounds().expanded(outline_.bulge_mm)),
        bricks_(make_device_bricks(device_, bone, FillStore::pages,
                                   sizeof(cl_int) * bone.voxmap.grade.stored_bricks() + bone_faces_bytes(bone))),
        fill_(make_fill_pages(device_, bone)),
        faces_(upload_faces(device_, bone)),
        batch_(device_, kNoList),
        teeth_(make_teeth(device_, tool, bone, outline_.bulge_mm)),
        teeth_bytes_(tool.teeth ? tool.teeth->bytes() : 0),
        listed_(device_, std::max<std::size_t>(1, bricks_.layout.bricks), "the list of bricks in reach"),
        counts_(device_, 1, "the counts of a visit"),
        list_(device_, device_.build("list_bricks.cl", embedded::kernel_list_bricks), "list_bricks",
              options_.work_group),
        windows_(device_, RS_VISIT_SUBSTEPS, "the windows of a visit"),
        motion_windows_(device_, RS_VISIT_SUBSTEPS, "the windows of a visit"),
        device_outline_(upload_outline(device_, outline_)),
        cut_(device_, cut_program(device_, bricks_.layout, options_, teeth_.has_value()), "cut_exact",
             group_size(options_), items_of(device.info(), options_)),
        records_(device_, 1, "the list of removed voxels") {
    // The numbers of the first arguments that a visit does not set.
    constexpr cl_uint kListConstants = 4, kCutConstants = 6;
    const DistanceTable table = brick_distances(tool.profile, grid_.voxel_mm, slack_mm_);
    coarse_ = cl::upload(device_, std::array{coarse_grid(table)}, "the tool's distances");
    distances_ = cl::upload(device_, table.mm, "the tool's distances");
    list_.set_from(kListConstants, batch_.args(), coarse_, distances_, bricks_.occupancy, bricks_.slot_of_brick,
                   bricks_.dims, listed_, counts_);
    const EnergyTable energy = make_energy_table(scenario.cutting, grid_.voxel_mm);
    energy_ =
        cl::upload(device_, std::vector<float>(energy.energy_mj.begin(), energy.energy_mj.end()), "the energy table");
    const auto set_cut = [&](const auto&... teeth) {
      cut_.set_from(kCutConstants, batch_.args(), windows_, motion_windows_, listed_, counts_, bricks_.lattice_of_slot,
                    bricks_.occupancy, bricks_.dims, batch_.sums(), energy_, device_outline_, faces_,
                    bricks_.pool_arguments(), teeth...);
    };
    teeth_ ? set_cut(*teeth_) : set_cut();
  }

  /// Stores the arguments. collect() lists and cuts the bricks of several substeps at once.
  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    batch_.add(args);
    motions_.push_back(std::move(window));
  }
  [[nodiscard]] bool full() const override { return batch_.full(); }

  /// Visit by visit, lists the bricks in reach of the tool's surface and cuts them in all substeps of the visit.
  Batch collect() override {
    Batch out;
    removed_.clear();
    batch_.write_args();  // at once: a write for each substep takes longer than all other calls
    out.times.resize(static_cast<std::size_t>(batch_.used()));
    for (int first = 0; first < batch_.used();) {
      const auto [visit, listed] = plan_visit(first);
      if (listed > 0) {
        set_visit(visit, listed);
        cut_.run(visit.first);
        read_removed();
      }
      const double cut_s = cut_.take_total_s(), per_substep = 1.0 / (visit.end - visit.first);
      if (device_.info().gpu) limit_visits(visit.end - visit.first, cut_s);
      const StageTimes times{list_.take_total_s() * per_substep, cut_s * per_substep};
      std::fill(out.times.begin() + visit.first, out.times.begin() + visit.end, times);
      first = visit.end;
    }
    out.sums = batch_.collect();
    motions_.clear();
    return out;
  }

  RemovedFrames take_removed() override { return std::exchange(removed_, {}); }
  void read_fill(const Voxmap& /*voxmap*/, FillBricks& fill) override { read_pages(device_, bricks_, fill_, fill); }
  void restore(const BoneView& bone) override {
    upload_bone(device_, bone, bricks_);
    fill_ = make_fill_pages(device_, bone);
  }
  [[nodiscard]] std::string device() const override { return device_.info().name; }
  [[nodiscard]] std::size_t device_bytes() const override {
    return bricks_.bytes() + fill_.bytes() + cl::bytes_of(faces_) + records_.bytes() + DeviceBatch::bytes(kNoList) +
           listed_.bytes() + teeth_bytes_;
  }
  /// Without a shell; the tool's structure is the distance grid of resolved cutting edges.
  [[nodiscard]] StructureBytes structure_bytes() const override {
    return {bricks_.bytes() + fill_.bytes() + cl::bytes_of(faces_), teeth_bytes_};
  }

 private:
  /// Sets the substeps of the next visits by the time that the cut of the last one took.
  void limit_visits(int substeps, double cut_s) {
    if (cut_s > kLongestCut_s) most_substeps_ = std::max(1, substeps / 2);
    const bool whole = substeps >= most_substeps_ && cut_s > 0;
    if (whole && cut_s < kLongestCut_s / 4) most_substeps_ = std::min(2 * most_substeps_, RS_VISIT_SUBSTEPS);
  }

  /// Lists the bricks in reach in a visit, and returns their number.
  std::size_t list_bricks(const BrickBatchPlan& visit) {
    if (visit.superbricks.empty()) return 0;
    VisitCounts counts{.listed = 0, .pages = static_cast<rs_u32>(fill_.used), .removed = 0, .taken = 0};
    counts_.write(device_, &counts, 1, 0, false);
    const Vec3i first = visit.superbricks.first, size = visit.superbricks.size();
    list_.set_from(cl::SlotKernel::kAfterSlot, cl_int4{{first.x(), first.y(), first.z(), 0}},
                   cl_int4{{size.x(), size.y(), size.z(), 0}}, visit.shift_mm + static_cast<float>(slack_mm_));
    list_.run(visit.first, static_cast<std::size_t>(size.cast<std::int64_t>().prod()));
    counts_.read(device_, &counts, 1);
    return counts.listed;
  }

  /// As many substeps from `first` on as one visit can have, and the number of bricks in reach.
  std::pair<BrickBatchPlan, std::size_t> plan_visit(int first) {
    for (int most = most_substeps_;; most /= 2) {
      BrickBatchPlan visit = plan_brick_batch(batch_.args_used(), motions_, first, most, tool_box_, extent_);
      most = visit.end - first;
      const std::size_t listed = list_bricks(visit);
      if (most == 1 || max_records(listed, most) <= kMaxRecords) return {std::move(visit), listed};
    }
  }

  /// Makes room for what a visit cuts, and sets the arguments of its cut.
  void set_visit(const BrickBatchPlan& visit, std::size_t listed) {
    reserve_pages(device_, fill_.used + listed, grid_.voxel_mm, fill_);
    const std::size_t records = max_records(listed, visit.end - visit.first);
    if (records > records_.count()) records_ = {device_, records, "the list of removed voxels"};
    windows_.write(device_, visit.windows.data(), visit.windows.size(), 0, false);
    if (!visit.motions.empty()) motion_windows_.write(device_, visit.motions.data(), visit.motions.size(), 0, false);
    cut_.set_from(cl::SlotKernel::kAfterSlot, static_cast<cl_uint>(visit.windows.size()), fill_.page_of_slot,
                  fill_.slot_of_page, fill_.fills, records_);
  }

  void read_removed() {
    VisitCounts counts{};
    counts_.read(device_, &counts, 1);
    fill_.used = counts.pages;
    std::vector<RemovedBlock> blocks(counts.removed);
    if (!blocks.empty()) records_.read(device_, blocks.data(), blocks.size());
    for (const RemovedBlock& block : blocks) batch_.append_removed(block, grid_, removed_);
  }

  cl::Device device_;
  KernelOptions options_;
  VoxelGrid grid_;
  VoxelBox extent_;
  OutlineTable outline_;
  double slack_mm_;  ///< largest distance of the clipping surface from the profile
  Aabb tool_box_;
  DeviceBricks bricks_;
  FillPages fill_;
  DeviceFaces faces_;
  DeviceBatch batch_;
  MotionsOfSlots motions_;
  int most_substeps_ = device_.info().gpu ? kFirstVisit : RS_VISIT_SUBSTEPS;  ///< of a visit
  std::optional<DeviceTeeth> teeth_;  ///< the surface that clips instead of the profile
  std::size_t teeth_bytes_;
  cl::Buffer<CoarseGrid> coarse_;
  cl::Buffer<float> distances_;
  cl::Buffer<cl_uint> listed_;
  cl::Buffer<VisitCounts> counts_;
  cl::SlotKernel list_;
  cl::Buffer<float> energy_;
  cl::Buffer<SubstepWindow> windows_;
  cl::Buffer<MotionWindow> motion_windows_;
  DeviceOutline device_outline_;
  cl::SlotKernel cut_;
  cl::Buffer<RemovedBlock> records_;
  RemovedFrames removed_;
};

}  // namespace

std::unique_ptr<Engine> make_exact_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool) {
  return std::make_unique<ExactEngine>(device, scenario, bone, tool);
}

std::size_t exact_engine_bytes(const BoneView& bone, const Tool& tool, const ExactForecast& forecast) {
  const std::size_t stored = bone.voxmap.grade.stored_bricks();
  const std::size_t records = std::min(kMaxRecords, max_records(forecast.listed, RS_VISIT_SUBSTEPS));
  return device_bricks_bytes(bone, FillStore::pages) + bone_faces_bytes(bone) + sizeof(cl_uint) * stored +
         fill_pages_bytes(stored, forecast.partial + forecast.listed) + sizeof(RemovedBlock) * records +
         DeviceBatch::bytes(kNoList) + (tool.teeth ? tool.teeth->bytes() : 0);
}

}  // namespace reamsim
