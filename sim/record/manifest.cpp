// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/manifest.h"

#include <openssl/evp.h>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "sim/base/error.h"
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

namespace {

namespace fs = std::filesystem;

class Sha256 {
 public:
  Sha256() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }
  void add(const char* data, std::size_t size) { EVP_DigestUpdate(context_.get(), data, size); }
  std::string hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    EVP_DigestFinal_ex(context_.get(), digest, &size);
    std::string out;
    for (unsigned i = 0; i < size; ++i) {
      out += "0123456789abcdef"[digest[i] >> 4];
      out += "0123456789abcdef"[digest[i] & 15];
    }
    return out;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

std::string file_sum(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  Sha256 sum;
  std::vector<char> block(1 << 20);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    sum.add(block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (!in.eof()) throw InputError({path.string(), 0, 0}, "", "cannot be read", "check that it exists and is readable");
  return sum.hex();
}

}  // namespace

std::string sha256_of(const std::string& path) {
  if (!fs::is_directory(path)) return file_sum(path);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path, fs::directory_options::skip_permission_denied)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Sha256 sum;
  for (const auto& file : files) {
    const std::string line = file.lexically_relative(path).string() + " " + file_sum(file) + "\n";
    sum.add(line.data(), line.size());
  }
  return sum.hex();
}

std::string sha256_of_text(const std::string& text) {
  Sha256 sum;
  sum.add(text.data(), text.size());
  return sum.hex();
}

}  // namespace reamsim
