#pragma once

#include <openvdb/openvdb.h>

namespace reamsim {

// An empty grid with the identity as its transform. Made in one place, because each file that calls OpenVDB's create()
// takes half a minute longer to compile.
openvdb::FloatGrid::Ptr make_float_grid(float background);
openvdb::BoolGrid::Ptr make_bool_grid(bool background);

}  // namespace reamsim
