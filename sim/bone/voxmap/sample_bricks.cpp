#include "sim/bone/voxmap/sample_bricks.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace reamsim {

namespace {

/// Rows of bricks that are sampled before they are stored: enough for many threads, and few beside the bone's memory.
constexpr int kRowsAtOnce = 256;

/// A brick with bone, and its place along x.
struct SampledBrick {
  int x;
  GradeBricks::Brick grades;
};

std::vector<SampledBrick> sample_row(const Vec3i& first, int count, const BrickSampler& sample) {
  std::vector<SampledBrick> out;
  SampledBrick next{0, {}};
  for (; next.x < count; ++next.x) {
    if (!sample({next.x, first.y(), first.z()}, next.grades)) continue;
    out.push_back(next);
    next.grades.fill(0);
  }
  return out;
}

}  // namespace

GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample) {
  GradeBricks out(dims);
  const Vec3i bricks = out.brick_dims();
  const auto coord = [&bricks](std::int64_t row) {
    return Vec3i(0, static_cast<int>(row % bricks.y()), static_cast<int>(row / bricks.y()));
  };
  const std::int64_t rows = std::int64_t{bricks.y()} * bricks.z();
  std::vector<std::vector<SampledBrick>> sampled(kRowsAtOnce);
  for (std::int64_t first = 0; first < rows; first += kRowsAtOnce) {
    const std::int64_t count = std::min<std::int64_t>(kRowsAtOnce, rows - first);
    parallel_items(static_cast<std::size_t>(count), [&](std::size_t i) {
      sampled[i] = sample_row(coord(first + static_cast<std::int64_t>(i)), bricks.x(), sample);
    });
    // Stored in the lattice's order by one thread, so that the slots are the same in every run.
    for (std::int64_t i = 0; i < count; ++i) {
      for (const SampledBrick& brick : sampled[static_cast<std::size_t>(i)]) {
        out.put(coord(first + i) + Vec3i(brick.x, 0, 0), brick.grades);
      }
    }
  }
  return out;
}

}  // namespace reamsim
