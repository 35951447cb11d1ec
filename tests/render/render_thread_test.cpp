// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "sim/base/error.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

namespace fs = std::filesystem;

/// A run of four snapshots: 0, 20, 40 and 60.
class RenderThreadTest : public ::testing::Test {
 protected:
  void SetUp() override {
    FixtureOptions options;
    options.voxel_mm = 1;
    write_results(dir_.path(), options);
    settings_.width_px = 160;
    settings_.height_px = 120;
    settings_.cameras = {CameraView::oblique, CameraView::glenoid};
    settings_.before_after = false;
    settings_.contact_sheet = false;
    run_.emplace(dir_.path());
    static_cast<void>(run_->inputs());  // the list of snapshots, before a test changes them
  }
  [[nodiscard]] std::string snapshot(int frame) const {
    return dir_.path() + "/snapshots/0000" + std::to_string(frame) + ".vdb";
  }
  /// Of frames of the run, until `count` have come.
  static std::vector<std::int64_t> frames_of(RenderThread& thread, int count) {
    std::vector<std::int64_t> out;
    for (int i = 0; i < count; ++i) {
      const auto frame = thread.next();
      if (!frame) break;
      if (frame->kind == Shot::Kind::frame) out.push_back(frame->frame);
    }
    return out;
  }

  test::TempDir dir_;
  RenderSettings settings_;
  std::optional<RunData> run_;
};

TEST_F(RenderThreadTest, RendersWhileTheRunGoesOn) {
  const std::string later = dir_.path() + "/later.vdb";
  fs::rename(snapshot(40), later);
  RenderThread thread(*run_, {settings_});
  thread.snapshots_written(0);
  EXPECT_EQ(frames_of(thread, 2), (std::vector<std::int64_t>{0, 0}));
  thread.snapshots_written(33);
  EXPECT_EQ(frames_of(thread, 2), (std::vector<std::int64_t>{20, 20}));
  fs::rename(later, snapshot(40));
  thread.snapshots_written(60);
  EXPECT_EQ(frames_of(thread, 4), (std::vector<std::int64_t>{40, 40, 60, 60}));
  for (const char* camera : {"oblique", "glenoid"}) {
    const auto last = thread.next();
    ASSERT_TRUE(last);
    EXPECT_EQ(last->kind, Shot::Kind::after);
    EXPECT_EQ(last->camera.name, camera);
    EXPECT_NEAR(last->deepest_mm, 3, 0.6);
  }
  EXPECT_FALSE(thread.next());
  EXPECT_FALSE(thread.next()) << "nor ever again";
}

TEST_F(RenderThreadTest, EndsWhereTheRunDoes) {
  RenderThread thread(*run_, {settings_});
  thread.snapshots_written(20);
  EXPECT_EQ(frames_of(thread, 1), (std::vector<std::int64_t>{0}));
  // Does not wait for frame 40.
}

TEST_F(RenderThreadTest, RendersAllFramesBeforeADamagedSnapshot) {
  std::ofstream(snapshot(40)) << "damaged";
  RenderThread thread(*run_, {settings_});
  thread.snapshots_written(60);
  EXPECT_EQ(frames_of(thread, 4), (std::vector<std::int64_t>{0, 0, 20, 20}));
  EXPECT_THROW(thread.next(), InputError);
}

RenderedFrame frame_of(std::int64_t frame, int pixels) {
  RenderedFrame out{{Shot::Kind::film, frame}};
  out.image.pixels.resize(static_cast<std::size_t>(pixels));
  return out;
}

TEST(FrameQueueTest, KeepsTheirOrderAndNoMoreThanItHasRoomFor) {
  FrameQueue queue(3 * sizeof(std::uint32_t) * 10);
  std::atomic<int> pushed = 0;
  std::thread giver([&] {
    for (int i = 0; i < 8; ++i) {
      if (queue.push(frame_of(i, 10))) ++pushed;
    }
    queue.finish(nullptr);
  });
  for (int i = 0; i < 8; ++i) {
    const auto frame = queue.pop();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame, i);
    EXPECT_LE(pushed, i + 1 + 3 + 1) << "taken, waiting, and one counted late";
  }
  EXPECT_FALSE(queue.pop());
  giver.join();
}

TEST(FrameQueueTest, HasRoomForOneOfAnySize) {
  FrameQueue queue(1);
  EXPECT_TRUE(queue.push(frame_of(0, 1000)));
  EXPECT_TRUE(queue.pop());
  EXPECT_TRUE(queue.push(frame_of(1, 1000)));
}

TEST(FrameQueueTest, ClosedItTakesNoneAndEndedItSaysWhy) {
  FrameQueue queue(1);
  EXPECT_TRUE(queue.push(frame_of(0, 1000)));
  std::thread giver([&] { EXPECT_FALSE(queue.push(frame_of(1, 1000))) << "there is no room until it is closed"; });
  queue.close();
  giver.join();
  queue.finish(std::make_exception_ptr(RunError("no film in it")));
  EXPECT_TRUE(queue.pop()) << "what was taken before";
  EXPECT_THROW(queue.pop(), RunError);
}

}  // namespace
}  // namespace reamsim
