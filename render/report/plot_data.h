#pragma once

#include <nlohmann/json.hpp>

#include "sim/record/force_log.h"

namespace reamsim {

/// The curves of the page's plot, columns of equal length: `frame`, `time_s`, `depth_mm`, `axial_force_n`,
/// `spin_torque_nmm`, `removed_mm3` (since the start); and, where forces are means over some travel (the log has them),
/// `mean_axial_force_n`, `mean_spin_torque_nmm` with `mean_travel_mm`. Of very many rows those stay that have the least
/// and the greatest force and torque of their neighbours, so that no spike is lost.
nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm);

}  // namespace reamsim
