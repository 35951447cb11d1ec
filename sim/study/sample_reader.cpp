// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/sample_reader.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "sim/scenario/find_key.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr int kMostSamples = 1'000'000;
const std::vector<std::string_view> kSampleKeys{"method", "n", "seed", "of"};
const std::vector<std::string_view> kMethods{"sobol", "latin_hypercube", "monte_carlo", "saltelli"};  // as SampleMethod
const std::vector<std::string_view> kKinds{"normal", "lognormal", "uniform", "tilt_sd_deg", "shift_sd_mm"};  // as Kind

class SampleReader {
 public:
  SampleReader(const std::string& file, MistakeList& mistakes) : file_(file), mistakes_(mistakes) {}

  SampleSettings read(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::map) reject(node, "sample", "expected the keys method, n, seed and of");
    for (const YamlEntry& entry : node.entries) mistakes_.attempt([&] { read_entry(entry); });
    for (const char* needed : {"n", "of"}) {
      if (node.find(needed) != nullptr) continue;
      mistakes_.add(InputError(node.mark.in(file_), std::string("sample.") + needed, "missing", "add it"));
    }
    return std::move(sample_);
  }

 private:
  [[noreturn]] void reject(const YamlNode& node, const std::string& key, const std::string& expected) const {
    throw InputError(node.mark.in(file_), key, "found " + shown(node), expected);
  }

  void read_entry(const YamlEntry& entry) {
    const YamlNode& node = *entry.value;
    if (entry.key == "method") {
      sample_.method_where = node.mark.in(file_);
      sample_.method = static_cast<SampleMethod>(place_of(node, "sample.method", kMethods));
    } else if (entry.key == "n") {
      sample_.n = static_cast<int>(whole(node, "sample.n", 1, kMostSamples));
    } else if (entry.key == "seed") {
      sample_.seed = static_cast<std::uint64_t>(whole(node, "sample.seed", 0, 1'000'000'000'000));
    } else if (entry.key == "of") {
      read_keys(node);
    } else {
      throw InputError(entry.mark.in(file_), "sample." + shown_key(entry.key), "unknown key",
                       suggest_word(kSampleKeys, entry.key));
    }
  }

  [[nodiscard]] std::size_t place_of(const YamlNode& node, const std::string& key,
                                     const std::vector<std::string_view>& words) const {
    const auto found = std::ranges::find(words, node.text);
    if (found == words.end()) reject(node, key, suggest_word(words, node.text));
    return static_cast<std::size_t>(found - words.begin());
  }

  [[nodiscard]] std::int64_t whole(const YamlNode& node, const std::string& key, std::int64_t least,
                                   std::int64_t most) const {
    std::int64_t value = 0;
    const char* const end = node.text.data() + node.text.size();
    const bool read = std::from_chars(node.text.data(), end, value).ptr == end && !node.text.empty();
    if (!read || value < least || value > most) {
      reject(node, key, "expected a whole number, " + std::to_string(least) + " to " + std::to_string(most));
    }
    return value;
  }

  void read_keys(const YamlNode& node) {
    if (node.kind != YamlNode::Kind::map || node.entries.empty()) {
      reject(node, "sample.of",
             "expected keys with distributions, such as \"cutting.normal_ratio: {normal: [0.5, 0.1]}\"");
    }
    for (const YamlEntry& entry : node.entries) mistakes_.attempt([&] { sample_.of.push_back(sampled(entry)); });
  }

  [[nodiscard]] SampledKey sampled(const YamlEntry& entry) const {
    const SourceLocation where = entry.mark.in(file_);
    const KeyNode& key = find_key(entry.key, where);
    const YamlNode& node = *entry.value;
    if (node.kind != YamlNode::Kind::map || node.entries.size() != 1) {
      reject(node, entry.key, "expected one distribution, " + join_or(kKinds));
    }
    const YamlEntry& given = node.entries.front();
    const auto kind = std::ranges::find(kKinds, given.key);
    if (kind == kKinds.end()) {
      throw InputError(given.mark.in(file_), entry.key, "unknown distribution " + shown_text(given.key),
                       suggest_word(kKinds, given.key));
    }
    SampledKey out{.key = entry.key, .distribution = {}, .where = where};
    out.distribution.kind = static_cast<Distribution::Kind>(kind - kKinds.begin());
    check_type(key, out);
    read_parameters(*given.value, entry.key, out.distribution);
    return out;
  }

  static void check_type(const KeyNode& key, const SampledKey& sampled) {
    const auto kind = sampled.distribution.kind;
    const bool of_vector = kind == Distribution::Kind::tilt_sd_deg || kind == Distribution::Kind::shift_sd_mm;
    const bool fits = of_vector ? key.kind == KeyNode::Kind::vector : key.kind == KeyNode::Kind::number;
    if (fits) return;
    throw InputError(
        sampled.where, sampled.key, "the distribution does not fit this key",
        "expected a key of a number for normal, lognormal and uniform, and of a vector for tilt_sd_deg and "
        "shift_sd_mm");
  }

  void read_parameters(const YamlNode& node, const std::string& key, Distribution& out) const {
    const bool one = out.dimensions() > 1;
    std::vector<double> numbers;
    if (one) numbers.push_back(number(node, key));
    for (const YamlNodePtr& item : node.items) numbers.push_back(number(*item, key));
    if (numbers.size() != (one ? 1U : 2U)) {
      reject(node, key, one ? "expected one number" : "expected two numbers, such as [0.5, 0.1]");
    }
    out.a = numbers[0];
    out.b = one ? 0 : numbers[1];
    using Kind = Distribution::Kind;
    if (out.kind == Kind::uniform && !(out.a < out.b)) reject(node, key, "expected the lower end first");
    if (out.kind == Kind::lognormal && !(out.a > 0)) reject(node, key, "expected a median above 0");
    const double spread = one ? out.a : out.b;
    if (out.kind != Kind::uniform && !(spread > 0)) reject(node, key, "expected a standard deviation above 0");
  }

  [[nodiscard]] double number(const YamlNode& node, const std::string& key) const {
    const auto value = node.kind == YamlNode::Kind::scalar ? parse_number(node.text) : std::nullopt;
    if (!value || !std::isfinite(*value)) reject(node, key, "expected a number");
    return *value;
  }

  const std::string& file_;
  MistakeList& mistakes_;
  SampleSettings sample_;
};

}  // namespace

SampleSettings read_sample(const YamlNode& node, const std::string& file, MistakeList& mistakes) {
  return SampleReader(file, mistakes).read(node);
}

}  // namespace reamsim
