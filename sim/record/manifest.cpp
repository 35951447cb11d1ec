// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/manifest.h"

#include "sim/base/file.h"
#include "sim/record/result_json.h"

namespace reamsim {

using Json = nlohmann::ordered_json;

std::optional<Manifest> read_manifest(const std::string& dir) {
  constexpr std::size_t kMostBytes = 64'000'000;  // a million pictures
  const std::string text = read_file_start(dir + "/" + kManifestName, kMostBytes);
  const Json json = parse_result_json(text);
  if (!json.is_object() || !json.contains("kind") || !json["kind"].is_string()) return std::nullopt;
  if (!json.contains("files") || !json["files"].is_array()) return std::nullopt;
  if (json.contains("complete") && !json["complete"].is_boolean()) return std::nullopt;
  Manifest out{.kind = json["kind"], .files = {}, .complete = json.value("complete", true)};
  for (const Json& file : json["files"]) {
    if (!file.is_string()) return std::nullopt;
    out.files.insert(file.get<std::string>());
  }
  return out;
}

void write_manifest(const std::string& dir, const Manifest& manifest, bool durable) {
  Json json;
  json["program"] = "reamsim " REAMSIM_VERSION;
  json["kind"] = manifest.kind;
  json["complete"] = manifest.complete;
  json["files"] = manifest.files;
  const auto write = durable ? replace_file : write_file;
  write(dir + "/" + kManifestName, json.dump(2) + "\n");
}

}  // namespace reamsim
