// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/snapshot.h"

#include <fmt/core.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/vdb/grids.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Sets every voxel of a brick, whole ones included, so that a leaf holds the complete brick.
void put_brick(openvdb::FloatGrid& grid, const Vec3i& brick_coord, const FillBricks& fill) {
  const FillBricks::Brick* brick = fill.brick(brick_coord);
  const openvdb::Coord corner(8 * brick_coord.x(), 8 * brick_coord.y(), 8 * brick_coord.z());
  auto* leaf = grid.tree().touchLeaf(corner);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const std::uint16_t units = brick == nullptr
                                        ? FillBricks::kWhole
                                        : (*brick)[static_cast<std::size_t>(BrickLattice::offset_of({x, y, z}))];
        leaf->setValueOn(corner.offsetBy(x, y, z), static_cast<float>(units) / FillBricks::kWhole);
      }
    }
  }
}

}  // namespace

std::string tool_path(const std::string& dir, int pass) {
  return dir + "/snapshots/tool" + (pass == 1 ? "" : "_" + std::to_string(pass)) + ".stl";
}

std::string snapshot_path(const std::string& dir, std::int64_t frame) {
  return fmt::format("{}/snapshots/{:06}.vdb", dir, frame);
}

void remove_snapshots_after(const std::string& dir, std::int64_t frame) {
  std::error_code ignored;
  for (const std::int64_t later : snapshot_frames(dir)) {
    if (later > frame) fs::remove(snapshot_path(dir, later), ignored);
  }
}

void write_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill) {
  const std::string path = snapshot_path(dir, frame);
  openvdb::initialize();
  auto grid = make_float_grid(1.0F);
  grid->setName("fill");
  for (const Vec3i& brick : fill.take_changed()) put_brick(*grid, brick, fill);
  std::error_code ignored;  // writing reports it
  fs::create_directories(fs::path(path).parent_path(), ignored);
  write_vdb_file(path, {[&grid] { return grid; }}, {});
}

std::vector<std::int64_t> snapshot_frames(const std::string& dir) {
  std::vector<std::int64_t> frames;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir + "/snapshots", error)) {
    const std::string stem = entry.path().stem().string();
    const bool number = is_whole_number(stem) && stem.size() < 19;
    if (entry.path().extension() == ".vdb" && number) frames.push_back(std::stoll(stem));
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

void apply_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill) {
  const std::string path = snapshot_path(dir, frame);
  const openvdb::FloatGrid::Ptr grid = read_vdb_grid(path, "fill", VdbOrigin::kReamsim);
  const Vec3i limit = 8 * fill.brick_dims();
  for (auto value = grid->cbeginValueOn(); value; ++value) {
    const openvdb::Coord c = value.getCoord();
    const Vec3i voxel(c.x(), c.y(), c.z());
    if ((voxel.array() < 0).any() || (voxel.array() >= limit.array()).any()) {
      throw InputError({path, 0, 0}, "", "holds a brick outside the bone's lattice", "run the scenario again");
    }
    const float units = std::clamp(value.getValue(), 0.0F, 1.0F) * FillBricks::kWhole;
    fill.set(voxel, static_cast<std::uint16_t>(std::lround(units)));
  }
}

}  // namespace reamsim
