// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/scenario/choices.h"
#include "sim/scenario/shipped.h"

namespace CLI {
class Option;
}

namespace reamsim {

/// The extension of a file name in small letters, with its dot: ".yaml"; "" without one.
std::string lower_extension(const std::string& path);

/// The source of a bone by the name of its file: vdb, mesh or ct. VTK's surfaces count as meshes, which gives a helpful
/// error message.
BoneSource source_by_name(const std::string& path);

/// Lets an option of the command line take names as shipped_or_path().
void take_shipped_names(CLI::Option& option, ShippedKind kind);

}  // namespace reamsim
