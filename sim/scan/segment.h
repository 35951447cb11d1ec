// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/scan.h"
#include "sim/scan/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

// The stages from an image on LPS axes to a voxmap. Private to sim/scan.

// Sets of voxels, and filters (morphology.cpp, curvature_diffusion.cpp).

/// A set of voxels on the lattice of an image: 1 inside, 0 outside.
using Mask = std::vector<std::uint8_t>;

/// The voxels with a value above 0.
Mask positive_voxels(const AlignedImage& image);
Mask complement(const Mask& mask);
/// Whether one of the six voxels beside a voxel lies in the image and not in the mask.
bool has_face_outside(const Mask& mask, const Lattice& lattice, const Vec3i& voxel);
/// The voxels whose box of ±`radius` voxels lies in the mask. Beyond the image the values of its border hold.
Mask eroded(const Mask& mask, const Lattice& lattice, const Vec3i& radius);
/// The voxels whose box of ±`radius` voxels meets the mask.
Mask dilated(const Mask& mask, const Lattice& lattice, const Vec3i& radius);

/// A connected component; its voxels share faces.
struct Piece {
  std::uint32_t label = 0;  ///< in the label image: 1 for the largest piece, then by size
  std::int64_t voxels = 0;
  Vec3i min = Vec3i::Constant(std::numeric_limits<int>::max());  ///< first and last voxel of its bounding box
  Vec3i max = Vec3i::Constant(-1);

  void add(const Vec3i& voxel) {
    ++voxels;
    min = min.cwiseMin(voxel);
    max = max.cwiseMax(voxel);
  }
};

/// The voxels from `first` to `last` with a margin, within the image.
IndexBox box_around(const Vec3i& first, const Vec3i& last, const Vec3i& margin, const Lattice& lattice);

/// The part of the values of an image in a box.
template <class Value>
std::vector<Value> part_of(const std::vector<Value>& values, const Lattice& lattice, const IndexBox& box) {
  std::vector<Value> out;
  out.reserve(static_cast<std::size_t>(box.voxels()));
  for_each_voxel(box.size, [&](const Vec3i& voxel) { out.push_back(values[lattice.index(voxel + box.start)]); });
  return out;
}

struct Pieces {
  std::vector<std::uint32_t> label;  ///< 0 outside
  std::vector<Piece> list;           ///< list[n] has label n+1
};

/// Median over a box of (2·radius+1)³ voxels.
void median_filter(AlignedImage& image, int radius_voxels);

/// Curvature anisotropic diffusion (Whitaker and Xue 2001), as ITK's filter with its largest stable time step.
void curvature_anisotropic_filter(AlignedImage& image, int iterations, double conductance);

void gaussian_filter(AlignedImage& image, double sigma_voxels);

Pieces connected_pieces(const Mask& mask, const Lattice& lattice);

/// Morphological closing by a ball of `radius_mm`, rounded to voxels along each axis.
void close_mask(Mask& mask, const Lattice& lattice, double radius_mm);

/// Fills the holes of the mask and returns the number of voxels filled. A part of the background that the mask encloses
/// within a face of the image is a hole: a bone that extends beyond the image keeps its interior.
std::int64_t fill_holes(Mask& mask, const Lattice& lattice);

// Label maps (label_map.cpp).

/// The named segments of a .seg.nrrd (SegmentN_Name, SegmentN_Layer, SegmentN_LabelValue), in their order. Files
/// without these keys have one segment per layer, of value 1.
std::vector<NamedSegment> segments_of_nrrd(const std::map<std::string, std::string>& metadata, int layers);

/// The named labels in the XML extensions of a NIfTI file, `<Label Key="7" ...>name</Label>`, as TotalSegmentator
/// writes.
std::vector<NamedSegment> segments_of_nifti(const std::vector<std::string>& extensions);

/// The labels for `wanted`: a whole number is a value, anything else a name (a to z as A to Z).
/// Throws InputError: an unknown name, a number that occurs in several layers.
std::vector<LabelValue> find_labels(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments,
                                    int layers, const std::string& path);

/// "scapula_left, 7".
std::string words_of_labels(const std::vector<std::string>& labels);

/// A label map on the lattice of a CT.
struct LabelImages {
  AlignedImage selected;  ///< 1 in voxels with one of the wanted labels, 0 elsewhere
  AlignedImage other;     ///< 1 in voxels with another label of the same layer
};

/// Reads the map of the scenario, finds the wanted labels and resamples them to the voxels of `hu`, which were read
/// from the voxels `box` of `image`. Warns if the map ends inside the bone.
/// Throws InputError: unreadable, no such label, no overlap of map and image.
LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Diagnostics& report);

// Segmentation.

/// Bone in an image, with a surface of subvoxel accuracy: `field` is above 0 in bone and 0 at the surface. Cuts are
/// applied again after resampling, to be as accurate as the voxmap allows.
struct BoneField {
  AlignedImage field;
  std::int64_t voxels = 0;        ///< of bone
  std::int64_t inside_below = 0;  ///< of these, below the threshold: trabecular bone and marrow
  Vec3i min = Vec3i::Zero();      ///< first and last voxel of the bone's bounding box
  Vec3i max = Vec3i::Zero();
  Segmentation facts;  ///< without the planes
};

/// Whether a cut sphere or plane removes this point.
bool is_cut_away(const CtSettings& settings, const Vec3& point_mm);

/// Threshold, cuts, the piece with the seed, closing, hole filling. The piece is chosen before closing, so that closing
/// never bridges a joint to the next bone. The seed may lie in trabecular bone: each piece is closed and filled for
/// that test. The field is signed_field(). Where the threshold determines the surface, its zero is the isosurface of
/// the interpolated HU; elsewhere it lies halfway between voxels. Throws InputError: nothing above the threshold, all
/// bone cut away, seed outside the crop or outside bone.
BoneField segment_by_threshold(const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

/// The field is the mask of the labels after a narrow Gaussian, which smooths the voxel steps, minus a half; with
/// `refine_mm` the result of refine_to_isosurface().
/// Throws InputError when no voxel has the label.
BoneField segment_by_label(LabelImages labels, const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

/// |HU − threshold|, positive in `bone` and negative outside.
std::vector<float> signed_field(const AlignedImage& hu, double threshold_hu, const Mask& bone);

/// Moves the surface of a mask to the isosurface of the HU where that lies within `reach_mm` along the normal. `field`
/// is above 0 in the mask; afterwards it is signed_field() of the refined mask. A voxel outside the mask becomes bone
/// if all points between it and the mask are dense and the density ends within reach. A voxel inside becomes air if all
/// points between it and the surface are not dense and bone begins within reach. So trabecular bone under a cortex is
/// kept, a joint gap is not crossed, and voxels of the `other` labels are never added.
void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Diagnostics& report);

/// Compares the wanted label with the scan, and warns, with volume and place, of
/// - bone that has no label and that the label encloses or that lies in a hole or notch of it no wider than 10 mm:
///   voxels of at least `refine_hu` in the closing of the label;
/// - a label that ends at the edge of the scan;
/// - pieces of the label beside the largest.
/// With `fill` the first become bone, and cavities that the label encloses.
void check_label(LabelImages& labels, const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

struct BoundaryDensity {
  std::int64_t boundary_voxels = 0;  ///< bone voxels with a face neighbour outside the bone
  /// Of these, voxels whose density is a lower bound: no trusted voxel, or a plate.
  std::int64_t unresolved_voxels = 0;
  double noise_hu = 0;  ///< standard deviation between neighbouring trusted voxels

  [[nodiscard]] double unresolved_fraction() const {
    return boundary_voxels == 0 ? 0 : static_cast<double>(unresolved_voxels) / static_cast<double>(boundary_voxels);
  }
};

/// Corrects the radiodensity of voxels at the boundary of the bone for partial volume, on the lattice of the scan and
/// before any resampling. A voxel is *trusted* if all voxels within the point spread around it are bone, so that its
/// value is that of bone alone. Trusted values are extrapolated linearly along the outward normal (Aslam 2004, J.
/// Comput. Phys. 193:349, §2: multidimensional extrapolation), with the smaller of two consecutive slopes (minmod).
/// Each value is a mean over nine points across the normal. The result is limited to the largest value measured within
/// two voxels below the boundary, so that a dense plate over soft bone does not overshoot. If a measured value exceeds
/// the extrapolation by more than three standard deviations of the noise, or no trusted voxel lies below, the scan does
/// not resolve the cortex: then the largest measured value is used, as a lower bound. A corrected value never exceeds a
/// measured one. Voxels outside the bone get values as well, for interpolation and averaging at the boundary.
/// @param hu           the scan, HU; corrected in place
/// @param bone         on the lattice of `hu`; above 0 in bone, including adjacent bone that a cut removed
/// @param psf_mm       full width of the scanner's point spread along each axis of LPS, mm; 0: the voxel spacing
/// @param reach_voxels how far from the bone resampling reads, at least 2
BoundaryDensity correct_boundary(AlignedImage& hu, const BoneField& bone, const Vec3& psf_mm, int reach_voxels);

/// Distance from the bone at which resampling to voxels of `voxel_mm` reads values, image voxels.
int resampling_reach(const Lattice& image, double voxel_mm);

/// Resamples HU and bone to voxels of `settings.voxel_mm`, with a margin of air in whole bricks, and maps HU to grades.
/// Throws InputError: too many voxels for this machine, or voxels so large that no bone remains.
FilledVoxmap voxelize(const AlignedImage& hu, const BoneField& bone, const BoneSettings& settings, Diagnostics& report);

}  // namespace reamsim::ct
