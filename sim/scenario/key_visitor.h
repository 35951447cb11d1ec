// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// The description of one key, for parser, writer, schema and documentation.
struct KeyInfo {
  std::string_view name;
  std::string_view doc{};
  bool required = false;  ///< where it applies
  Range range{};
  std::vector<std::string_view> choices{};
  TextKind text = TextKind::word;
  bool number_too = false;        ///< text that may look like a number
  bool nonzero = false;           ///< a direction: not all components zero
  bool point = false;             ///< a point in space, or a list of them, which a file of markups may give too
  When when{};                    ///< empty: always
  std::string_view unless{};      ///< does not apply where this sibling is given
  int least_points = 1;           ///< of a list of points
  std::string_view default_by{};  ///< the choice above that can change the default (KeyVisitor::defaults)
};

/// "exactly one of these" or "at most one of these", for sibling keys.
struct KeyGroup {
  std::vector<std::string_view> names;
  bool one_needed = true;
};

/// Visits the keys of a scenario in the order of the documentation. describe_scenario() calls it; implementations read,
/// write or list keys.
class KeyVisitor {
 public:
  virtual ~KeyVisitor() = default;

  virtual void number(const KeyInfo& info, double& value) = 0;
  virtual void integer(const KeyInfo& info, int& value) = 0;
  virtual void flag(const KeyInfo& info, bool& value) = 0;
  /// Text: one of `info.choices`, a path or a free word. "": not given.
  virtual void text(const KeyInfo& info, std::string& value) = 0;
  virtual void choices(const KeyInfo& info, std::vector<std::string>& values) = 0;
  /// One of the names of an enum.
  template <class E>
  void choice(const KeyInfo& info, E& value) {
    std::string name = name_of(value);
    text(with_choices<E>(info), name);
    value = *from_name<E>(name);
  }
  /// One or more of the names of an enum, each at most once.
  template <class E>
  void choice_list(const KeyInfo& info, std::vector<E>& values) {
    std::vector<std::string> names = names_of(values);
    choices(with_choices<E>(info), names);
    values.clear();
    for (const std::string& name : names) values.push_back(*from_name<E>(name));
  }
  /// One name or whole number, or a list of them.
  virtual void names(const KeyInfo& info, std::vector<std::string>& values) = 0;
  virtual void vector(const KeyInfo& info, Vec3& value) = 0;
  virtual void optional_vector(const KeyInfo& info, std::optional<Vec3>& value) = 0;
  /// A list of vectors; empty: not given.
  virtual void points(const KeyInfo& info, std::vector<Vec3>& values) = 0;
  virtual void optional_quaternion(const KeyInfo& info, std::optional<Quat>& value) = 0;
  virtual void group(const KeyGroup& group) = 0;
  /// `change` sets those defaults of the keys below this call that depend on choices above it. Only readers call it.
  virtual void defaults(const std::function<void()>& /*change*/) {}

  /// A section that always has a value.
  template <class S>
  void section(const KeyInfo& info, S& value, void (*describe)(KeyVisitor&, S&)) {
    if (!begin_section(info)) return;
    describe(*this, value);
    end_section();
  }

  /// A section that may be absent.
  template <class S>
  void optional_section(const KeyInfo& info, std::optional<S>& value, void (*describe)(KeyVisitor&, S&)) {
    if (!begin_optional_section(info, value.has_value())) return;
    S filled = value.value_or(S{});
    describe(*this, filled);
    end_section();
    value = filled;
  }

  /// A list of sections.
  template <class S>
  void list(const KeyInfo& info, std::vector<S>& values, void (*describe)(KeyVisitor&, S&)) {
    values.resize(begin_list(info, values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      begin_item(i);
      describe(*this, values[i]);
      end_section();
    }
    end_list();
  }

 protected:
  /// False: the section does not apply; its keys are skipped.
  virtual bool begin_section(const KeyInfo& info) = 0;
  virtual bool begin_optional_section(const KeyInfo& info, bool has_value) = 0;
  virtual void end_section() = 0;
  /// The number of items to visit, given how many the value has.
  virtual std::size_t begin_list(const KeyInfo& info, std::size_t size) = 0;
  virtual void begin_item(std::size_t index) = 0;
  virtual void end_list() = 0;

 private:
  template <class E>
  static KeyInfo with_choices(KeyInfo info) {
    for (const std::string_view name : kChoiceNames<E>) {
      if (!name.empty()) info.choices.push_back(name);
    }
    return info;
  }
};

/// The description of all keys: path, type, range or choices, whether required, and meaning. Units are part of the
/// names; defaults are those of the structs.
void describe_scenario(KeyVisitor& v, Scenario& scenario);

}  // namespace reamsim
