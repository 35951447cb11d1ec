// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

namespace reamsim {

namespace {

void describe_label_map(KeyVisitor& v, LabelMapSettings& labels) {
  v.key("path", labels.path,
        "NRRD (.seg.nrrd of 3D Slicer, layers included), NIfTI or MetaImage with a label per voxel, on any grid",
        {.required = true, .text = TextKind::input_file});
  v.key("label", labels.label,
        "Label of the bone: a number, or the name of a segment in the file (a to z as A to Z). Several in a list form "
        "one bone");
  v.key("refine_mm", labels.refine_mm,
        "Largest distance over which the surface of the mask moves to the isosurface of refine_hu; 0: no refinement",
        between(0, 5));
  v.key("refine_hu", labels.refine_hu,
        "Radiodensity of the surface with refine_mm; what is denser and has no label is warned of", kHu);
  v.key("fill", labels.fill,
        "Add bone without a label, at or above refine_hu, that the label surrounds or that lies in its holes up to 10 "
        "mm wide, and cavities that it encloses");
}

void describe_hu(KeyVisitor& v, HuSettings& hu) {
  v.key("slope", hu.slope, "HU for each unit of the values", between(0.001, 1000));
  v.key("intercept", hu.intercept, "HU of the value 0", between(-70000, 70000));
}

void describe_cut_sphere(KeyVisitor& v, CutSphereSettings& sphere) {
  v.point("center_mm", sphere.center_mm, "LPS", {.required = true});
  v.key("radius_mm", sphere.radius_mm, "Bone inside the sphere is removed",
        {.required = true, .range = between(0.01, 500)});
}

void describe_cut_plane(KeyVisitor& v, CutPlaneSettings& plane) {
  v.point("point_mm", plane.point_mm, "A point of the plane, LPS", {.required = true});
  v.direction("normal", plane.normal, "Normal of the plane; bone on the side to which it points is removed",
              {.required = true});
}

constexpr std::string_view kLabels = "label_map";

void describe_point_spread(KeyVisitor& v, CtSettings& ct) {
  v.key("psf_mm", ct.psf_mm,
        "Full width of the point spread function (PSF) of the scanner; 0: the voxel spacing along each axis, or of an "
        "oblique scan 1.25 times the extent of its voxel along each axis of LPS",
        between(0, 10));
}

/// What a label map replaces.
void describe_segmentation(KeyVisitor& v, CtSettings& ct) {
  v.key("threshold_hu", ct.threshold_hu, "Least radiodensity of bone", {.range = kHu, .unless = kLabels});
  v.key("closing_mm", ct.closing_mm, "Radius of the closing that bridges gaps in the cortex; 0: none",
        {.range = between(0, 20), .unless = kLabels});
  v.key("fill_holes", ct.fill_holes, "Fill the interior of the cortex, to keep trabecular bone below the threshold",
        {.unless = kLabels});
  v.point("seed_mm", ct.seed_mm, "Point inside the connected piece to keep, LPS; without it the largest piece is kept",
          {.unless = kLabels});
  v.key(
      "separate", ct.separate,
      "humerus: a sphere is fitted to the head of the humerus next to the glenoid (bone.glenoid.near_mm, center_mm or "
      "landmarks), and the bone is cut along the joint gap. Without seed_mm the scapula is the piece behind the gap",
      {.unless = kLabels});
  v.list("cut_spheres", ct.cut_spheres, describe_cut_sphere, "Spheres that separate the bone from its neighbours",
         {.unless = kLabels});
  v.list("cut_planes", ct.cut_planes, describe_cut_plane, "Planes that separate the bone from its neighbours",
         {.unless = kLabels});
}

}  // namespace

void describe_ct(KeyVisitor& v, CtSettings& ct) {
  v.key("path", ct.path, "DICOM folder (searched with its subfolders), DICOMDIR, NRRD, NIfTI or MetaImage",
        {.required = true, .text = TextKind::input_path});
  v.section("hu", ct.hu, describe_hu,
            "HU from the values of a scan that are no HU, after the scale of the file: slope · value + intercept");
  v.key("series", ct.series,
        "DICOM series: UID, or number in the list that a warning gives; without it the CT series with the most slices. "
        "SERIES/2 or SERIES#AcquisitionNumber=1 chooses a volume of a series that holds several",
        {.number_too = true});
  v.key("modality", ct.modality, "Accepted DICOM modality; any: also series that are not CT");
  v.key("uneven", ct.uneven,
        "DICOM slices whose spacing changes, or that are missing; resample: interpolated at the finest spacing, with a "
        "warning");
  v.key("crop_min_mm", ct.crop_min_mm, "Lower corner of the crop, LPS; with crop_max_mm",
        {.range = between(-10000, 9990), .point = true});
  v.key("crop_max_mm", ct.crop_max_mm, "Upper corner of the crop, LPS; with crop_min_mm",
        {.range = between(-9990, 10000), .point = true});
  v.key("filter", ct.filter, "Noise filter before thresholding");
  v.key("median_radius_voxels", ct.median_radius_voxels, "Used by `filter: median` only", between(1, 10));
  v.key("anisotropic_iterations", ct.anisotropic_iterations, "Used by `filter: curvature_anisotropic` only",
        between(1, 100));
  v.key("anisotropic_conductance", ct.anisotropic_conductance, "Used by `filter: curvature_anisotropic` only",
        between(0.01, 100));
  v.section(kLabels, ct.label_map, describe_label_map, "Instead of threshold, closing, filling, seed and cuts");
  describe_point_spread(v, ct);
  describe_segmentation(v, ct);
}

}  // namespace reamsim
