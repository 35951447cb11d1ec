// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/bone_cache.h"

#include <fmt/core.h>
#include <filesystem>

#include "sim/scenario/parse.h"

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

}  // namespace

Bone BoneCache::load(const BoneSettings& settings, Report& report) {
  const bool shared = is_apart_from_anatomy(settings);
  BoneSettings counted = settings;
  if (shared) counted.glenoid = {};
  if (std::string key = key_of(counted); key != key_) {
    key_.clear();
    bone_ = Bone();  // its memory is needed
    report_ = {};
    bone_ = shared ? bone_from_source(settings, report_) : load_bone(settings, report_);
    key_ = std::move(key);
    ++loaded_;
  }
  report.notes.insert(report.notes.end(), report_.notes.begin(), report_.notes.end());
  report.warnings.insert(report.warnings.end(), report_.warnings.begin(), report_.warnings.end());
  report.listings.insert(report.listings.end(), report_.listings.begin(), report_.listings.end());
  return shared ? with_anatomy(bone_, settings, report) : bone_;
}

}  // namespace reamsim
