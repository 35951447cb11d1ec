// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/bone_cache.h"

#include <fmt/core.h>
#include <filesystem>

#include "sim/scenario/parse.h"
#include "sim/scene/load_bone.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Length and time of modification of a file, or of each file of a folder.
std::string stamp(const std::string& path) {
  std::error_code error;
  const auto of_file = [&](const fs::path& file) {
    const auto bytes = fs::file_size(file, error);
    return fmt::format("{} {} {}\n", file.string(), bytes, fs::last_write_time(file, error).time_since_epoch().count());
  };
  if (!fs::is_directory(path, error)) return of_file(path);
  std::string out;
  for (fs::recursive_directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
    if (at->is_regular_file(error)) out += of_file(at->path());
  }
  return out;
}

std::string key_of(const BoneSettings& settings) {
  Scenario scenario;  // whose other sections are the defaults
  scenario.bone = settings;
  std::string key = to_yaml(scenario);
  for (const auto& [role, path] : input_files(scenario)) {
    if (!path.empty()) key += stamp(path);
  }
  return key;
}

/// Whether the voxels of the bone, and what is said of them, do not depend on its glenoid frame: those of a CT do where
/// the humerus is cut off, or no seed is given.
bool is_apart_from_anatomy(const BoneSettings& settings) {
  return settings.source == BoneSource::ct && settings.ct.separate == Separate::none && settings.ct.seed_mm &&
         !settings.pilot_hole;
}

void append(const Diagnostics& from, Diagnostics& to) {
  to.notes.insert(to.notes.end(), from.notes.begin(), from.notes.end());
  to.warnings.insert(to.warnings.end(), from.warnings.begin(), from.warnings.end());
  to.listings.insert(to.listings.end(), from.listings.begin(), from.listings.end());
}

}  // namespace

Bone BoneCache::load(const BoneSettings& settings, Diagnostics& report) {
  const bool shared = is_apart_from_anatomy(settings);
  BoneSettings counted = settings;
  if (shared) counted.glenoid = {};
  if (std::string key = key_of(counted); key != key_) {
    key_.clear();
    bone_ = Bone();  // its memory is needed
    report_ = {};
    try {
      bone_ = shared ? bone_from_source(settings, report_) : load_bone(settings, report_);
    } catch (...) {  // also where memory ends: what was said before may be why
      append(report_, report);
      throw;
    }
    key_ = std::move(key);
    ++loaded_;
  }
  append(report_, report);
  return shared ? with_anatomy(bone_, settings, report) : bone_;
}

}  // namespace reamsim
