// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Writes density × fill (g/cm³, float32) at the voxel centres as a VTK ImageData file, zlib-compressed, for readers
/// without OpenVDB (ParaView, 3D Slicer, PyVista). Written block by block, a few MB at a time; readers need 4 bytes for
/// every voxel of the lattice, air included. Throws RunError when the file cannot be written.
void write_vti(const std::string& path, const BoneView& bone);

}  // namespace reamsim
