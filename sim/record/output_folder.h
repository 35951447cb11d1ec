#pragma once

#include <string>
#include <vector>

#include "sim/record/result_names.h"

namespace reamsim {

/// Where a command's results go, and what must not be harmed by that.
struct OutputRequest {
  std::string dir;
  ResultKind kind = ResultKind::run;
  bool overwrite = false;           ///< an older folder of the same kind may be replaced
  std::vector<std::string> inputs;  ///< files and folders that the command reads
};

/// The output folder of a command: work goes to DIR.partial/, which becomes DIR when all is done.
///
/// Nothing is deleted but files that a command of this kind writes. With `overwrite`, DIR and DIR.partial may be
/// replaced when they hold nothing else; never the current folder, a home, a mount point or a folder of an input, nor
/// a folder above one of these.
class OutputFolder {
 public:
  /// Makes DIR.partial. Throws InputError: DIR exists and not `overwrite`, DIR or DIR.partial may not be replaced, or
  /// the parent is not writable.
  explicit OutputFolder(const OutputRequest& request);
  /// Removes DIR.partial unless finish() or keep() was called.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// DIR.partial while working.
  [[nodiscard]] const std::string& path() const { return partial_; }
  [[nodiscard]] const std::string& final_path() const { return dir_; }
  /// True when frames have been recorded in it, so that a failure should not throw them away.
  [[nodiscard]] bool has_frames() const;
  /// Puts DIR.partial in DIR's place; an old DIR is removed only now. Throws RunError when that fails: the results are
  /// complete and stay in DIR.partial, and the message says so.
  void finish();
  /// Leaves DIR.partial where it is (interrupted, or failed with finished frames).
  void keep() { keep_ = true; }

 private:
  ResultKind kind_;
  std::string dir_;
  std::string partial_;
  bool overwrite_ = false;
  bool keep_ = false;
};

/// Refuses to write the single file `path` (`key` names the option) where that would destroy something: a folder, one
/// of `inputs`, or a file that is there already, unless `overwrite` is given and `is_ours(path)` holds. Throws
/// InputError.
void require_replaceable_file(const std::string& path, const std::string& key, bool overwrite,
                              bool (*is_ours)(const std::string&), const std::vector<std::string>& inputs);

}  // namespace reamsim
