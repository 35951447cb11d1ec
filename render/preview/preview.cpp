// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/preview/preview.h"

#include <map>

#include "render/preview/preview_data.h"
#include "render/report/markup.h"
#include "sim/base/error.h"
#include "sim/base/file.h"

namespace reamsim {
namespace embedded {
extern const char* const preview_page;
extern const char* const preview_script;
extern const char* const preview_style;
}  // namespace embedded
namespace {

constexpr std::size_t kMaxBytes = 14'500'000;
/// A CT cropped to a shoulder. The page opens within three seconds on two cores (docs/preview.md).
constexpr std::int64_t kMaxVoxels = 8'000'000;
constexpr const char* kMark = "<meta name=\"generator\" content=\"reamsim preview";

}  // namespace

std::string preview_page(const PreviewRequest& request, Diagnostics& report) {
  const PreviewBone bone = load_preview_bone(request.scenario, report);
  // Noise does not compress, so the number of voxels alone does not bound the size.
  for (std::int64_t most_voxels = kMaxVoxels;; most_voxels /= 2) {
    Diagnostics found = report;
    const std::string page = fill_template(
        embedded::preview_page, {{"title", escape_html(request.source)},
                                 {"program", "reamsim preview " REAMSIM_VERSION},
                                 {"style", embedded::preview_style},
                                 {"script", embedded::preview_script},
                                 {"data", json_for_script(preview_data(request, bone, most_voxels, found))}});
    if (page.size() > kMaxBytes && most_voxels > 1) continue;
    report = std::move(found);
    return page;
  }
}

bool is_preview_page(const std::string& path) {
  return read_file_start(path, 2048).find(kMark) != std::string::npos;
}

}  // namespace reamsim
