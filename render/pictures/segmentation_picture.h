#pragma once

#include <string>

#include "sim/bone/ct/segmentation.h"

namespace reamsim {

/// Writes DIR/segmentation.png: the three planes of the CT with the outline of the segmented bone, all to one scale, in
/// the radiological convention. Does nothing where there are no planes. Throws RunError when it cannot be written.
void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation);

}  // namespace reamsim
