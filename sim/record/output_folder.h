// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// The file of a results folder that lists what reamsim wrote into it.
inline constexpr const char* kManifestName = "manifest.json";

struct Manifest {
  std::string kind;             ///< run | comparison | verification | benchmark
  std::set<std::string> files;  ///< relative to the folder, without the manifest
  bool complete = true;         ///< false while a command adds files
};

/// DIR/manifest.json; nullopt where it does not exist or is not a manifest.
std::optional<Manifest> read_manifest(const std::string& dir);
/// Replaces DIR/manifest.json. `durable`: it is on the disk on return. Throws RunError when it cannot be written.
void write_manifest(const std::string& dir, const Manifest& manifest, bool durable = true);

/// What stays in the folder of a run beside scenario.yaml and summary.json.
struct KeptFiles {
  bool forces = true;    ///< forces.csv
  bool grids = true;     ///< reamed.vdb, .vti and .seg.nrrd, depth_map.csv and planning.mrk.json
  bool pictures = true;  ///< pictures, plots, meshes, report, and all that these are made from
};

enum class ResultKind { run, comparison, verification, benchmark };

/// The first entry below `dir`, relative to it, that no command of this kind wrote: one that its manifest does not list
/// (in older or unfinished folders: with another name), a link, or an entry that cannot be read.
std::optional<std::string> foreign_entry(const std::string& dir, ResultKind kind);

/// Whether `dir` holds a file that marks a finished folder of this kind.
bool is_marked(const std::string& dir, ResultKind kind);

/// Writes DIR/manifest.json with what reamsim wrote, except the files `foreign`. `durable`: it is on the disk on
/// return. Throws RunError.
void list_results(const std::string& dir, ResultKind kind, const std::set<std::string>& foreign = {},
                  bool durable = true);

/// Marks the manifest of DIR, if it has one, as incomplete until list_results(): files will be added. Returns the files
/// that are not ours. Throws RunError.
std::set<std::string> open_results(const std::string& dir, ResultKind kind);

/// Removes from `dir` what a command of this kind wrote, then `dir` itself if it is empty. Returns whether
/// `dir` was removed.
bool remove_results(const std::string& dir, ResultKind kind);

/// The names of the folders of finished runs in the folder of a study, in order.
std::vector<std::string> finished_runs(const std::string& study_dir);

class FolderInUse : public InputError {
 public:
  using InputError::InputError;
};

/// Reserves a results folder for this process while this object exists: the file DIR.lock, which names its holder.
/// After a crash the system releases it; the file that stays then does not matter.
class FolderLock {
 public:
  /// Throws FolderInUse (the message says by which process), or InputError: the file cannot be created, or is not a
  /// lock. On file systems without locks it only creates the file.
  explicit FolderLock(const std::string& dir);
  ~FolderLock() { release(); }
  void release();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::string path_;
  int descriptor_ = -1;
};

struct OutputRequest {
  std::string dir;
  ResultKind kind = ResultKind::run;
  bool overwrite = false;           ///< an older folder of the same kind may be replaced
  bool resume = false;              ///< the unfinished DIR.partial is to be continued
  std::vector<std::string> inputs;  ///< files and folders that the command reads; they must not be replaced
  bool durable = true;              ///< finish() waits until the results are on the disk
};

/// The output folder of a command. Results are written to DIR.partial/, which becomes DIR when all are complete and on
/// the disk. DIR.lock reserves both.
///
/// Only files that a command of this kind wrote are ever deleted (foreign_entry()). With `overwrite`, DIR and
/// DIR.partial may be replaced when they hold nothing else; never the current folder, a home, a mount point, the folder
/// of an input, or a folder above one of these.
class OutputFolder {
 public:
  /// Creates DIR.partial. Throws InputError: DIR exists and not `overwrite`, DIR or DIR.partial may not be replaced,
  /// another process uses them, or the parent is not writable.
  explicit OutputFolder(const OutputRequest& request);
  /// Removes DIR.partial unless finish() or keep() was called.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// DIR.partial while working.
  [[nodiscard]] const std::string& path() const { return partial_; }
  [[nodiscard]] const std::string& final_path() const { return dir_; }
  void clear();
  /// Whether it has recorded frames.
  [[nodiscard]] bool has_frames() const;
  /// Whether the results to be continued are complete: their process ended before it had moved them.
  [[nodiscard]] bool is_complete() const { return complete_; }
  /// Lists the results in their manifest, moves DIR.partial to DIR, and removes an old DIR only then. Calls
  /// `remove_unfinished` once the results are complete. Throws RunError, which says where the results are. Returns a
  /// warning where parts of an old DIR remain, else "".
  std::string finish(const std::function<void()>& remove_unfinished = {});
  /// Tidies up for a process that ends at once: releases DIR.lock, and removes DIR.partial unless it has frames.
  void abandon();
  /// Keeps DIR.partial (interrupted, or failed with finished frames).
  void keep() { keep_ = true; }

 private:
  void create_partial() const;
  std::string put_in_place();

  ResultKind kind_;
  std::string dir_;
  std::string partial_;
  bool overwrite_ = false;
  bool durable_ = true;
  bool keep_ = false;
  bool complete_ = false;
  std::shared_ptr<void> parents_;  ///< removes the folders that were created above the output and stayed empty
  FolderLock lock_;
};

/// Files that a command adds to finished results. Reserves the folder meanwhile.
class ResultUpdate {
 public:
  /// Throws InputError where another process uses the folder or it is not writable.
  ResultUpdate(const std::string& dir, ResultKind kind);
  /// Adds the new files to the manifest. Throws RunError.
  void finish();

 private:
  std::string dir_;
  ResultKind kind_;
  FolderLock lock_;
  std::set<std::string> foreign_;
};

/// Throws InputError where writing the file `path` (`key` names the option) would destroy something: a folder, one of
/// `inputs`, or an existing file, unless `overwrite` is given and `is_ours(path)` holds.
void require_replaceable_file(const std::string& path, const std::string& key, bool overwrite,
                              bool (*is_ours)(const std::string&), const std::vector<std::string>& inputs);

}  // namespace reamsim
