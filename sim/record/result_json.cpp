// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/result_json.h"

namespace reamsim {

using Json = nlohmann::ordered_json;

Json parse_result_json(const std::string& text) {
  constexpr int kMostLevels = 64;
  bool too_deep = false;
  const auto visit = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kMostLevels;
    return !too_deep;
  };
  Json json = Json::parse(text, visit, /*allow_exceptions=*/false);
  return too_deep ? Json(Json::value_t::discarded) : json;
}

}  // namespace reamsim
