// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include "sim/scenario/find_key.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

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
