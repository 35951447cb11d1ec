// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/input_kind.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

namespace reamsim {

std::string lower_extension(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool is_scenario_name(const std::string& path) {
  const std::string kind = lower_extension(path);
  return kind == ".yaml" || kind == ".yml";
}

BoneSource source_by_name(const std::string& path) {
  constexpr std::array kMeshes{".stl", ".obj", ".ply", ".vtp", ".vtk"};
  const std::string kind = lower_extension(path);
  if (kind == ".vdb") return BoneSource::vdb;
  return std::ranges::find(kMeshes, kind) != kMeshes.end() ? BoneSource::mesh : BoneSource::ct;
}

}  // namespace reamsim
