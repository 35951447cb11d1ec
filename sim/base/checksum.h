// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim {

/// SHA-256 of a file, in hex; for a folder (DICOM, with its subfolders): of the relative paths and sums of its files,
/// sorted by path. Throws InputError when a file cannot be read.
/// `before`: counts as if it stood before the content of each file.
std::string sha256_of(const std::string& path, const std::string& before = "");

std::string sha256_of_text(const std::string& text);

}  // namespace reamsim
