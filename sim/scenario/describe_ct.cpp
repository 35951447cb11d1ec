// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/describe_sections.h"

namespace reamsim {

namespace {

void describe_label_map(KeyVisitor& v, LabelMapSettings& labels) {
  v.text(
      {.name = "path",
       .doc = "NRRD (.seg.nrrd of 3D Slicer, layers included), NIfTI or MetaImage with a label per voxel, on any grid",
       .required = true,
       .text = TextKind::input_file},
      labels.path);
  v.names({.name = "label",
           .doc = "Label of the bone: a number, or the name of a segment in the file (a to z as A to Z). Several in a "
                  "list form one bone"},
          labels.label);
  v.number(
      {.name = "refine_mm",
       .doc =
           "Largest distance over which the surface of the mask moves to the isosurface of refine_hu; 0: no refinement",
       .range = between(0, 5)},
      labels.refine_mm);
  v.number({.name = "refine_hu",
            .doc = "Radiodensity of the surface with refine_mm; what is denser and has no label is warned of",
            .range = kHu},
           labels.refine_hu);
  v.flag(
      {.name = "fill",
       .doc =
           "Add bone without a label, at or above refine_hu, that the label surrounds or that lies in its holes up to "
           "10 mm wide, and cavities that it encloses"},
      labels.fill);
}

void describe_hu(KeyVisitor& v, HuSettings& hu) {
  v.number({.name = "slope", .doc = "HU for each unit of the values", .range = between(0.001, 1000)}, hu.slope);
  v.number({.name = "intercept", .doc = "HU of the value 0", .range = between(-70000, 70000)}, hu.intercept);
}

void describe_cut_sphere(KeyVisitor& v, CutSphereSettings& sphere) {
  v.vector({.name = "center_mm", .doc = "LPS", .required = true, .range = kPosition, .point = true}, sphere.center_mm);
  v.number(
      {.name = "radius_mm", .doc = "Bone inside the sphere is removed", .required = true, .range = between(0.01, 500)},
      sphere.radius_mm);
}

void describe_cut_plane(KeyVisitor& v, CutPlaneSettings& plane) {
  v.vector(
      {.name = "point_mm", .doc = "A point of the plane, LPS", .required = true, .range = kPosition, .point = true},
      plane.point_mm);
  v.vector({.name = "normal",
            .doc = "Normal of the plane; bone on the side to which it points is removed",
            .required = true,
            .range = kComponent,
            .nonzero = true},
           plane.normal);
}

constexpr std::string_view kLabels = "label_map";

void describe_point_spread(KeyVisitor& v, CtSettings& ct) {
  v.number(
      {.name = "psf_mm",
       .doc =
           "Full width of the point spread function (PSF) of the scanner; 0: the voxel spacing along each axis, or of "
           "an oblique scan 1.25 times the extent of its voxel along each axis of LPS",
       .range = between(0, 10)},
      ct.psf_mm);
}

/// What a label map replaces.
void describe_segmentation(KeyVisitor& v, CtSettings& ct) {
  v.number({.name = "threshold_hu", .doc = "Least radiodensity of bone", .range = kHu, .unless = kLabels},
           ct.threshold_hu);
  v.number({.name = "closing_mm",
            .doc = "Radius of the closing that bridges gaps in the cortex; 0: none",
            .range = between(0, 20),
            .unless = kLabels},
           ct.closing_mm);
  v.flag({.name = "fill_holes",
          .doc = "Fill the interior of the cortex, to keep trabecular bone below the threshold",
          .unless = kLabels},
         ct.fill_holes);
  v.optional_vector({.name = "seed_mm",
                     .doc = "Point inside the connected piece to keep, LPS; without it the largest piece is kept",
                     .range = kPosition,
                     .point = true,
                     .unless = kLabels},
                    ct.seed_mm);
  v.choice(
      {.name = "separate",
       .doc = "humerus: a sphere is fitted to the head of the humerus next to the glenoid (bone.glenoid.near_mm, "
              "center_mm or landmarks), and the bone is cut along the joint gap. Without seed_mm the scapula is the "
              "piece behind the gap",
       .unless = kLabels},
      ct.separate);
  v.list({.name = "cut_spheres", .doc = "Spheres that separate the bone from its neighbours", .unless = kLabels},
         ct.cut_spheres, describe_cut_sphere);
  v.list({.name = "cut_planes", .doc = "Planes that separate the bone from its neighbours", .unless = kLabels},
         ct.cut_planes, describe_cut_plane);
}

}  // namespace

void describe_ct(KeyVisitor& v, CtSettings& ct) {
  v.text({.name = "path",
          .doc = "DICOM folder (searched with its subfolders), DICOMDIR, NRRD, NIfTI or MetaImage",
          .required = true,
          .text = TextKind::input_path},
         ct.path);
  v.optional_section(
      {.name = "hu",
       .doc = "HU from the values of a scan that are no HU, after the scale of the file: slope · value + "
              "intercept"},
      ct.hu, describe_hu);
  v.text({.name = "series",
          .doc = "DICOM series: UID, or number in the list that a warning gives; without it the CT series with the "
                 "most slices. SERIES/2 or SERIES#AcquisitionNumber=1 chooses a volume of a series that holds several",
          .number_too = true},
         ct.series);
  v.choice({.name = "modality", .doc = "Accepted DICOM modality; any: also series that are not CT"}, ct.modality);
  v.choice({.name = "uneven",
            .doc = "DICOM slices whose spacing changes, or that are missing; resample: interpolated at the finest "
                   "spacing, with a warning"},
           ct.uneven);
  v.optional_vector({.name = "crop_min_mm",
                     .doc = "Lower corner of the crop, LPS; with crop_max_mm",
                     .range = between(-10000, 9990),
                     .point = true},
                    ct.crop_min_mm);
  v.optional_vector({.name = "crop_max_mm",
                     .doc = "Upper corner of the crop, LPS; with crop_min_mm",
                     .range = between(-9990, 10000),
                     .point = true},
                    ct.crop_max_mm);
  v.choice({.name = "filter", .doc = "Noise filter before thresholding"}, ct.filter);
  v.integer({.name = "median_radius_voxels", .doc = "Used by `filter: median` only", .range = between(1, 10)},
            ct.median_radius_voxels);
  v.integer({.name = "anisotropic_iterations",
             .doc = "Used by `filter: curvature_anisotropic` only",
             .range = between(1, 100)},
            ct.anisotropic_iterations);
  v.number({.name = "anisotropic_conductance",
            .doc = "Used by `filter: curvature_anisotropic` only",
            .range = between(0.01, 100)},
           ct.anisotropic_conductance);
  v.optional_section({.name = kLabels, .doc = "Instead of threshold, closing, filling, seed and cuts"}, ct.label_map,
                     describe_label_map);
  describe_point_spread(v, ct);
  describe_segmentation(v, ct);
}

}  // namespace reamsim
