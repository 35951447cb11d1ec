#pragma once

#include <string>

#include "render/pictures/run_data.h"
#include "sim/base/report.h"
#include "sim/bone/ct/segmentation.h"

// What is made of a run beside its rendered pictures.
namespace reamsim {

/// Draws DIR/depth_map.csv as DIR/depth_map.png, with the directions that the run knows. `depth_max_mm` ends the
/// legend; 0: the greatest depth does. No picture when nothing was reamed, or the run wrote no map.
/// Throws InputError when a file is damaged, RunError when the picture cannot be written.
void write_depth_picture(const RunData& run, double depth_max_mm);

/// Writes DIR/reamed.glb (with depth colours that end at `depth_max_mm`; 0: where those of the pictures do)
/// and DIR/reamed.stl: the surface of DIR/reamed.vdb, closed, B, mm. Where no bone is left neither is written, and
/// `report` gets a warning. Throws InputError when a result is missing or damaged, RunError when a file cannot be
/// written.
void write_meshes(const RunData& run, double depth_max_mm, Report& report);

/// Writes DIR/segmentation.png: the three planes of the CT with the outline of the segmented bone, all to one scale, in
/// the radiological convention. Does nothing where there are no planes. Throws RunError when it cannot be written.
void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation);

}  // namespace reamsim
