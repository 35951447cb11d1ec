// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace reamsim {

/// The JSON of a results folder. Discarded (is_discarded()) where the text is damaged or has more levels than results
/// have: those who read it recurse.
nlohmann::ordered_json parse_result_json(const std::string& text);

}  // namespace reamsim
