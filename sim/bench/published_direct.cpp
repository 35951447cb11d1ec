// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

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

class PublishedDirect final : public PublishedProgram {
 public:
  PublishedDirect(const cl::DeviceInfo& info, const BenchSetup& setup, bool count)
      : PublishedProgram("direct", info, setup, embedded::kernel_published_direct, 2),
        count_(count),
        kernel_(program_, "published_direct"),
        codes_(device_, points_, "the point shell"),
        bone_(device_, static_cast<std::size_t>(setup.voxmap->grid.size()), "the voxmap") {
    const PointShell& shell = setup_.tool->shell;
    if (shell.resolution > kNarrowResolution) throw InputError("the published shell has at most 1024 cells an edge");
    const std::vector<cl_uint> codes(shell.codes.begin(), shell.codes.end());
    codes_.write(device_, codes.data(), codes.size());
    restore_all();
    kernel_.set_from(0, codes_, static_cast<cl_uint>(points_), frame_, bone_);
    set_restoring(codes_, bone_, bone_);
  }

  [[nodiscard]] StructureBytes bytes() const override { return {bone_.bytes(), codes_.bytes()}; }

 private:
  void restore_all() override {
    const auto grades = dense_remaining_grades(*setup_.voxmap);
    bone_.write(device_, grades.data(), grades.size());
  }

  void run_one(const Substep& frame, bool use_voi, BatchSample& sample) override {
    const Stopwatch stopwatch;
    const auto voi = broad_phase(setup_.tool_box, setup_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += stopwatch.seconds();
    if (!voi) {
      sample.total_s += stopwatch.seconds();
      return;
    }
    const Stopwatch upload;
    PublishedFrame args = published_frame(frame, use_voi ? voi : std::nullopt, *setup_.tool, setup_.voxmap->grid);
    args.count_contacts = count_ ? 1 : 0;
    frame_.write(device_, &args, 1, 0, false);
    sample.upload_s += upload.seconds();
    std::vector<cl::Event> events;
    events.push_back(kernel_.launch(device_, points_, kPublishedGroup));
    PublishedFrame result;
    frame_.read(device_, &result, 1);
    sample.total_s += stopwatch.seconds();
    sample.kernel_s += cl::take_seconds(events).front();
    sample.contacts += result.contacts;
    for (int i = 0; i < 3; ++i) sample.force[i] += static_cast<double>(result.force[i]) / RS_PUBLISHED_SCALE;
  }

  bool count_;
  cl::Kernel kernel_;
  cl::Buffer<cl_uint> codes_;
  cl::Buffer<cl_uchar> bone_;
};

}  // namespace

std::unique_ptr<Program> make_published_direct(const cl::DeviceInfo& device, const BenchSetup& setup, bool count) {
  return std::make_unique<PublishedDirect>(device, setup, count);
}

}  // namespace bench
}  // namespace reamsim
