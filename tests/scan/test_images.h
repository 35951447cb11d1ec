// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim::test {

/// A fresh folder that goes away with the object.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// An image to be written: voxel (i,j,k) has its centre at origin + direction·diag(spacing)·(i,j,k) in LPS mm.
struct TestImage {
  Vec3i dims = Vec3i::Ones();
  Vec3 spacing_mm = Vec3::Ones();
  Vec3 origin_mm = Vec3::Zero();
  Mat3 direction = Mat3::Identity();
  std::vector<double> value;

  [[nodiscard]] Vec3 point_mm(int i, int j, int k) const {
    return origin_mm + direction * spacing_mm.cwiseProduct(Vec3(i, j, k));
  }
  /// Takes the values of a function of the point in LPS mm.
  void sample(const std::function<double(const Vec3&)>& function);
};

/// The same voxels in the same places, stored with LPS axis axes[n] as the n-th image axis, reversed where flip[n].
TestImage reordered(const TestImage& image, const std::array<int, 3>& axes, const std::array<bool, 3>& flip);

/// Writes by the ending of the name: .nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd. Value is a C++ arithmetic type.
template <typename Value>
void write_image(const TestImage& image, const std::string& path, bool compressed = false);

/// What DICOM files say beside their pixels.
struct DicomTags {
  std::string series = "1.2.3.4.5.6";
  int number = 1;
  std::string description{};
  std::string kernel{};
  std::string modality = "CT";
  std::string ending = ".dcm";                ///< of the files' names
  std::map<std::string, std::string> more{};  ///< text elements by "GGGG|EEEE", which replace those of every file
};

/// Writes one DICOM file per slice (int16), file names in the reverse order of the slices. A `skip`ped slice is left
/// out.
void write_dicom(const TestImage& image, const std::string& folder, int skip = -1, const DicomTags& tags = {});

/// Replaces every occurrence of a text in a file by one as long.
void patch_file(const std::string& path, const std::string& from, const std::string& to);

/// Writes an NRRD of unsigned bytes by hand, with one byte per layer in each voxel and more header lines, as 3D Slicer
/// writes .seg.nrrd. One layer: three axes.
void write_seg_nrrd(const std::vector<TestImage>& layers, const std::string& path, const std::string& header_lines);

/// The voxels of a box of an image: from `start`, `size` along each axis.
TestImage cropped(const TestImage& image, const Vec3i& start, const Vec3i& size);

/// Settings that read `path` with voxels of `voxel_mm` at threshold 200 HU, without closing.
BoneSettings settings_for(const std::string& path, double voxel_mm);

/// Whether two voxmaps have the same lattice (to 1e-6 mm) and the same grades.
void expect_same(const Voxmap& a, const Voxmap& b, const std::string& what);

/// Bone volume, mm³, and centroid, mm.
double volume_mm3(const Voxmap& voxmap);
Vec3 centroid_mm(const FilledVoxmap& voxmap);

/// HU that a voxel's density stands for, at the voxel of a point.
std::uint8_t grade_at(const Voxmap& voxmap, const Vec3& point_mm);

/// An egg with a dense shell (250) and an inside (100) below the threshold, with a knob that breaks every symmetry.
double knobbed_egg(const Vec3& point_mm);
/// An image of it in which it lies whole: 26×30×24 voxels of 1×1×1.25 mm.
TestImage egg_image();

}  // namespace reamsim::test
