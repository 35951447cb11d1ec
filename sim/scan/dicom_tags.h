// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <span>
#include <string>

#include "sim/scan/dicom_values.h"

namespace reamsim::ct {

/// An element that may tell volumes of one series apart.
struct SeparatingTag {
  const char* keyword;
  DicomTag tag;
  DicomType type = DicomType::text;
  bool is_time = false;  ///< differs between slices of one volume as well
};

/// Those known, the one that says most about the reason first.
std::span<const SeparatingTag> separating_tags();

/// Adds the values that a data set has, by keyword.
void add_tags(const DicomValues& values, std::map<std::string, std::string>& tags);

}  // namespace reamsim::ct
