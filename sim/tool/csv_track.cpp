// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <deque>
#include <filesystem>
#include <mutex>
#include <utility>

#include "sim/base/error.h"
#include "sim/tool/key_track.h"
#include "sim/tool/pose_csv.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Rows of a file that is held in memory: 10 MB.
constexpr std::size_t kStoredRows = 100'000;
/// Rows that are read at once.
constexpr std::size_t kBlockRows = 1024;
/// Blocks in memory, 2 MB: several threads may follow the motion, each in its own block.
constexpr std::size_t kMaxBlocks = 16;

/// Where a block of rows begins.
struct BlockStart {
  PoseCsv::Place place;
  KeyPose key;  ///< the first one
};

/// Size and time of a file, which differ when it has changed.
struct FileState {
  std::uintmax_t bytes = 0;
  fs::file_time_type written;

  explicit FileState(const std::string& path) {
    std::error_code error;
    bytes = fs::file_size(path, error);
    written = fs::last_write_time(path, error);
  }
  bool operator==(const FileState&) const = default;
};

/// A long recorded CSV: an index of its blocks, and those that were used last.
class CsvTrack final : public KeyTrack {
 public:
  CsvTrack(PoseCsv csv, std::string path, std::optional<Rigid> bone_from_poses, double start_s,
           std::vector<BlockStart> index, double end_s)
      : csv_(std::move(csv)),
        path_(std::move(path)),
        state_(path_),
        bone_from_poses_(std::move(bone_from_poses)),
        start_s_(start_s),
        index_(std::move(index)),
        end_s_(end_s) {}

  [[nodiscard]] double end_s() const override { return end_s_; }

  [[nodiscard]] KeySegment at(double time_s) const override {
    const auto time_of = [](const BlockStart& start) { return start.key.time_s; };
    const auto after = std::ranges::upper_bound(index_, time_s, {}, time_of) - index_.begin();
    const std::shared_ptr<const Keys> keys = block(static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0)));
    const std::size_t i = segment_at(*keys, time_s);
    return {(*keys)[i], (*keys)[i + 1]};
  }

 private:
  /// The rows of a block, and the first one of the next, so that no segment lies between blocks.
  using Keys = std::vector<KeyPose>;
  struct Block {
    std::size_t number;
    std::shared_ptr<const Keys> keys;
  };

  std::shared_ptr<const Keys> block(std::size_t number) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(blocks_, number, &Block::number);
    if (found != blocks_.end()) {
      std::rotate(blocks_.begin(), found, found + 1);
    } else {
      blocks_.push_front({number, std::make_shared<const Keys>(read(number))});
      if (blocks_.size() > kMaxBlocks) blocks_.pop_back();
    }
    return blocks_.front().keys;
  }

  Keys read(std::size_t number) const {
    const BlockStart& start = index_[number];
    TrackIntegrator integrator(bone_from_poses_, start_s_, start.key);
    Keys keys{start.key};
    Diagnostics discarded;
    if (FileState(path_) != state_) fail();
    csv_.seek(start.place);
    KeyPose key;
    if (!csv_.next(key, discarded) || key.time_s - start_s_ != start.key.time_s) fail();
    while (keys.size() <= kBlockRows && csv_.next(key, discarded)) {
      discarded.warnings.clear();
      keys.push_back(integrator.next(key));
    }
    if (keys.size() < 2) fail();
    return keys;
  }

  [[noreturn]] void fail() const {
    throw RunError(path_ + ": the file changed while the program read it; keep it unchanged during a run");
  }

  mutable std::mutex mutex_;
  mutable PoseCsv csv_;
  std::string path_;
  FileState state_;
  std::optional<Rigid> bone_from_poses_;
  double start_s_;
  std::vector<BlockStart> index_;
  double end_s_;
  mutable std::deque<Block> blocks_;  ///< the one used last first
};

}  // namespace

std::unique_ptr<const KeyTrack> open_csv_track(const CsvMotionSettings& settings,
                                               const std::optional<Rigid>& bone_from_poses, Diagnostics& report) {
  PoseCsv csv(settings, report);
  const bool seekable = fs::is_regular_file(settings.path);
  std::optional<TrackIntegrator> integrator;
  double start_s = 0;
  std::size_t rows = 0;
  std::vector<KeyPose> stored;
  std::vector<BlockStart> index;
  KeyPose last;
  scan_pose_csv(csv, settings.path, report, [&](const KeyPose& pose, const PoseCsv::Place& place) {
    if (!integrator) {
      start_s = pose.time_s;
      integrator.emplace(bone_from_poses, start_s);
    }
    last = integrator->next(pose);
    if (rows % kBlockRows == 0) index.push_back({place, last});
    ++rows;
    if (!seekable || rows <= kStoredRows) stored.push_back(last);
    if (seekable && rows == kStoredRows + 1) stored = {};
  });
  note_start(start_s, report);
  if (!stored.empty()) return store_track(std::move(stored));
  // A block of a single row would hold no segment.
  if (rows % kBlockRows == 1) index.pop_back();
  return std::make_unique<const CsvTrack>(std::move(csv), settings.path, bone_from_poses, start_s, std::move(index),
                                          last.time_s);
}

}  // namespace reamsim
