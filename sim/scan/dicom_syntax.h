// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim::ct {

// Transfer syntaxes: how a DICOM file and its pixels are coded.

/// The transfer syntax UID in the meta information of a file, also one that GDCM does not know; "" without one.
std::string syntax_in_file(const std::string& path);

/// "JPEG 2000"; "" for one that is not compressed, or unknown.
std::string name_of_syntax(const std::string& uid);

/// Whether GDCM can decode it. "" is taken as supported: files without meta information are implicit little endian.
bool is_supported_syntax(const std::string& uid);

/// Compression that always loses values, or may do so.
bool is_lossy_syntax(const std::string& uid);
bool may_be_lossy_syntax(const std::string& uid);

/// What to do about files in a syntax that cannot be decoded.
std::string how_to_decode(const std::string& name_and_uid);

}  // namespace reamsim::ct
