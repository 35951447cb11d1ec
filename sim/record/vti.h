#pragma once

#include <string>

#include "sim/bone/voxmap.h"

namespace reamsim {

/// Writes density × fill (g/cm³, float32) at the voxel centres as a VTK ImageData file, zlib-compressed, for readers
/// without OpenVDB (ParaView, 3D Slicer, PyVista). Throws RunError when the file cannot be written.
void write_vti(const std::string& path, const Voxmap& voxmap);

}  // namespace reamsim
