// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// Where a node was written: a line and column of the scenario file (from 1; columns count characters), or a `--set`.
struct YamlMark {
  int line = 0;
  int column = 0;
  std::shared_ptr<const std::string> override_text;  ///< "--set key=value" where the node came from there

  [[nodiscard]] SourceLocation in(const std::string& file) const;
};

struct YamlNode;
using YamlNodePtr = std::shared_ptr<const YamlNode>;

/// One "key: value" of a map.
struct YamlEntry {
  std::string key;
  YamlMark mark;  ///< of the key
  YamlNodePtr value;
};

/// A node of a YAML document, with aliases and merge keys ("<<") already resolved. Aliased nodes are shared.
struct YamlNode {
  enum class Kind { null, scalar, sequence, map };

  Kind kind = Kind::null;
  YamlMark mark{};
  std::string text{};   ///< scalar: its value
  bool quoted = false;  ///< scalar: in quotes or a block, hence text whatever it looks like
  std::vector<YamlNodePtr> items{};
  std::vector<YamlEntry> entries{};  ///< keys are unique
  int height = 0;                    ///< levels below this node

  /// The entry of a key, or nullptr.
  [[nodiscard]] const YamlEntry* find(std::string_view key) const;
  /// The node of a path below this one, "motion.passes.0.tool.mesh", or nullptr.
  [[nodiscard]] const YamlNode* at(std::string_view path) const;
};

/// Limits of a document; a scenario is far below them.
struct YamlLimits {
  static constexpr std::size_t kMaxBytes = 4u << 20;
  static constexpr std::size_t kMaxNodes = 500'000;
  static constexpr int kMaxDepth = 32;
};

/// Parses one YAML document; an empty one gives a null node. `file` is for messages only. Throws InputError with line
/// and column, also for duplicate keys, recursive aliases, tags, and more than one document.
YamlNodePtr parse_yaml(std::string_view text, const std::string& file);

}  // namespace reamsim
