// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <set>
#include <string>

namespace reamsim {

/// The file of a results folder that lists what reamsim wrote into it.
inline constexpr const char* kManifestName = "manifest.json";

struct Manifest {
  std::string kind;             ///< run | comparison | verification | benchmark
  std::set<std::string> files;  ///< relative to the folder, without the manifest
  bool complete = true;         ///< false while a command adds files
};

/// DIR/manifest.json; nullopt where it does not exist or is not a manifest.
std::optional<Manifest> read_manifest(const std::string& dir);
/// Replaces DIR/manifest.json. `durable`: it is on the disk on return. Throws RunError when it cannot be written.
void write_manifest(const std::string& dir, const Manifest& manifest, bool durable = true);

/// SHA-256 of a file, in hex; for a folder (DICOM, with its subfolders): of the relative paths and sums of its files,
/// sorted by path. Throws InputError when a file cannot be read.
std::string sha256_of(const std::string& path);

std::string sha256_of_text(const std::string& text);

/// What stays in the folder of a run beside scenario.yaml and summary.json.
struct KeptFiles {
  bool forces = true;    ///< forces.csv
  bool grids = true;     ///< reamed.vdb, reamed.vti, depth_map.csv and planning.mrk.json
  bool pictures = true;  ///< pictures, plots, meshes, report, and all that these are made from
};

}  // namespace reamsim
