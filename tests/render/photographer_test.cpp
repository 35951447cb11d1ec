#include "render/photographer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "render/pictures/finished_run.h"
#include "sim/base/error.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

namespace fs = std::filesystem;

/// A run of four snapshots: 0, 20, 40 and 60.
class Photographs : public ::testing::Test {
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
    run_.emplace(FinishedRun(dir_.path()).planned());
  }
  [[nodiscard]] std::string snapshot(int frame) const {
    return dir_.path() + "/snapshots/0000" + std::to_string(frame) + ".vdb";
  }
  /// Of frames of the run, until `count` have come.
  static std::vector<std::int64_t> frames_of(Photographer& photographer, int count) {
    std::vector<std::int64_t> out;
    for (int i = 0; i < count; ++i) {
      const auto photo = photographer.next();
      if (!photo) break;
      if (photo->of == Photo::Of::frame) out.push_back(photo->frame);
    }
    return out;
  }

  test::TempDir dir_;
  RenderSettings settings_;
  std::optional<PlannedRun> run_;
  SnapshotFeed snapshots_;
};

TEST_F(Photographs, AreTakenWhileTheRunGoesOn) {
  const std::string later = dir_.path() + "/later.vdb";
  fs::rename(snapshot(40), later);
  Photographer photographer(*run_, settings_, {}, snapshots_);
  snapshots_.reached(0);
  EXPECT_EQ(frames_of(photographer, 2), (std::vector<std::int64_t>{0, 0}));
  snapshots_.reached(33);
  EXPECT_EQ(frames_of(photographer, 2), (std::vector<std::int64_t>{20, 20}));
  fs::rename(later, snapshot(40));
  snapshots_.reached(60);
  EXPECT_EQ(frames_of(photographer, 4), (std::vector<std::int64_t>{40, 40, 60, 60}));
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const auto last = photographer.next();
    ASSERT_TRUE(last);
    EXPECT_EQ(last->of, Photo::Of::after);
    EXPECT_EQ(last->camera, camera);
    EXPECT_NEAR(last->deepest_mm, 3, 0.6);
  }
  EXPECT_FALSE(photographer.next());
  EXPECT_FALSE(photographer.next()) << "nor ever again";
}

TEST_F(Photographs, EndWhereTheRunDoes) {
  {
    Photographer photographer(*run_, settings_, {}, snapshots_);
    snapshots_.reached(20);
    EXPECT_EQ(frames_of(photographer, 1), (std::vector<std::int64_t>{0}));
  }  // does not wait for frame 40
  EXPECT_FALSE(snapshots_.wait_for(0)) << "abandoned";
}

TEST_F(Photographs, OfADamagedSnapshotThereIsNoneButThoseBefore) {
  std::ofstream(snapshot(40)) << "damaged";
  snapshots_.reached(60);
  Photographer photographer(*run_, settings_, {}, snapshots_);
  EXPECT_EQ(frames_of(photographer, 4), (std::vector<std::int64_t>{0, 0, 20, 20}));
  EXPECT_THROW(photographer.next(), InputError);
}

Photo photo_of(std::int64_t frame, int pixels) {
  Photo out{.of = Photo::Of::film, .frame = frame, .image = {}};
  out.image.pixels.resize(static_cast<std::size_t>(pixels));
  return out;
}

TEST(PhotoQueueTest, KeepsTheirOrderAndNoMoreThanItHasRoomFor) {
  PhotoQueue queue(3 * sizeof(std::uint32_t) * 10);
  std::atomic<int> pushed = 0;
  std::thread giver([&] {
    for (int i = 0; i < 8; ++i) {
      if (queue.push(photo_of(i, 10))) ++pushed;
    }
    queue.end(nullptr);
  });
  for (int i = 0; i < 8; ++i) {
    const auto photo = queue.pop();
    ASSERT_TRUE(photo);
    EXPECT_EQ(photo->frame, i);
    EXPECT_LE(pushed, i + 1 + 3 + 1) << "taken, waiting, and one counted late";
  }
  EXPECT_FALSE(queue.pop());
  giver.join();
}

TEST(PhotoQueueTest, HasRoomForOneOfAnySize) {
  PhotoQueue queue(1);
  EXPECT_TRUE(queue.push(photo_of(0, 1000)));
  EXPECT_TRUE(queue.pop());
  EXPECT_TRUE(queue.push(photo_of(1, 1000)));
}

TEST(PhotoQueueTest, ClosedItTakesNoneAndEndedItSaysWhy) {
  PhotoQueue queue(1);
  EXPECT_TRUE(queue.push(photo_of(0, 1000)));
  std::thread giver([&] { EXPECT_FALSE(queue.push(photo_of(1, 1000))) << "there is no room until it is closed"; });
  queue.close();
  giver.join();
  queue.end(std::make_exception_ptr(RunError("no film in it")));
  EXPECT_TRUE(queue.pop()) << "what was taken before";
  EXPECT_THROW(queue.pop(), RunError);
}

}  // namespace
}  // namespace reamsim
