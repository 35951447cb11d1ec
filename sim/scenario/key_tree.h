// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// An interval of allowed numbers, both ends included; for vectors, of each component. A run accepts both ends
/// (tests/robustness/key_ranges.py): a key that must not be 0 has a least value.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool contains(double value) const { return std::isfinite(value) && value >= min && value <= max; }
};
constexpr Range between(double min, double max) {
  return {min, max};
}

/// What a text key may name.
enum class TextKind {
  word,           ///< free text
  input_file,     ///< must exist and be a file
  input_path,     ///< must exist: a file or a folder
  output_folder,  ///< need not exist; may be left empty
};

/// Where a key applies: only with certain values of a choice that stands before it in the same section.
struct When {
  std::string_view choice;
  std::vector<std::string_view> values;
};

/// What a key demands of its value, and where it applies.
struct KeyRules {
  bool required = false;  ///< where it applies
  Range range{};
  TextKind text = TextKind::word;
  bool number_too = false;        ///< text that may look like a number
  bool nonzero = false;           ///< a direction: not all components zero
  bool point = false;             ///< a point in space, or a list of them, which a file of markups may give too
  When when{};                    ///< empty: always
  std::string_view unless{};      ///< does not apply where this sibling is given
  int least_points = 1;           ///< of a list of points
  std::string_view default_by{};  ///< the choice above that can change the default (KeyVisitor::defaults)
};

/// The value of a key, by its type. optional: not given; "" and a list of no points likewise.
using ValuePointer = std::variant<double*, int*, bool*, std::string*, std::vector<std::string>*, std::optional<Vec3>*,
                                  std::vector<Vec3>*, std::optional<Quat>*>;

/// number to quaternion in the order of ValuePointer. text: one of `choices`, a path or a free word; choices: a list of
/// them, each once; names: one name or whole number, or a list of them.
enum class KeyKind { number, integer, flag, text, names, vector, points, quaternion, choices, section, list };

/// The description of one key, for parser, writer, schema and documentation.
struct KeyInfo : KeyRules {
  std::string_view name{};
  std::string_view doc{};
  KeyKind kind = KeyKind::section;
  std::vector<std::string_view> choices{};
};

/// "exactly one of these" or "at most one of these", for sibling keys.
struct KeyGroup {
  std::vector<std::string_view> names;
  bool one_needed = true;
};

/// Range of positions, mm. A position beyond it is a mistake of unit or frame.
constexpr Range kPosition = between(-10000, 10000);
/// Range of the components of a direction, which need not be normalized.
constexpr Range kComponent = between(-1000, 1000);

/// Reads, writes or lists the keys of a scenario, in the order in which describe_scenario() calls it.
class KeyVisitor {
 public:
  virtual ~KeyVisitor() = default;

  /// Calls the visitor for each key of a section or an item of a list.
  template <class S>
  using Describe = std::type_identity_t<void (*)(KeyVisitor&, S&)>;

  /// A key whose kind is that of its value.
  template <class T>
  void key(std::string_view name, T& value, std::string_view doc, const KeyRules& rules = {}) {
    const ValuePointer pointer(&value);
    visit({rules, name, doc, static_cast<KeyKind>(pointer.index())}, pointer);
  }
  void key(std::string_view name, Vec3& value, std::string_view doc, const KeyRules& rules = {}) {
    std::optional<Vec3> given = value;
    key(name, given, doc, rules);
    value = *given;
  }
  /// One of the names of an enum.
  template <class E>
  requires std::is_enum_v<E>
  void key(std::string_view name, E& value, std::string_view doc, const KeyRules& rules = {}) {
    std::string chosen = name_of(value);
    visit({rules, name, doc, KeyKind::text, choices_of<E>()}, &chosen);
    value = *from_name<E>(chosen);
  }
  /// One or more of the names of an enum.
  template <class E>
  requires std::is_enum_v<E>
  void key(std::string_view name, std::vector<E>& values, std::string_view doc, const KeyRules& rules = {}) {
    std::vector<std::string> chosen = names_of(values);
    visit({rules, name, doc, KeyKind::choices, choices_of<E>()}, &chosen);
    values.clear();
    for (const std::string& one : chosen) values.push_back(*from_name<E>(one));
  }
  /// One or more numbers within a range.
  template <class T>
  void key(std::string_view name, T& value, std::string_view doc, const Range& range) {
    key(name, value, doc, KeyRules{.range = range});
  }
  /// A point in space, mm, or with a std::vector several.
  template <class T>
  void point(std::string_view name, T& value, std::string_view doc, KeyRules rules = {}) {
    rules.range = kPosition;
    rules.point = true;
    key(name, value, doc, rules);
  }
  template <class T>
  void direction(std::string_view name, T& value, std::string_view doc, KeyRules rules = {}) {
    rules.range = kComponent;
    rules.nonzero = true;
    key(name, value, doc, rules);
  }
  virtual void group(const KeyGroup& /*group*/) {}
  /// `change` sets those defaults of the keys below this call that depend on choices above it. Only readers call it.
  virtual void defaults(const std::function<void()>& /*change*/) {}

  /// A section that always has a value.
  template <class S>
  void section(std::string_view name, S& value, Describe<S> describe, std::string_view doc = "",
               const KeyRules& rules = {}) {
    if (!begin_section({rules, name, doc})) return;
    describe(*this, value);
    end();
  }

  /// A section that may be absent.
  template <class S>
  void section(std::string_view name, std::optional<S>& value, Describe<S> describe, std::string_view doc = "",
               const KeyRules& rules = {}) {
    if (!begin_optional_section({rules, name, doc}, value.has_value())) return;
    S filled = value.value_or(S{});
    describe(*this, filled);
    end();
    value = filled;
  }

  template <class S>
  void list(std::string_view name, std::vector<S>& values, Describe<S> describe, std::string_view doc = "",
            const KeyRules& rules = {}) {
    values.resize(begin_list({rules, name, doc, KeyKind::list}, values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      begin_item(i);
      describe(*this, values[i]);
      end();
    }
    end();
  }

 protected:
  virtual void visit(const KeyInfo& info, const ValuePointer& value) = 0;
  /// False: the section does not apply; its keys are skipped.
  virtual bool begin_section(const KeyInfo& info) = 0;
  virtual bool begin_optional_section(const KeyInfo& info, bool has_value) = 0;
  /// The number of items to visit, given how many the value has.
  virtual std::size_t begin_list(const KeyInfo& info, std::size_t size) = 0;
  virtual void begin_item(std::size_t index) = 0;
  /// Of a section, a list or an item of one.
  virtual void end() = 0;

 private:
  template <class E>
  static std::vector<std::string_view> choices_of() {
    std::vector<std::string_view> out;
    std::ranges::copy_if(kChoiceNames<E>, std::back_inserter(out), [](std::string_view name) { return !name.empty(); });
    return out;
  }
};

/// The description of all keys. Units are part of their names; defaults are those of the structs.
void describe_scenario(KeyVisitor& v, Scenario& scenario);

/// A key as data: its description by describe_scenario(), its default, and the keys below it.
struct KeyNode {
  KeyInfo info;
  std::string path;          ///< "motion.plunge.feed_mm_s"; "motion.keyframes[].time_s" inside a list
  std::string default_json;  ///< "" = none
  std::vector<KeyNode> children;
  std::vector<KeyGroup> groups;

  [[nodiscard]] const KeyNode* find(std::string_view name) const;
};

/// All keys; the root is a section without a name. Built once.
const KeyNode& key_tree();

/// The unit in a key's name, "mm/s" for "feed_mm_s", or "".
std::string_view unit_of(std::string_view name);

/// A key's name without its unit, "feed" for "feed_mm_s".
std::string_view without_unit(std::string_view name);

/// The values that a key accepts, in words: "a number, 0.01 to 5 (mm)", "one of left, right".
std::string expectation(const KeyInfo& info);

/// A value as YAML on one line, its texts by `text_of`; "": not given.
std::string value_text(const KeyInfo& info, const ValuePointer& value,
                       const std::function<std::string(const std::string&)>& text_of);

/// A range in words: "0.01 to 5", or "".
std::string range_text(const Range& range);

/// "a, b or c".
std::string join_or(const std::vector<std::string_view>& words);

/// The key of a path as `--set` takes it: "motion.passes.0.tool.mesh". Throws InputError at `where` for an unknown one,
/// with the key that was probably meant, and for a section or list.
const KeyNode& find_key(const std::string& path, const SourceLocation& where);

/// What to say of an unknown key in `section`: "did you mean feed_mm_s (mm/s)?", or the keys there are.
std::string suggest_key(const KeyNode& section, const std::string& unknown);

/// The one of `words` that `unknown` probably stands for: "did you mean sobol?", else "expected one of ...".
std::string suggest_word(const std::vector<std::string_view>& words, const std::string& unknown);

}  // namespace reamsim
