// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>

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

class PublishedOctree final : public PublishedProgram {
 public:
  PublishedOctree(const cl::DeviceInfo& info, const BenchSetup& setup)
      : PublishedProgram("octree", info, setup, embedded::kernel_published_octree, 1),
        detect_(program_, "published_octree"),
        reduce_(program_, "published_reduce"),
        voxels_(static_cast<std::size_t>(setup.voxmap->grid.size())),
        hu_(device_, voxels_, "the voxmap's HU"),
        collided_(device_, voxels_, "the voxmap's collision flags"),
        shell_(cl::upload(device_, points_of(setup.tool->shell), "the point shell")),
        steps_(cl::upload(device_, descent_steps(setup.voxmap->grid.dims.x()), "the look-up table")),
        forces_(device_, 4 * points_, "the points' forces"),
        partial_(device_, 4 * kPartialSums, "the partial sums"),
        sum_(device_, 4, "the sum") {
    upload_bone();
    detect_.set_from(0, shell_, static_cast<cl_uint>(points_), frame_, hu_, collided_, steps_,
                     static_cast<cl_int>(steps_.count() / 8), forces_);
    reduce_.set_local(3, kPublishedGroup * 4 * sizeof(float));
    set_restoring(shell_, hu_, collided_);
  }

  [[nodiscard]] StructureBytes bytes() const override { return {hu_.bytes() + collided_.bytes(), shell_.bytes()}; }

 private:
  void restore_all() override { collided_.clear(device_, voxels_); }

  void upload_bone() {
    // A layer at a time, so that the host needs no second copy of the bone.
    const DensityMapping mapping;
    std::array<float, 256> hu_of_grade{};
    for (int grade = 0; grade < 256; ++grade) {
      const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
      hu_of_grade[static_cast<std::size_t>(grade)] =
          grade == 0 ? kAirHu : static_cast<float>(mapping.hu_from_density(density));
    }
    const auto grades = dense_remaining_grades(*setup_.voxmap);
    constexpr std::size_t kChunk = std::size_t{1} << 22;
    std::vector<float> chunk;
    for (std::size_t first = 0; first < voxels_; first += kChunk) {
      chunk.clear();
      for (std::size_t e = first; e < std::min(voxels_, first + kChunk); ++e) chunk.push_back(hu_of_grade[grades[e]]);
      hu_.write(device_, chunk.data(), chunk.size(), first);
    }
    restore_all();
  }

  cl::Event reduce(const cl::Buffer<float>& in, std::size_t count, const cl::Buffer<float>& out, std::size_t groups) {
    reduce_.set_from(0, in, static_cast<cl_uint>(count), out);
    return reduce_.launch(device_, groups * kPublishedGroup, kPublishedGroup);
  }

  void run_one(const Substep& frame, bool /*use_voi: there is none*/, BatchSample& sample) override {
    const Stopwatch stopwatch;
    const bool overlap = boxes_overlap(setup_.tool_box, setup_.bone_box, frame.pose.bone_from_tool().inverse());
    sample.broad_s += stopwatch.seconds();
    if (!overlap) {
      sample.total_s += stopwatch.seconds();
      return;
    }
    const Stopwatch upload;
    const PublishedFrame args = published_frame(frame, std::nullopt, *setup_.tool, setup_.voxmap->grid);
    frame_.write(device_, &args, 1, 0, false);
    sample.upload_s += upload.seconds();
    std::vector<cl::Event> events;
    events.push_back(detect_.launch(device_, points_, kPublishedGroup));
    events.push_back(reduce(forces_, points_, partial_, kPartialSums));
    events.push_back(reduce(partial_, kPartialSums, sum_, 1));
    float result[4];
    sum_.read(device_, result, 4);
    sample.total_s += stopwatch.seconds();
    for (const double s : cl::take_seconds(events)) sample.kernel_s += s;
    sample.contacts += static_cast<std::int64_t>(result[3]);
    sample.force += Vec3(result[0], result[1], result[2]);
  }

  cl::Kernel detect_, reduce_;
  std::size_t voxels_;
  cl::Buffer<float> hu_;
  cl::Buffer<cl_uchar> collided_;
  cl::Buffer<float> shell_;
  cl::Buffer<cl_uint> steps_;
  cl::Buffer<float> forces_, partial_, sum_;
};

}  // namespace

std::unique_ptr<Program> make_published_octree(const cl::DeviceInfo& device, const BenchSetup& setup) {
  return std::make_unique<PublishedOctree>(device, setup);
}

}  // namespace bench
}  // namespace reamsim
