// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>

#include "sim/scan/scan.h"

namespace reamsim::ct {

/// Opens a folder of DICOM slices (dicom_stack.cpp). Throws InputError: no DICOM, slices that do not form a volume.
std::unique_ptr<ScanSource> open_dicom_folder(const std::string& path, const std::string& key,
                                              const DicomChoice& choice, Diagnostics& report);

}  // namespace reamsim::ct
