// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/input_kind.h"

#include <CLI/CLI.hpp>
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

BoneSource source_by_name(const std::string& path) {
  constexpr std::array kMeshes{".stl", ".obj", ".ply", ".vtp", ".vtk"};
  const std::string kind = lower_extension(path);
  if (kind == ".vdb") return BoneSource::vdb;
  return std::ranges::find(kMeshes, kind) != kMeshes.end() ? BoneSource::mesh : BoneSource::ct;
}

void take_shipped_names(CLI::Option& option, ShippedKind kind) {
  option.transform([kind](const std::string& argument) { return shipped_or_path(argument, kind); }, "");
}

}  // namespace reamsim
