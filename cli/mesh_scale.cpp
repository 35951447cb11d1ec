// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/mesh_scale.h"

#include <fmt/core.h>

#include "cli/input_kind.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/bone/mesh_unit.h"

namespace reamsim {

namespace {

constexpr const char* kGiveScale = "give --scale";

std::string why(const FoundScale& found) {
  const std::string length = fmt::format("the mesh is then {:.0f} mm long", found.length_mm);
  if (found.assumed) return "mm is assumed; " + length + ", and a scapula 100 to 220 mm";
  return "the file is in " + found.unit + "; " + length + ", as a scapula";
}

}  // namespace

MeshScale mesh_scale(const std::string& path, std::optional<double> of_option, const Console& console) {
  if (source_by_name(path) != BoneSource::mesh) {
    if (of_option) throw InputError({path, 0, 0}, "--scale", "only a mesh has a scale", "leave it out");
    return {};
  }
  if (of_option) {
    require_scale(path, *of_option, kGiveScale);
    return {.scale = *of_option, .why = "given by --scale"};
  }
  const FoundScale found = find_scale_of(path, kGiveScale);
  MeshScale out{.scale = found.scale, .why = why(found)};
  const std::string text = fmt::format("bone.mesh.scale: {}: {}", shortest_text(out.scale), out.why);
  if (found.scale == 1 && !found.assumed) {
    console.say(text);
  } else {
    console.warn(text + "; if that is wrong, " + kGiveScale);
  }
  return out;
}

}  // namespace reamsim
