// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace reamsim {

/// A location in a user's file. Lines and columns count from 1; 0 means unknown.
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column", leaving out what is unknown; empty when nothing is known.
  [[nodiscard]] std::string text() const;

  static auto fields(auto& self) { return std::tie(self.file, self.line, self.column); }
};

struct Mistake {
  SourceLocation where;
  std::string key;
  std::string found;
  std::string expected;

  /// "FILE:LINE:COLUMN: KEY: FOUND; EXPECTED", without what is empty: one line.
  [[nodiscard]] std::string line() const;

  static auto fields(auto& self) { return std::tie(self.where, self.key, self.found, self.expected); }
};

/// The input is wrong (exit status 2). The message has one line per mistake: where, key, what was found, what to do.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : InputError({}, "", message, "") {}

  /// "FILE:LINE:COLUMN: KEY: FOUND; EXPECTED". Pass "" for what does not apply.
  InputError(const SourceLocation& where, const std::string& key, const std::string& found,
             const std::string& expected);

  explicit InputError(std::vector<Mistake> mistakes);

  [[nodiscard]] const std::vector<Mistake>& mistakes() const { return *mistakes_; }

 private:
  std::shared_ptr<const std::vector<Mistake>> mistakes_;  // shared, so that copying an exception cannot throw
};

/// Throws the InputError of a whole file.
[[noreturn]] void refuse_file(const std::string& path, const std::string& found, const std::string& expected);

/// The run failed for a reason that is not the input's (exit status 1): disk full, device lost.
class RunError : public std::runtime_error {
 public:
  explicit RunError(const std::string& message) : std::runtime_error(message) {}
};

/// The user interrupted the run (exit status 130).
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& message = "interrupted") : std::runtime_error(message) {}
};

/// The user interrupted the run, which has a checkpoint to continue from (exit status 75, EX_TEMPFAIL of sysexits.h).
class Suspended : public Interrupted {
 public:
  using Interrupted::Interrupted;
};

/// What an interruption leaves of a run or another command.
struct InterruptedRun {
  bool saved = false;  ///< a checkpoint, from which it can be continued
  std::string message = "interrupted";
};

/// The message of an exception for users, on one line.
std::string message_of(const std::exception& error);

/// Messages of a stage for the user. The caller prints them, so that no engine prints.
struct Diagnostics {
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
  std::vector<std::string> listings;

  void note(std::string text) { notes.push_back(std::move(text)); }
  void warn(std::string text) { warnings.push_back(std::move(text)); }
  /// What a warning refers to and the results must not hold, because it may identify a patient.
  void list(std::string text) { listings.push_back(std::move(text)); }
  /// Adds the messages of another stage, with `before` before each.
  void append(const Diagnostics& from, const std::string& before = "");

  static auto fields(auto& self) { return std::tie(self.notes, self.warnings, self.listings); }
};

/// Collects mistakes, so that all of them are reported at once.
class MistakeList {
 public:
  void add(const InputError& error) {
    mistakes_.insert(mistakes_.end(), error.mistakes().begin(), error.mistakes().end());
  }

  /// Calls `work` and adds the mistakes of an InputError. Returns whether there were none.
  template <class Work>
  bool attempt(const Work& work) {
    try {
      work();
      return true;
    } catch (const InputError& error) {
      add(error);
      return false;
    }
  }

  /// Marks a key that may be wrong because of a mistake elsewhere. Only concerns() considers it.
  void doubt(std::string key) { doubted_.push_back(std::move(key)); }

  [[nodiscard]] bool empty() const { return mistakes_.empty(); }
  [[nodiscard]] const std::vector<Mistake>& mistakes() const { return mistakes_; }
  /// Whether a mistake or a doubted key is `key`, a key above it or a key below it.
  [[nodiscard]] bool concerns(std::string_view key) const;
  /// Whether a mistake concerns a key directly in the section `section`.
  [[nodiscard]] bool has_key_in(std::string_view section) const;

  /// Throws an InputError of all mistakes, by line and column, at most 50. Does nothing where there are none.
  void throw_if_any() const;

 private:
  std::vector<Mistake> mistakes_;
  std::vector<std::string> doubted_;
};

}  // namespace reamsim
