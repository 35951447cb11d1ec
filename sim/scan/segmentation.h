// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// A plane of a CT scan in the radiological convention: rows from the top, columns from the left.
struct ScanPlane {
  std::string name;  ///< axial | coronal | sagittal
  int columns = 0;
  int rows = 0;
  Vec2 spacing_mm = Vec2::Ones();        ///< of columns and of rows
  Vec2 through = Vec2::Zero();           ///< column and row of the common point of the three planes
  std::string left, right, top, bottom;  ///< anatomical directions: R, L, A, P, S, I
  std::vector<float> hu;                 ///< row by row
  std::vector<float> field;              ///< above 0 in the bone, 0 at its outline

  [[nodiscard]] std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(column) + static_cast<std::size_t>(row) * static_cast<std::size_t>(columns);
  }

  static auto fields(auto& s) {
    return std::tie(s.name, s.columns, s.rows, s.spacing_mm, s.through, s.left, s.right, s.top, s.bottom, s.hu,
                    s.field);
  }
};

/// Figures of the segmentation of a CT scan. Volumes are of whole image voxels, mm³.
struct Segmentation {
  std::string method;  ///< threshold | label_map
  double threshold_hu = 0;
  std::int64_t pieces = 0;     ///< connected pieces above the threshold, after the cuts
  bool by_seed = false;        ///< the piece with the seed was kept, not the largest
  std::int64_t kept_rank = 0;  ///< of the kept piece by size: 1 is the largest
  double kept_piece_mm3 = 0;   ///< the kept piece before closing and filling
  double largest_mm3 = 0;
  double second_mm3 = 0;                  ///< second largest piece; 0: none
  double dropped_mm3 = 0;                 ///< all other pieces together
  double cut_mm3 = 0;                     ///< bone above the threshold that cut spheres and planes removed
  double closed_mm3 = 0;                  ///< added by closing
  double filled_mm3 = 0;                  ///< added by filling holes
  double bone_mm3 = 0;                    ///< the resulting bone
  double below_threshold_fraction = 0;    ///< of the bone's volume
  double lower_bound_fraction = 0;        ///< of the boundary voxels: those whose density is a lower bound
  double noise_hu = 0;                    ///< standard deviation between neighbouring voxels inside the bone
  Vec3 planes_through_mm = Vec3::Zero();  ///< B: the seed, else the centre of the glenoid, else of the bone
  std::vector<ScanPlane> planes;

  static auto fields(auto& s) {
    return std::tie(s.method, s.threshold_hu, s.pieces, s.by_seed, s.kept_rank, s.kept_piece_mm3, s.largest_mm3,
                    s.second_mm3, s.dropped_mm3, s.cut_mm3, s.closed_mm3, s.filled_mm3, s.bone_mm3,
                    s.below_threshold_fraction, s.lower_bound_fraction, s.noise_hu, s.planes_through_mm, s.planes);
  }
};

/// One sentence for the console.
std::string sentence_of(const Segmentation& segmentation);

}  // namespace reamsim
