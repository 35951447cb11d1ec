#pragma once

#include <string>

namespace reamsim {

/// The output folder of a run: work goes to DIR.partial/, which becomes DIR when all is done (design §6).
class OutputFolder {
 public:
  /// Makes DIR.partial. Throws InputError: DIR exists and not `overwrite`; the parent is not writable.
  OutputFolder(const std::string& dir, bool overwrite);
  /// Removes DIR.partial unless finish() or keep() was called.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// DIR.partial while working.
  [[nodiscard]] const std::string& path() const { return partial_; }
  [[nodiscard]] const std::string& final_path() const { return dir_; }
  /// True when frames have been recorded in it, so that a failure should not throw them away.
  [[nodiscard]] bool has_frames() const;
  /// Puts DIR.partial in DIR's place; an old DIR goes only now.
  void finish();
  /// Leaves DIR.partial where it is (interrupted, or failed with finished frames).
  void keep() { keep_ = true; }

 private:
  std::string dir_;
  std::string partial_;
  bool overwrite_ = false;
  bool keep_ = false;
};

}  // namespace reamsim
