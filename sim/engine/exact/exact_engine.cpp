// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/engines.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/tables.h"
#include "sim/engine/exact/brick_batch_plan.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_cut_exact;
extern const char* const kernel_list_bricks;
}  // namespace embedded

// The struct has the same layout on host and device.
static_assert(sizeof(VisitCounts) == 16);

namespace {

/// The bricks that the tool's surface can intersect in a visit; see kernels/list_bricks.cl.
class ListBricks {
 public:
  /// `slack_mm`: largest distance of the clipping surface from the profile.
  ListBricks(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const Profile& profile,
             double slack_mm, std::size_t work_group)
      : device_(device),
        slack_mm_(static_cast<float>(slack_mm)),
        listed_(device, std::max<std::size_t>(1, bone.layout.bricks), "the list of bricks in reach"),
        counts_(device, 1, "the counts of a visit"),
        kernel_(device, device.build("list_bricks.cl", embedded::kernel_list_bricks), "list_bricks", work_group) {
    constexpr cl_uint kAfterVisit = 4;  // number of the first argument that list() does not set
    const DistanceTable table = brick_distances(profile, bone.grid.voxel_mm, slack_mm);
    grid_ = cl::upload(device, std::array{coarse_grid(table)}, "the tool's distances");
    distances_ = cl::upload(device, table.mm, "the tool's distances");
    kernel_.set_from(kAfterVisit, batch.args(), grid_, distances_, bone.occupancy, bone.slot_of_brick, bone.dims,
                     listed_, counts_);
  }

  /// Lists the bricks of a visit, and returns their number.
  std::size_t list(const BrickBatchPlan& visit, VisitCounts counts) {
    if (visit.superbricks.empty()) return 0;
    counts_.write(device_, &counts, 1, 0, false);
    const Vec3i first = visit.superbricks.first, size = visit.superbricks.size();
    kernel_.set_from(cl::SlotKernel::kAfterSlot, cl_int4{{first.x(), first.y(), first.z(), 0}},
                     cl_int4{{size.x(), size.y(), size.z(), 0}}, visit.shift_mm + slack_mm_);
    kernel_.run(visit.first, static_cast<std::size_t>(size.cast<std::int64_t>().prod()));
    counts_.read(device_, &counts, 1);
    return counts.listed;
  }
  /// Run time of the lists since the last call, s.
  double take_seconds() { return kernel_.take_total_s(); }

  [[nodiscard]] const cl::Buffer<cl_uint>& listed() const { return listed_; }
  [[nodiscard]] const cl::Buffer<VisitCounts>& counts() const { return counts_; }

 private:
  const cl::Device& device_;
  float slack_mm_;
  cl::Buffer<CoarseGrid> grid_;
  cl::Buffer<float> distances_;
  cl::Buffer<cl_uint> listed_;
  cl::Buffer<VisitCounts> counts_;
  cl::SlotKernel kernel_;
};

/// On a CPU the items of a group run one after another, each with some 60 KB on the stack.
constexpr std::size_t kMostItemsOnStack = 16;

std::size_t group_size(const KernelOptions& options) {
  return options.shape == KernelShape::cpu ? std::min(options.work_group, kMostItemsOnStack) : options.work_group;
}

/// `exact` over the bricks in reach; see kernels/cut_exact.cl.
class CutExact {
 public:
  /// `teeth`: the surface that clips instead of the profile; nullptr for the envelope.
  CutExact(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const ListBricks& list,
           const OutlineTable& outline, const EnergyTable& table, const KernelOptions& options,
           const DeviceTeeth* teeth)
      : device_(device),
        // On a CPU a work-item takes bricks until none is left.
        items_(options.shape == KernelShape::cpu ? device.info().compute_units * group_size(options)
                                                 : cut_items(device.info(), options)),
        energy_(
            cl::upload(device, std::vector<float>(table.energy_mj.begin(), table.energy_mj.end()), "the energy table")),
        windows_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
        motions_(device, RS_VISIT_SUBSTEPS, "the windows of a visit"),
        outline_(device, outline),
        kernel_(device,
                device.build("cut_exact.cl", embedded::kernel_cut_exact,
                             cut_defines(bone.layout, options.shape) + (teeth != nullptr ? " -DRS_DISTANCE_GRID" : "")),
                "cut_exact", group_size(options)) {
    constexpr cl_uint kAfterPlan = 6;  // number of the first argument that enqueue() does not set
    const std::vector<cl_mem> pools = bone.pool_arguments();
    const auto set_constant = [&](const auto&... teeth_arguments) {
      kernel_.set_from(kAfterPlan, batch.args(), windows_, motions_, list.listed(), list.counts(), bone.lattice_of_slot,
                       bone.occupancy, bone.dims, batch.sums(), energy_, outline_.arguments(), pools,
                       teeth_arguments...);
    };
    teeth != nullptr ? set_constant(teeth->arguments()) : set_constant();
  }

  /// The largest number of records of removed voxels in a visit: the 64 voxels of a block can be removed in as many
  /// substeps.
  [[nodiscard]] static std::size_t max_records(std::size_t listed, int substeps) {
    return listed * 8 * static_cast<std::size_t>(std::min(substeps, 64));
  }
  /// Enqueues a visit of the listed bricks. `fill` needs room for a page per brick, `removed` for every record.
  void enqueue(const BrickBatchPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed) {
    windows_.write(device_, plan.windows.data(), plan.windows.size(), 0, false);
    if (!plan.motions.empty()) motions_.write(device_, plan.motions.data(), plan.motions.size(), 0, false);
    kernel_.set_from(cl::SlotKernel::kAfterSlot, static_cast<cl_uint>(plan.windows.size()), fill.page_of_slot,
                     fill.slot_of_page, fill.fills, removed);
    kernel_.run(plan.first, items_);
  }
  /// Run time of the visits since the last call, s.
  double take_seconds() { return kernel_.take_total_s(); }

 private:
  const cl::Device& device_;
  std::size_t items_;
  cl::Buffer<float> energy_;
  cl::Buffer<SubstepWindow> windows_;
  cl::Buffer<MotionWindow> motions_;
  DeviceOutline outline_;
  cl::SlotKernel kernel_;
};

/// The largest number of records of removed voxels in a visit; where more are possible it has fewer substeps.
constexpr std::size_t kMaxRecords = 8'000'000;

/// The batch has no list of removed voxels, because every visit has one.
constexpr DeviceBatch::RemovedList kNoList{.words = 1, .room = 1, .per_substep = 1, .in_total = 1};

std::optional<DeviceTeeth> make_teeth(const cl::Device& device, const Tool& tool, const BoneView& bone,
                                      double bulge_mm) {
  if (!tool.teeth) return std::nullopt;
  return DeviceTeeth(device, *tool.teeth, bone.voxmap.grid.voxel_mm, bulge_mm,
                     device_bricks_bytes(bone, FillStore::pages));
}

class ExactEngine final : public Engine {
 public:
  ExactEngine(const cl::Device& device, const Scenario& scenario, const BoneView& bone, const Tool& tool)
      : device_(device),
        grid_(bone.voxmap.grid),
        extent_(bone_extent(bone.voxmap)),
        outline_(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)),
        tool_box_(tool.clip_bounds().expanded(outline_.bulge_mm)),
        bricks_(
            make_device_bricks(device_, bone, FillStore::pages, sizeof(cl_int) * bone.voxmap.grade.stored_bricks())),
        fill_(make_fill_pages(device_, bone)),
        batch_(device_, kNoList),
        teeth_(make_teeth(device_, tool, bone, outline_.bulge_mm)),
        teeth_bytes_(tool.teeth ? tool.teeth->bytes() : 0),
        list_(device_, bricks_, batch_, tool.profile, tool.clip_slack_mm() + outline_.bulge_mm,
              choose_options(device.info(), scenario.engine.tuning).work_group),
        cut_(device_, bricks_, batch_, list_, outline_, make_energy_table(scenario.cutting, bone.voxmap.grid.voxel_mm),
             choose_options(device.info(), scenario.engine.tuning), teeth_ ? &*teeth_ : nullptr),
        records_(device_, 1, "the list of removed voxels") {}

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
      const BrickBatchPlan plan = visit(first);
      const double per_substep = 1.0 / (plan.end - plan.first);
      const StageTimes times{list_.take_seconds() * per_substep, cut_.take_seconds() * per_substep};
      std::fill(out.times.begin() + plan.first, out.times.begin() + plan.end, times);
      first = plan.end;
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
    return bricks_.bytes() + fill_.bytes() + records_.bytes() + DeviceBatch::bytes(kNoList) + list_.listed().bytes() +
           teeth_bytes_;
  }
  /// Without a shell; the tool's structure is the distance grid of resolved cutting edges.
  [[nodiscard]] StructureBytes structure_bytes() const override {
    return {bricks_.bytes() + fill_.bytes(), teeth_bytes_};
  }

 private:
  /// Cuts the bricks in reach in as many substeps from `first` on as one visit can have. Returns the visit.
  BrickBatchPlan visit(int first) {
    BrickBatchPlan plan = plan_brick_batch(batch_.args_used(), motions_, first, RS_VISIT_SUBSTEPS, tool_box_, extent_);
    VisitCounts counts{.listed = 0, .pages = static_cast<rs_u32>(fill_.used), .removed = 0, .taken = 0};
    std::size_t listed = list_.list(plan, counts);
    while (CutExact::max_records(listed, plan.end - first) > kMaxRecords && plan.end - first > 1) {
      plan = plan_brick_batch(batch_.args_used(), motions_, first, (plan.end - first) / 2, tool_box_, extent_);
      listed = list_.list(plan, counts);
    }
    if (listed == 0) return plan;
    reserve_pages(device_, fill_.used + listed, grid_.voxel_mm, fill_);
    const std::size_t records = CutExact::max_records(listed, plan.end - first);
    if (records > records_.count()) records_ = {device_, records, "the list of removed voxels"};
    cut_.enqueue(plan, fill_, records_);
    list_.counts().read(device_, &counts, 1);
    fill_.used = counts.pages;
    std::vector<RemovedBlock> blocks(counts.removed);
    if (!blocks.empty()) records_.read(device_, blocks.data(), blocks.size());
    for (const RemovedBlock& block : blocks) {
      append_removed(block, grid_, batch_.args_of(static_cast<int>(block.detail >> 3)).frame, removed_);
    }
    return plan;
  }

  cl::Device device_;
  VoxelGrid grid_;
  VoxelBox extent_;
  OutlineTable outline_;
  Aabb tool_box_;
  DeviceBricks bricks_;
  FillPages fill_;
  DeviceBatch batch_;
  MotionsOfSlots motions_;
  std::optional<DeviceTeeth> teeth_;
  std::size_t teeth_bytes_;
  ListBricks list_;
  CutExact cut_;
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
  const std::size_t records = std::min(kMaxRecords, CutExact::max_records(forecast.listed, RS_VISIT_SUBSTEPS));
  return device_bricks_bytes(bone, FillStore::pages) + sizeof(cl_uint) * stored +
         fill_pages_bytes(stored, forecast.partial + forecast.listed) + sizeof(RemovedBlock) * records +
         DeviceBatch::bytes(kNoList) + (tool.teeth ? tool.teeth->bytes() : 0);
}

}  // namespace reamsim
