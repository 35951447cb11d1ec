// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scan/scan_transfer.h"

namespace reamsim::ct {

// DICOM files are read by child processes, because GDCM crashes on some damaged files.

/// The headers of `files`, in their order. Files that crash the reader, or take it too long, are DicomKind::damaged.
/// `folder`: for messages. Throws InputError when there are many such files.
std::vector<DicomFile> read_dicom_headers(const std::vector<std::string>& files, const std::string& folder,
                                          const std::string& key);

/// What the file of a slice says about its pixels.
struct SliceFacts {
  ScanGeometry geometry;  ///< its slice thickness may differ from the slice spacing
  std::string pixel_type;
};

/// Throws InputError, with the file: truncated, damaged.
std::vector<SliceFacts> read_slice_facts(const std::vector<std::string>& files, const std::string& key);

/// The values of a box of each slice, one slice after the other. Throws InputError, with the file.
std::vector<float> read_slices(const std::vector<std::string>& files, const IndexBox& in_slice, const std::string& key);

/// Reads a file up to its pixels. Fills `header` if the file contains an image.
DicomKind read_dicom_header(const std::string& path, DicomHeader& header);

}  // namespace reamsim::ct
