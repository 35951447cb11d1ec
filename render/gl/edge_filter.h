#pragma once

#include "render/gl/pixel_image.h"

namespace reamsim {

/// The picture with its jagged edges smoothed, as after multisampling at a small part of the price: where the
/// brightness steps, each pixel takes from its neighbour across the step the share that the edge's line, followed along
/// its steps, would cut off it; single bright or dark pixels are softened (T. Lottes, "FXAA", NVIDIA white paper,
/// 2009). Flat parts and slow shades stay as they are, to the bit. What is transparent counts as white.
PixelImage edges_smoothed(const PixelImage& image);

}  // namespace reamsim
