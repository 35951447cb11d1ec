// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdlib>
#include <string>
#include <vector>

namespace reamsim::test {

/// A file of the public CT and meshes, in the folder that REAMSIM_DATA names. Tests that need it are skipped where it
/// does not exist.
inline std::string data_file(const std::string& name) {
  const char* const folder = std::getenv("REAMSIM_DATA");
  return std::string(folder != nullptr ? folder : "") + "/" + name;
}

/// Arguments for trajectories/ct_shoulder.yaml: glenoid and acromion alone, unfiltered, without pictures, which load in
/// a quarter of the time. Thin walls of the blade, which the filter keeps, are outside.
inline const std::vector<std::string> kQuickShoulder{"--set", "bone.ct.crop_min_mm=[95, 150, -485]",
                                                     "--set", "bone.ct.crop_max_mm=[150, 205, -404]",
                                                     "--set", "bone.ct.filter=none",
                                                     "--set", "bone.ct.fill_holes=false",
                                                     "--set", "render.enabled=false"};

}  // namespace reamsim::test
