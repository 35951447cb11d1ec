// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace reamsim {

/// SHA-256 of a file, in hex; for a folder (DICOM, with its subfolders): of the relative paths and sums of its files,
/// sorted by path. Throws InputError when a file cannot be read.
/// `before`: counts as if it stood before the content of each file.
std::string sha256_of(const std::string& path, const std::string& before = "");

std::string sha256_of_text(const std::string& text);

/// CRC-32 of bytes that follow those with the sum `before`.
std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace reamsim
