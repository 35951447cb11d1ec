// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Writes the bricks that changed since the last snapshot to DIR/snapshots/NNNNNN.vdb: one FloatGrid `fill` (0…1) whose
/// leaves are those bricks, in voxel index space. The first snapshot (frame 0) holds every brick that is not whole.
/// Throws RunError when the file cannot be written.
void write_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill);

/// DIR/snapshots/tool.stl, or tool_N.stl of a later pass; the first one is 1.
std::string tool_path(const std::string& dir, int pass);

/// DIR/snapshots/NNNNNN.vdb
std::string snapshot_path(const std::string& dir, std::int64_t frame);
void remove_snapshots_after(const std::string& dir, std::int64_t frame);

std::vector<std::int64_t> snapshot_frames(const std::string& dir);

/// Sets the bricks of one snapshot in `fill`. Throws InputError when the file is missing, truncated, damaged (the
/// checksum is verified first) or of another bone.
void apply_snapshot(const std::string& dir, std::int64_t frame, FillBricks& fill);

}  // namespace reamsim
