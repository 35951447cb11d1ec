// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

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
  BoneSettings bone;               ///< of a file of foreign origin: what `read` loads
  std::string named;               ///< what a message has to name: a file or folder; "" = the damaged file
  bool text = false;               ///< damaged as a text as well
  /// Reads it as the program does. Throws InputError. The argument is the path of the damaged file.
  std::function<void(const std::string&)> read;
  /// Makes the damaged bytes of a file (its name, its bytes) pass a checksum; none = as they are.
  std::function<std::string(const std::string&, std::string)> repair;
};

/// Writes the seeds of all readers to subfolders of `folder`.
std::vector<Seed> write_seeds(const std::string& folder);

/// Those of what reamsim itself parses: scenarios, poses, results, checkpoints.
std::vector<Seed> write_text_seeds(const std::string& folder);

/// Reads a bone from a file of any format, by its extension.
BoneSettings bone_from_file(const std::string& path);

/// Reads it as a run does. Throws InputError.
void load(const BoneSettings& bone);

}  // namespace reamsim::test
