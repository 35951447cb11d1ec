#include "sim/collide/serial_detector.h"

#include "sim/collide/device_state.h"
#include "sim/tool/morton.h"

namespace reamsim {

SerialState make_serial_state(const Voxmap& voxmap, const Tool& tool) {
  SerialState state;
  state.tool = &tool;
  state.edges = profile_edges(tool.profile);
  state.grid = voxmap.grid;
  state.bone = voxmap.grade;
  state.fill.assign(voxmap.grade.size(), FillBricks::kWhole);
  if (voxmap.fill.stored_bricks() == 0) return state;
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    const auto i = static_cast<std::size_t>(e);
    state.fill[i] = voxmap.fill.get(voxmap.grid.coord(e));
    if (state.fill[i] == 0) state.bone[i] = 0;
  }
  return state;
}

void SerialDetector::detect(int slot) {
  const Stopwatch watch;
  const SubstepArgs& args = state_.args[static_cast<std::size_t>(slot)];
  const auto edge_count = static_cast<rs_i32>(state_.edges.size());
  for (const std::uint64_t code : state_.tool->shell.codes) {
    const Vec3i cell = morton_decode(code);
    const int x = cell.x(), y = cell.y(), z = cell.z();
    const Vec3i voxel(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                      rs_voxel_coordinate(&args, 2, x, y, z));
    if (!state_.grid.contains(voxel)) continue;
    const auto e = static_cast<std::size_t>(state_.grid.index(voxel.x(), voxel.y(), voxel.z()));
    if (state_.bone[e] == 0) continue;
    if (args.law == RS_LAW_PER_POINT) {
      rs_point_force(&args, state_.edges.data(), edge_count, x, y, z, &state_.sums[static_cast<std::size_t>(slot)]);
    }
    if (claimed_[e]) continue;
    claimed_[e] = true;
    state_.contacts.push_back(static_cast<std::int64_t>(e));
  }
  for (const std::int64_t e : state_.contacts) claimed_[static_cast<std::size_t>(e)] = false;
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
