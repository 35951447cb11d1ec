// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Text escaped for HTML, between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// Bytes in base 64 (RFC 4648, padded).
std::string base64(std::span<const std::uint8_t> bytes);

/// Bytes compressed by zlib (RFC 1950), in base 64.
std::string compressed_base64(std::span<const std::uint8_t> bytes);

/// JSON escaped for an element `script`: it cannot end the element or open a comment. Invalid UTF-8 is replaced.
std::string json_for_script(const nlohmann::ordered_json& json);

/// A value rounded to six significant digits, for short JSON.
double short_number(double value);

/// x, y, z with six significant digits.
template <class Vector>
nlohmann::ordered_json vector_json(const Vector& v) {
  return {short_number(v.x()), short_number(v.y()), short_number(v.z())};
}
/// Lower and upper corner of a box.
template <class Vector>
nlohmann::ordered_json box_json(const Vector& low, const Vector& high) {
  return nlohmann::ordered_json::array({vector_json(low), vector_json(high)});
}

using PageTexts = std::map<std::string, std::string>;

/// The pages of dist/, which build.mjs makes.
namespace embedded {
extern const char* const report_page;
extern const char* const preview_page;
extern const char* const study_page;
}  // namespace embedded

/// One of these pages as one HTML file that loads nothing: with its title, the name of the program, the data of its
/// scripts, and the `texts` (HTML) that it has other names for.
std::string self_contained_page(const char* page, const std::string& title, const std::string& program,
                                const nlohmann::ordered_json& data, PageTexts texts = {});

/// `page` with each {{name}} replaced, not recursively. Throws std::logic_error when a name has no text.
std::string fill_template(std::string_view page, const PageTexts& texts);

/// The page of a study: HTML without network, at most `most_bytes`, which sorts, filters and plots its runs and opens
/// their reports. A study that would be larger has a part of its runs, drawn at random; the page says so.
std::string study_page(const std::string& study, const struct RunTable& table, std::size_t most_bytes = 14'500'000);

/// What `reamsim preview` shows.
struct PreviewRequest {
  Scenario scenario;      ///< bone, tool and motion
  std::string text;       ///< the scenario as its user wrote it, which the page changes
  std::string file_name;  ///< under which the page saves it
  std::string source;     ///< what the page is titled with: the name of the scenario or of the bone's file
};

/// The page: HTML without network, at most 15 MB. It shows problems that stop a run, because it is there to mend them;
/// `report` gets warnings. Throws InputError when the bone itself cannot be read.
std::string preview_page(const PreviewRequest& request, Diagnostics& report);

/// Whether a file is such a page.
bool is_preview_page(const std::string& path);

/// What the page shows in its slices, on a lattice along the axes of B.
struct PreviewVolume {
  ct::Lattice lattice;
  std::string unit;          ///< of `value`: "HU" or "g/cm³"
  std::vector<float> value;  ///< radiodensity, or density with 0 in the air
  std::vector<float> bone;   ///< above 0 in the bone, 0 at its surface, within −1…1; empty without a segmentation
};

/// A CT scan and its segmentation, averaged to at most `most_voxels` voxels, first along axes with small spacing.
PreviewVolume preview_of_scan(const SegmentedScan& scan, std::int64_t most_voxels);

/// A voxmap, averaged over cubes of n³ voxels, with the least n for at most `most_voxels` cubes.
PreviewVolume preview_of_voxmap(const BoneView& bone, std::int64_t most_voxels);

/// The volume for the page: its lattice, `unit`, and as differences to the previous voxel, zlib in base 64: `values`, a
/// byte v per voxel for low + step·v, and `bone`, a byte per voxel, 128 at the surface and more inside, or null.
nlohmann::ordered_json volume_json(const PreviewVolume& volume);

}  // namespace reamsim
