// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nifti1_io.h>

#include <memory>
#include <string>

namespace reamsim::ct {

/// The header of a NIfTI file; freed with the pointer.
using NiftiHeader = std::unique_ptr<nifti_image, decltype(&nifti_image_free)>;

/// Null if missing.
inline NiftiHeader read_nifti_header(const std::string& path) {
  return {nifti_image_read(path.c_str(), 0), &nifti_image_free};
}

}  // namespace reamsim::ct
