// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/scenario/choices.h"

namespace reamsim {

/// The extension of a file name in small letters, with its dot: ".yaml"; "" without one.
std::string lower_extension(const std::string& path);

/// Whether the name is a scenario's, not a bone's.
bool is_scenario_name(const std::string& path);

/// The source of a bone by the name of its file: vdb, mesh or ct. VTK's surfaces count as meshes, which gives a helpful
/// error message.
BoneSource source_by_name(const std::string& path);

}  // namespace reamsim
