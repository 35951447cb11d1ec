#pragma once

#include <vector>

#include "sim/motion/key_poses.h"

namespace reamsim {

/// Reads recorded poses: a header line and rows of `time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz` and optionally `spin_rpm`
/// (otherwise settings.spin_rpm), in any order of columns; other columns are ignored with a note. Times must increase
/// and need not be equidistant. A byte-order mark, CRLF, blank lines and blanks around fields are tolerated. Throws
/// InputError with file and line: no such file, empty, missing or repeated column, wrong number of fields, not a finite
/// number, position beyond a kilometre, time not increasing, zero quaternion, fewer than two rows.
std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Report& report);

}  // namespace reamsim
