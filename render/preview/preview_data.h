// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/preview/preview.h"
#include "render/preview/preview_volume.h"
#include "sim/base/error.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// The bone of a preview.
struct PreviewBone {
  SegmentedScan scan;                   ///< of a CT
  std::optional<Bone> bone;             ///< of another source
  std::optional<GlenoidFrame> glenoid;  ///< of the scenario, the phantom or the VDB
  std::optional<LandmarkSettings> landmarks;
  std::vector<Vec3> rim_mm;
  BodySide side = BodySide::unknown;
  std::string frame = "LPS";      ///< of B
  std::vector<Mistake> mistakes;  ///< those that stop a run
};

/// Reads the bone. Mistakes that its preview can mend are collected. Throws InputError when it cannot be read.
PreviewBone load_preview_bone(const Scenario& scenario, Diagnostics& report);

/// The data of the page's script, with a volume of at most `most_voxels` voxels, and the warnings of `report`, which
/// gets those of tool and motion.
nlohmann::ordered_json preview_data(const PreviewRequest& request, const PreviewBone& bone, std::int64_t most_voxels,
                                    Diagnostics& report);

}  // namespace reamsim
