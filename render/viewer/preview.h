// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What `reamsim preview` shows.
struct PreviewRequest {
  Scenario scenario;      ///< bone, tool and motion
  std::string text;       ///< the scenario as its user wrote it, which the page changes
  std::string file_name;  ///< under which the page saves it
  std::string source;     ///< what the page is titled with: the name of the scenario or of the bone's file
};

/// The page: HTML without network, at most 15 MB. Problems of segmentation, frame, tool and motion that stop a run are
/// shown in the page, because it is there to mend them; `report` gets warnings. Throws InputError when the bone itself
/// cannot be read.
std::string preview_page(const PreviewRequest& request, Diagnostics& report);

/// Whether a file is such a page.
bool is_preview_page(const std::string& path);

}  // namespace reamsim
