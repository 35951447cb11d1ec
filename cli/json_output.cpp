// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/json_output.h"

#include <cstdio>

#include "sim/base/error.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Mistake& mistake) {
  Json out;
  if (!mistake.where.file.empty()) out["file"] = mistake.where.file;
  if (mistake.where.line > 0) out["line"] = mistake.where.line;
  if (mistake.where.column > 0) out["column"] = mistake.where.column;
  if (!mistake.key.empty()) out["key"] = mistake.key;
  out["found"] = mistake.found;
  if (!mistake.expected.empty()) out["expected"] = mistake.expected;
  return out;
}

Json failure() {
  return {{"program", "reamsim " REAMSIM_VERSION}, {"ok", false}, {"mistakes", Json::array()}};
}

}  // namespace

void print_json(const Json& json) {
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void run_with_json(const Console& console, const std::function<void(const Console&)>& work) {
  Console silent = console;
  silent.quiet = true;
  try {
    work(silent);
  } catch (const InputError& error) {
    Json out = failure();
    for (const Mistake& mistake : error.mistakes()) out["mistakes"].push_back(json_of(mistake));
    print_json(out);
    throw;
  } catch (const std::exception& error) {
    Json out = failure();
    out["error"] = message_of(error);
    print_json(out);
    throw;
  }
}

}  // namespace reamsim
