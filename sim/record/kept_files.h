// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace reamsim {

/// What stays in the folder of a run beside scenario.yaml and summary.json.
struct KeptFiles {
  bool forces = true;    ///< forces.csv
  bool grids = true;     ///< reamed.vdb, reamed.vti and depth_map.csv
  bool pictures = true;  ///< pictures, plots, meshes, report, and all that these are made from
};

}  // namespace reamsim
