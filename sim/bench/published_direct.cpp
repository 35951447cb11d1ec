#include <algorithm>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/published.h"
#include "sim/tool/morton.h"

namespace reamsim {
namespace embedded {
extern const char* const kernel_published_direct;
}

namespace bench {

namespace {

/// A voxel to put back, as the kernels write it.
struct Touched {
  cl_uint voxel;
  cl_uint grade;
};

class PublishedDirect final : public Contender {
 public:
  PublishedDirect(const cl::DeviceInfo& info, const Arena& arena, bool count)
      : arena_(arena),
        count_(count),
        device_(info),
        program_(device_.build("published_direct.cl", embedded::kernel_published_direct)),
        kernel_(program_, "published_direct"),
        touched_kernel_(program_, "published_touched"),
        restore_kernel_(program_, "published_restore"),
        points_(arena.tool->shell.codes.size()),
        codes_(device_, points_, "the point shell"),
        bone_(device_, static_cast<std::size_t>(arena.voxmap->grid.size()), "the voxmap"),
        frame_(device_, 1, "the frame"),
        touched_(device_, points_, "the touched voxels"),
        touched_count_(device_, 1, "their number") {
    upload_codes();
    upload_bone();
    kernel_.set(0, codes_);
    kernel_.set(1, static_cast<cl_uint>(points_));
    kernel_.set(2, frame_);
    kernel_.set(3, bone_);
    touched_kernel_.set(0, codes_);
    touched_kernel_.set(1, static_cast<cl_uint>(points_));
    touched_kernel_.set(2, frame_);
    touched_kernel_.set(3, bone_);
    touched_kernel_.set(4, touched_);
    touched_kernel_.set(5, touched_count_);
    restore_kernel_.set(0, touched_);
    restore_kernel_.set(2, bone_);
  }

  void prepare(const Substep& frame) override {
    const PublishedFrame args = published_frame(frame, std::nullopt, *arena_.tool, arena_.voxmap->grid);
    frame_.write(device_, &args, 1);
    touched_count_.clear(device_, 1);
    const cl::Event done = touched_kernel_.launch(device_, points_, kPublishedGroup);
    touched_count_.read(device_, &remembered_, 1);
    prepared_ = true;
  }

  BatchSample run(std::span<const Substep> frames, bool use_voi) override {
    BatchSample sample;
    for (const Substep& frame : frames) run_one(frame, use_voi, sample);
    if (!std::exchange(prepared_, false)) changed_ = true;
    return sample;
  }

  void restore() override {
    if (changed_) {
      upload_bone();
    } else if (remembered_ > 0) {
      restore_kernel_.set(1, remembered_);
      const cl::Event done = restore_kernel_.launch(device_, remembered_, kPublishedGroup);
      device_.finish();
    }
    changed_ = prepared_ = false;
    remembered_ = 0;
  }

  [[nodiscard]] StructureBytes bytes() const override { return {bone_.bytes(), codes_.bytes()}; }
  [[nodiscard]] const Label& label() const override { return label_; }

 private:
  void upload_codes() {
    const PointShell& shell = arena_.tool->shell;
    if (shell.resolution > kNarrowResolution) throw InputError("the published shell has at most 1024 cells an edge");
    const std::vector<cl_uint> codes(shell.codes.begin(), shell.codes.end());
    codes_.write(device_, codes.data(), codes.size());
  }

  void upload_bone() {
    const auto grades = dense_remaining_grades(*arena_.voxmap);
    bone_.write(device_, grades.data(), grades.size());
  }

  void run_one(const Substep& frame, bool use_voi, BatchSample& sample) {
    const Stopwatch watch;
    const auto voi = broad_phase(arena_.tool_box, arena_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += watch.seconds();
    if (!voi) {
      sample.total_s += watch.seconds();
      return;
    }
    const Stopwatch upload;
    PublishedFrame args = published_frame(frame, use_voi ? voi : std::nullopt, *arena_.tool, arena_.voxmap->grid);
    args.count_contacts = count_ ? 1 : 0;
    frame_.write(device_, &args, 1, 0, false);
    sample.upload_s += upload.seconds();
    std::vector<cl::Event> events;
    events.push_back(kernel_.launch(device_, points_, kPublishedGroup));
    PublishedFrame result;
    frame_.read(device_, &result, 1);
    sample.total_s += watch.seconds();
    sample.kernel_s += cl::take_seconds(events).front();
    sample.contacts += result.contacts;
    for (int i = 0; i < 3; ++i) sample.force[i] += static_cast<double>(result.force[i]) / RS_PUBLISHED_SCALE;
  }

  Arena arena_;
  bool count_;
  Label label_{"direct", "published"};
  cl::Device device_;
  cl::Program program_;
  cl::Kernel kernel_, touched_kernel_, restore_kernel_;
  std::size_t points_;
  cl::Buffer<cl_uint> codes_;
  cl::Buffer<cl_uchar> bone_;
  cl::Buffer<PublishedFrame> frame_;
  cl::Buffer<Touched> touched_;
  cl::Buffer<cl_uint> touched_count_;
  cl_uint remembered_ = 0;
  bool prepared_ = false;  ///< what the next frame changes is remembered
  bool changed_ = false;   ///< by more than what is remembered
};

}  // namespace

std::unique_ptr<Contender> make_published_direct(const cl::DeviceInfo& device, const Arena& arena, bool count) {
  return std::make_unique<PublishedDirect>(device, arena, count);
}

}  // namespace bench
}  // namespace reamsim
