#include "sim/bone/vdb/vdb_grid.h"

namespace reamsim {

openvdb::FloatGrid::Ptr make_float_grid(float background) {
  return openvdb::FloatGrid::create(background);
}

openvdb::BoolGrid::Ptr make_bool_grid(bool background) {
  return openvdb::BoolGrid::create(background);
}

}  // namespace reamsim
