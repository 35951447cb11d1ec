// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/scenario/yaml_tree.h"
#include "sim/study/study.h"

namespace reamsim {

/// Reads the section `sample` of a study. Lists mistakes at their keys.
SampleSettings read_sample(const YamlNode& node, const std::string& file, MistakeList& mistakes);

}  // namespace reamsim
