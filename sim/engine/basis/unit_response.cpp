// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/basis/unit_response.h"

namespace reamsim {

namespace {

/// Force, torque and energy of the sums, in N, N·mm and mJ.
void add_edge(const LaneSums& sums, std::size_t first, BasisValues& out) {
  for (std::size_t i = 0; i < 3; ++i) {
    out[first + i] = static_cast<double>(sums.force[i]) / RS_FORCE_SCALE;
    out[first + 3 + i] = static_cast<double>(sums.torque[i]) / RS_TORQUE_SCALE;
  }
  out[12] += static_cast<double>(sums.energy) / RS_ENERGY_SCALE;
}

}  // namespace

UnitArgs::UnitArgs(const SubstepArgs& args, float edges_per_turn)
    : without_normal(args), with_normal(args), edge_along(args), edge_normal(args) {
  without_normal.normal_ratio = 0;
  with_normal.normal_ratio = 1;
  edge_along.edge_tangential = edge_normal.edge_normal = edges_per_turn;
  edge_along.edge_normal = edge_normal.edge_tangential = 0;
}

BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3) {
  float without[RS_WINDOW_SUMS], with[RS_WINDOW_SUMS];
  rs_window_response(&args.without_normal, &clip, volume_mm3, without);
  rs_window_response(&args.with_normal, &clip, volume_mm3, with);
  BasisValues out{};
  for (std::size_t i = 0; i < RS_SUM_OF_ENERGY; ++i) {
    out[i] = double{without[i]};
    out[6 + i] = double{with[i]} - double{without[i]};
  }
  out[12] = double{without[RS_SUM_OF_ENERGY]};
  out[13] = double{without[RS_SUM_OF_FLOOR]};
  return out;
}

BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 remaining, rs_i32 outside) {
  LaneSums along{}, normal{};
  rs_edge_force(&args.edge_along, &clip, remaining, outside, &along);
  rs_edge_force(&args.edge_normal, &clip, remaining, outside, &normal);
  BasisValues out{};
  add_edge(along, 0, out);
  add_edge(normal, 6, out);
  return out;
}

}  // namespace reamsim
