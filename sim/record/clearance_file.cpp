// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/clearance_file.h"

#include <nlohmann/json.hpp>

#include "sim/base/csv.h"
#include "sim/record/result_json.h"

namespace reamsim {

nlohmann::ordered_json clearance_json(const HolderClearance& clearance, const SimulationInput& scene) {
  const FrameClearance& least = clearance.least;
  const Vec3& p = least.point_mm;
  nlohmann::ordered_json json{{"least_mm", least.mm},
                              {"frame", least.frame},
                              {"time_s", static_cast<double>(least.frame) * scene.motion.frame_s()},
                              {"part", holder_part_name(scene.scenario, least)},
                              {"obstacle", name_of(least.obstacle)},
                              {"point_mm", {p.x(), p.y(), p.z()}},
                              {"limit_mm", scene.scenario.clearance.least_mm},
                              {"first_frame_below", nullptr},
                              {"last_frame_below", nullptr}};
  if (clearance.first_below) json["first_frame_below"] = *clearance.first_below;
  if (clearance.last_below) json["last_frame_below"] = *clearance.last_below;
  return json;
}

void write_clearance(const std::string& path, const HolderClearance& clearance, double frame_s) {
  CsvWriter log(path, "frame,time_s,clearance_mm,part,envelope,x_mm,y_mm,z_mm,pass");
  for (const FrameClearance& row : clearance.frames) {
    const Vec3& p = row.point_mm;
    const double part = static_cast<double>(row.part) + 1;
    log.row({static_cast<double>(row.frame), static_cast<double>(row.frame) * frame_s, row.mm, part,
             row.obstacle == Obstacle::envelope ? 1.0 : 0.0, p.x(), p.y(), p.z(), static_cast<double>(row.pass)});
  }
  log.close();
}

}  // namespace reamsim
