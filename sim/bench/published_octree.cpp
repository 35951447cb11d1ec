#include <algorithm>
#include <array>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/published.h"
#include "sim/tool/morton.h"

namespace reamsim {
namespace embedded {
extern const char* const kernel_published_octree;
}

namespace bench {

namespace {

constexpr float kAirHu = -1000;
/// Groups of the first pass of the reduction; the second pass is one group.
constexpr std::size_t kPartialSums = 64;

std::vector<float> points_of(const PointShell& shell) {
  std::vector<float> points;
  points.reserve(3 * shell.codes.size());
  for (const std::uint64_t code : shell.codes) {
    const Vec3i cell = morton_decode(code);
    for (int i = 0; i < 3; ++i) points.push_back(static_cast<float>(cell[i]));
  }
  return points;
}

class PublishedOctree final : public Contender {
 public:
  PublishedOctree(const cl::DeviceInfo& info, const Arena& arena)
      : arena_(arena),
        device_(info),
        program_(device_.build("published_octree.cl", embedded::kernel_published_octree)),
        detect_(program_, "published_octree"),
        reduce_(program_, "published_reduce"),
        touched_kernel_(program_, "published_touched"),
        restore_kernel_(program_, "published_restore"),
        points_(arena.tool->shell.codes.size()),
        voxels_(static_cast<std::size_t>(arena.voxmap->grid.size())) {
    const auto steps = descent_steps(arena.voxmap->grid.dims.x());
    hu_ = {device_, voxels_, "the voxmap's HU"};
    collided_ = {device_, voxels_, "the voxmap's collision flags"};
    shell_ = {device_, 3 * points_, "the point shell"};
    frame_ = {device_, 1, "the frame"};
    steps_ = {device_, steps.size(), "the look-up table"};
    forces_ = {device_, 4 * points_, "the points' forces"};
    partial_ = {device_, 4 * kPartialSums, "the partial sums"};
    sum_ = {device_, 4, "the sum"};
    touched_ = {device_, points_, "the touched voxels"};
    touched_count_ = {device_, 1, "their number"};
    steps_.write(device_, steps.data(), steps.size());
    const auto points = points_of(arena.tool->shell);
    shell_.write(device_, points.data(), points.size());
    upload_bone();
    set_arguments(static_cast<int>(steps.size() / 8));
  }

  void prepare(const Substep& frame) override {
    const PublishedFrame args = published_frame(frame, std::nullopt, *arena_.tool, arena_.voxmap->grid);
    frame_.write(device_, &args, 1);
    touched_count_.clear(device_, 1);
    const cl::Event done = touched_kernel_.launch(device_, points_, kPublishedGroup);
    touched_count_.read(device_, &remembered_, 1);
    prepared_ = true;
  }

  BatchSample run(std::span<const Substep> frames, bool /*use_voi: there is none*/) override {
    BatchSample sample;
    for (const Substep& frame : frames) run_one(frame, sample);
    if (!std::exchange(prepared_, false)) changed_ = true;
    return sample;
  }

  void restore() override {
    if (changed_) {
      collided_.clear(device_, voxels_);
    } else if (remembered_ > 0) {
      restore_kernel_.set(1, remembered_);
      const cl::Event done = restore_kernel_.launch(device_, remembered_, kPublishedGroup);
    }
    device_.finish();
    changed_ = prepared_ = false;
    remembered_ = 0;
  }

  [[nodiscard]] StructureBytes bytes() const override { return {hu_.bytes() + collided_.bytes(), shell_.bytes()}; }
  [[nodiscard]] const Label& label() const override { return label_; }

 private:
  void upload_bone() {
    // A layer at a time, so that the host needs no second copy of the bone.
    const DensityMapping mapping;
    std::array<float, 256> hu_of_grade;
    for (int grade = 0; grade < 256; ++grade) {
      const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
      hu_of_grade[static_cast<std::size_t>(grade)] =
          grade == 0 ? kAirHu : static_cast<float>(mapping.hu_from_density(density));
    }
    const auto grades = dense_remaining_grades(*arena_.voxmap);
    constexpr std::size_t kChunk = std::size_t{1} << 22;
    std::vector<float> chunk;
    for (std::size_t first = 0; first < voxels_; first += kChunk) {
      chunk.clear();
      for (std::size_t e = first; e < std::min(voxels_, first + kChunk); ++e) chunk.push_back(hu_of_grade[grades[e]]);
      hu_.write(device_, chunk.data(), chunk.size(), first);
    }
    collided_.clear(device_, voxels_);
  }

  void set_arguments(int levels) {
    const auto count = static_cast<cl_uint>(points_);
    detect_.set(0, shell_);
    detect_.set(1, count);
    detect_.set(2, frame_);
    detect_.set(3, hu_);
    detect_.set(4, collided_);
    detect_.set(5, steps_);
    detect_.set(6, static_cast<cl_int>(levels));
    detect_.set(7, forces_);
    reduce_.set_local(3, kPublishedGroup * 4 * sizeof(float));
    touched_kernel_.set(0, shell_);
    touched_kernel_.set(1, count);
    touched_kernel_.set(2, frame_);
    touched_kernel_.set(3, hu_);
    touched_kernel_.set(4, touched_);
    touched_kernel_.set(5, touched_count_);
    restore_kernel_.set(0, touched_);
    restore_kernel_.set(2, collided_);
  }

  cl::Event reduce(const cl::Buffer<float>& in, std::size_t count, const cl::Buffer<float>& out, std::size_t groups) {
    reduce_.set(0, in);
    reduce_.set(1, static_cast<cl_uint>(count));
    reduce_.set(2, out);
    return reduce_.launch(device_, groups * kPublishedGroup, kPublishedGroup);
  }

  void run_one(const Substep& frame, BatchSample& sample) {
    const Stopwatch watch;
    const bool overlap = boxes_overlap(arena_.tool_box, arena_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += watch.seconds();
    if (!overlap) {
      sample.total_s += watch.seconds();
      return;
    }
    const Stopwatch upload;
    const PublishedFrame args = published_frame(frame, std::nullopt, *arena_.tool, arena_.voxmap->grid);
    frame_.write(device_, &args, 1, 0, false);
    sample.upload_s += upload.seconds();
    std::vector<cl::Event> events;
    events.push_back(detect_.launch(device_, points_, kPublishedGroup));
    events.push_back(reduce(forces_, points_, partial_, kPartialSums));
    events.push_back(reduce(partial_, kPartialSums, sum_, 1));
    float result[4];
    sum_.read(device_, result, 4);
    sample.total_s += watch.seconds();
    for (const double s : cl::take_seconds(events)) sample.kernel_s += s;
    sample.contacts += static_cast<std::int64_t>(result[3]);
    sample.force += Vec3(result[0], result[1], result[2]);
  }

  Arena arena_;
  Label label_{"octree", "published"};
  cl::Device device_;
  cl::Program program_;
  cl::Kernel detect_, reduce_, touched_kernel_, restore_kernel_;
  std::size_t points_;
  std::size_t voxels_;
  cl::Buffer<float> hu_;
  cl::Buffer<cl_uchar> collided_;
  cl::Buffer<float> shell_;
  cl::Buffer<PublishedFrame> frame_;
  cl::Buffer<cl_uint> steps_;
  cl::Buffer<float> forces_, partial_, sum_;
  cl::Buffer<cl_uint> touched_;
  cl::Buffer<cl_uint> touched_count_;
  cl_uint remembered_ = 0;
  bool prepared_ = false;  ///< what the next frame changes is remembered
  bool changed_ = false;   ///< by more than what is remembered
};

}  // namespace

std::unique_ptr<Contender> make_published_octree(const cl::DeviceInfo& device, const Arena& arena) {
  return std::make_unique<PublishedOctree>(device, arena);
}

}  // namespace bench
}  // namespace reamsim
