#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr std::size_t kLongestKey = 60;  // beyond it no key is meant, and edit distances get slow

/// Parts that unit suffixes are made of, ours and those that people write by mistake.
constexpr std::array<std::string_view, 44> kUnitWords{
    "mm",  "cm", "m",   "um",  "nm",     "km",      "in",     "inch", "s",      "ms",      "us",
    "min", "h",  "sec", "rad", "deg",    "degrees", "rpm",    "rps",  "hz",     "khz",     "mhz",
    "n",   "kn", "mn",  "nmm", "newton", "hu",      "gray",   "g",    "kg",     "mg",      "cm3",
    "mm3", "m3", "j",   "mj",  "kj",     "px",      "pixels", "per",  "voxels", "seconds", "mpa"};

std::string display(const KeyNode& key) {
  const std::string_view unit = unit_of(key.info.name);
  return std::string(key.info.name) + (unit.empty() ? "" : " (" + std::string(unit) + ")");
}

/// Whether all parts of `suffix` ("_mm_min") are words of units.
bool is_unit_suffix(std::string_view suffix) {
  while (!suffix.empty()) {
    if (suffix[0] != '_') return false;
    suffix.remove_prefix(1);
    const std::string_view word = suffix.substr(0, suffix.find('_'));
    if (std::ranges::find(kUnitWords, word) == kUnitWords.end()) return false;
    suffix.remove_prefix(word.size());
  }
  return true;
}

/// Same name, other unit or none: "feed_mm_min" and "feed" for "feed_mm_s".
bool differs_in_unit_only(const KeyNode& key, std::string_view unknown) {
  const std::string_view stem = without_unit(key.info.name);
  return stem.size() < key.info.name.size() && unknown.starts_with(stem) && is_unit_suffix(unknown.substr(stem.size()));
}

/// Levenshtein's edit distance, without regard to case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

const KeyNode* nearest(const KeyNode& section, std::string_view unknown) {
  const KeyNode* best = nullptr;
  std::size_t least = std::max<std::size_t>(1, unknown.size() / 3) + 1;
  for (const auto& key : section.children) {
    const std::size_t distance = edit_distance(key.info.name, unknown);
    if (distance >= least) continue;
    least = distance;
    best = &key;
  }
  return best;
}

/// The first key of that name anywhere in the tree.
const KeyNode* elsewhere(const KeyNode& section, std::string_view name) {
  for (const auto& key : section.children) {
    if (key.info.name == name) return &key;
    if (const KeyNode* found = elsewhere(key, name)) return found;
  }
  return nullptr;
}

/// What to say of an unknown key in `section`: "did you mean feed_mm_s (mm/s)?", or the keys there are.
std::string suggest_key(const KeyNode& section, const std::string& unknown) {
  if (unknown.size() <= kLongestKey) {
    for (const auto& key : section.children) {
      if (differs_in_unit_only(key, unknown)) return "did you mean " + display(key) + "?";
    }
    if (const KeyNode* key = elsewhere(key_tree(), unknown)) return "did you mean " + key->path + "?";
    if (const KeyNode* key = nearest(section, unknown)) return "did you mean " + display(*key) + "?";
  }
  std::vector<std::string_view> names;
  for (const auto& key : section.children) names.push_back(key.info.name);
  return "expected one of " + join_or(names);
}

class UnknownKeys {
 public:
  UnknownKeys(const std::string& file, MistakeList& mistakes) : file_(file), mistakes_(mistakes) {}

  void find(const YamlNode& node, const KeyNode& section, const std::string& path) const {
    for (const auto& entry : node.entries) {
      const std::string entry_path = path + (path.empty() ? "" : ".") + shown_key(entry.key);
      const KeyNode* key = section.find(entry.key);
      if (key == nullptr) {
        mistakes_.add(InputError(entry.mark.in(file_), entry_path, "unknown key", suggest_key(section, entry.key)));
        continue;
      }
      if (key->kind == KeyNode::Kind::section) find(*entry.value, *key, entry_path);
      if (key->kind != KeyNode::Kind::list) continue;
      for (std::size_t i = 0; i < entry.value->items.size(); ++i) {
        find(*entry.value->items[i], *key, entry_path + "." + std::to_string(i));
      }
    }
  }

 private:
  const std::string& file_;
  MistakeList& mistakes_;
};

}  // namespace

void reject_unknown_keys(const YamlNode& document, const std::string& file, MistakeList& mistakes) {
  UnknownKeys(file, mistakes).find(document, key_tree(), "");
}

}  // namespace reamsim
