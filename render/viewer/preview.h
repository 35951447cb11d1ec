// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What `reamsim preview` shows.
struct PreviewRequest {
  Scenario scenario;      ///< bone, tool and motion
  std::string text;       ///< the scenario as its user wrote it, which the page changes
  std::string file_name;  ///< under which the page saves it
  std::string source;     ///< what the page is titled with: the name of the scenario or of the bone's file
};

/// The page: HTML without network, at most 15 MB. Problems of segmentation, frame, tool and motion that stop a run are
/// shown in the page, because it is there to mend them; `report` gets warnings. Throws InputError when the bone itself
/// cannot be read.
std::string preview_page(const PreviewRequest& request, Diagnostics& report);

/// Whether a file is such a page.
bool is_preview_page(const std::string& path);

/// What the page shows in its slices, on a lattice along the axes of B.
struct PreviewVolume {
  ct::Lattice lattice;
  std::string unit;          ///< of `value`: "HU" or "g/cm³"
  std::vector<float> value;  ///< radiodensity, or density with 0 in the air
  std::vector<float> bone;   ///< above 0 in the bone, 0 at its surface, within −1…1; empty without a segmentation
};

/// A CT scan and its segmentation, with at most `most_voxels` voxels. Larger scans are averaged, first along the axes
/// with the smallest spacing.
PreviewVolume preview_of_scan(const SegmentedScan& scan, std::int64_t most_voxels);

/// A voxmap, averaged over cubes of n³ voxels, with the least n for at most `most_voxels` cubes.
PreviewVolume preview_of_voxmap(const BoneView& bone, std::int64_t most_voxels);

/// The volume for the page: `dims`, `origin_mm` (centre of the first voxel), `spacing_mm`, `unit`, and zlib in base 64:
/// `values`, a byte v per voxel for low + step·v, and `bone`, a byte per voxel, 128 at the surface and more inside, or
/// null. Bytes are differences to the previous voxel, which compress better.
nlohmann::ordered_json volume_json(const PreviewVolume& volume);

}  // namespace reamsim
