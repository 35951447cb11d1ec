#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"

namespace reamsim::test {

/// A valid input of a reader, of which the fuzzer damages one file.
struct Seed {
  std::string reader;              ///< for the findings: "PLY", "DICOM", ...
  std::string folder;              ///< holds its files only
  std::vector<std::string> files;  ///< those that are damaged, in turn; names in the folder
  BoneSettings bone;               ///< reads it
  std::string named;               ///< what a message has to name: a file or folder
};

/// Writes the seeds of all readers to subfolders of `folder`.
std::vector<Seed> write_seeds(const std::string& folder);

/// Reads a bone from a file of any format, by its extension.
BoneSettings bone_from_file(const std::string& path);

/// Reads it as a run does. Throws InputError.
void load(const BoneSettings& bone);

}  // namespace reamsim::test
