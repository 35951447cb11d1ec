// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

/// @cond
NLOHMANN_JSON_NAMESPACE_BEGIN
/// null for no value.
template <class Value>
struct adl_serializer<std::optional<Value>> {
  template <class Json>
  static void to_json(Json& out, const std::optional<Value>& value) {
    out = value ? Json(*value) : Json();
  }
};
NLOHMANN_JSON_NAMESPACE_END
/// @endcond

/// Defines to_json() of a structure whose members have the names of their keys, in the order of the file.
#define REAMSIM_TO_JSON(Type, ...)                                                            \
  inline void to_json(nlohmann::ordered_json& nlohmann_json_j, const Type& nlohmann_json_t) { \
    NLOHMANN_JSON_EXPAND(NLOHMANN_JSON_PASTE(NLOHMANN_JSON_TO, __VA_ARGS__))                  \
  }

namespace reamsim {

/// The JSON of a results folder. Discarded (is_discarded()) where the text is damaged or has more levels than results
/// have: those who read it recurse.
inline nlohmann::ordered_json parse_result_json(const std::string& text) {
  using Json = nlohmann::ordered_json;
  constexpr int kMostLevels = 64;
  bool too_deep = false;
  const auto visit = [&](int depth, Json::parse_event_t, Json&) {
    too_deep = too_deep || depth > kMostLevels;
    return !too_deep;
  };
  Json json = Json::parse(text, visit, /*allow_exceptions=*/false);
  return too_deep ? Json(Json::value_t::discarded) : json;
}

/// Calls visit(key, number) for every number below `json`, whose own key is `key`. Below it names follow after a dot,
/// and places in a list between `before` and `after`: "passes[0].frames".
template <class Visit>
void for_each_number(const nlohmann::ordered_json& json, const std::string& key, const char* before, const char* after,
                     const Visit& visit) {
  if (json.is_number()) visit(key, json.get<double>());
  if (!json.is_structured()) return;
  for (const auto& [name, value] : json.items()) {
    const std::string dotted = key.empty() ? name : key + "." + name;
    for_each_number(value, json.is_array() ? key + before + name + after : dotted, before, after, visit);
  }
}

}  // namespace reamsim
