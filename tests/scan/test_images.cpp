// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "test_images.h"

#include <gtest/gtest.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace reamsim::test {

namespace fs = std::filesystem;

namespace {

itk::ImageIOBase::Pointer io_for(const std::string& path) {
  if (path.ends_with(".nrrd") || path.ends_with(".nhdr")) return itk::NrrdImageIO::New().GetPointer();
  if (path.ends_with(".nii") || path.ends_with(".nii.gz")) return itk::NiftiImageIO::New().GetPointer();
  if (path.ends_with(".mha") || path.ends_with(".mhd")) return itk::MetaImageIO::New().GetPointer();
  if (path.ends_with(".dcm")) return itk::GDCMImageIO::New().GetPointer();
  throw std::invalid_argument(path);
}

/// Writes through the format's own writer, so that no factory is needed.
template <typename Value>
void write(const TestImage& image, itk::ImageIOBase& io, const std::string& path, bool compressed) {
  io.SetFileName(path);
  io.SetNumberOfDimensions(3);
  itk::ImageIORegion region(3);
  for (unsigned axis = 0; axis < 3; ++axis) {
    io.SetDimensions(axis, static_cast<itk::SizeValueType>(image.dims[axis]));
    io.SetSpacing(axis, image.spacing_mm[axis]);
    io.SetOrigin(axis, image.origin_mm[axis]);
    const Vec3 direction = image.direction.col(axis);
    io.SetDirection(axis, std::vector<double>(direction.data(), direction.data() + 3));
    region.SetSize(axis, static_cast<itk::SizeValueType>(image.dims[axis]));
  }
  io.SetNumberOfComponents(1);
  io.SetPixelType(itk::IOPixelEnum::SCALAR);
  io.SetComponentType(itk::ImageIOBase::MapPixelType<Value>::CType);
  io.SetUseCompression(compressed);
  io.SetIORegion(region);
  std::vector<Value> values(image.value.size());
  std::transform(image.value.begin(), image.value.end(), values.begin(),
                 [](double value) { return static_cast<Value>(value); });
  io.WriteImageInformation();
  io.Write(values.data());
}

}  // namespace

TempFolder::TempFolder() {
  std::string name = (fs::temp_directory_path() / "reamsim_ct_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void TestImage::sample(const std::function<double(const Vec3&)>& function) {
  value.clear();
  for (int k = 0; k < dims.z(); ++k) {
    for (int j = 0; j < dims.y(); ++j) {
      for (int i = 0; i < dims.x(); ++i) value.push_back(function(point_mm(i, j, k)));
    }
  }
}

TestImage reordered(const TestImage& image, const std::array<int, 3>& axes, const std::array<bool, 3>& flip) {
  TestImage out;
  out.origin_mm = image.origin_mm;
  for (int n = 0; n < 3; ++n) {
    const int from = axes[n];
    out.dims[n] = image.dims[from];
    out.spacing_mm[n] = image.spacing_mm[from];
    out.direction.col(n) = image.direction.col(from) * (flip[n] ? -1 : 1);
    if (flip[n]) out.origin_mm += image.direction.col(from) * image.spacing_mm[from] * (image.dims[from] - 1);
  }
  for (int k = 0; k < out.dims.z(); ++k) {
    for (int j = 0; j < out.dims.y(); ++j) {
      for (int i = 0; i < out.dims.x(); ++i) {
        const Vec3i index(i, j, k);
        Vec3i from;
        for (int n = 0; n < 3; ++n) from[axes[n]] = flip[n] ? out.dims[n] - 1 - index[n] : index[n];
        out.value.push_back(
            image.value[static_cast<std::size_t>(from.x() + image.dims.x() * (from.y() + image.dims.y() * from.z()))]);
      }
    }
  }
  return out;
}

template <typename Value>
void write_image(const TestImage& image, const std::string& path, bool compressed) {
  write<Value>(image, *io_for(path), path, compressed);
}

template void write_image<std::uint8_t>(const TestImage&, const std::string&, bool);
template void write_image<std::int8_t>(const TestImage&, const std::string&, bool);
template void write_image<std::int16_t>(const TestImage&, const std::string&, bool);
template void write_image<std::uint16_t>(const TestImage&, const std::string&, bool);
template void write_image<std::int32_t>(const TestImage&, const std::string&, bool);
template void write_image<std::uint32_t>(const TestImage&, const std::string&, bool);
template void write_image<float>(const TestImage&, const std::string&, bool);
template void write_image<double>(const TestImage&, const std::string&, bool);

void write_dicom(const TestImage& image, const std::string& folder, int skip, const DicomTags& tags) {
  fs::create_directories(folder);
  for (int k = 0; k < image.dims.z(); ++k) {
    if (k == skip) continue;
    TestImage slice = image;
    slice.dims.z() = 1;
    slice.origin_mm = image.point_mm(0, 0, k);
    const std::int64_t size = std::int64_t{1} * image.dims.x() * image.dims.y();
    slice.value.assign(image.value.begin() + k * size, image.value.begin() + (k + 1) * size);
    const auto io = itk::GDCMImageIO::New();
    io->KeepOriginalUIDOn();
    itk::MetaDataDictionary& dictionary = io->GetMetaDataDictionary();
    const auto put = [&](const char* tag, const std::string& text) {
      if (!text.empty()) itk::EncapsulateMetaData<std::string>(dictionary, tag, text);
    };
    put("0008|0060", tags.modality);
    put("0008|103e", tags.description);
    put("0018|1210", tags.kernel);
    put("0020|0011", std::to_string(tags.number));
    put("0008|0016", "1.2.840.10008.5.1.4.1.1.2");  // CT image storage
    put("0020|000d", "1.2.3.4.5");                  // study
    put("0020|000e", tags.series);
    put("0020|0052", "1.2.3.4.5.7");  // frame of reference
    put("0020|0013", std::to_string(k + 1));
    put("0028|0004", "MONOCHROME2");
    for (const auto& [tag, text] : tags.more) put(tag.c_str(), text);
    char name[32];
    std::snprintf(name, sizeof name, "/slice%03d", image.dims.z() - k);
    write<std::int16_t>(slice, *io, folder + name + ".dcm", false);
    if (tags.ending != ".dcm") fs::rename(folder + name + ".dcm", folder + name + tags.ending);
  }
}

void patch_file(const std::string& path, const std::string& from, const std::string& to) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  ASSERT_EQ(from.size(), to.size());
  ASSERT_NE(bytes.find(from), std::string::npos) << path;
  for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1)) {
    bytes.replace(at, to.size(), to);
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

void write_seg_nrrd(const std::vector<TestImage>& layers, const std::string& path, const std::string& header_lines) {
  const TestImage& first = layers.front();
  const bool layered = layers.size() > 1;
  std::ostringstream out;
  out.precision(17);
  const auto put = [&out](const Vec3& v) { out << " (" << v.x() << "," << v.y() << "," << v.z() << ")"; };
  out << "NRRD0004\ntype: unsigned char\ndimension: " << (layered ? 4 : 3)
      << "\nspace: left-posterior-superior\nsizes:";
  if (layered) out << " " << layers.size();
  out << " " << first.dims.x() << " " << first.dims.y() << " " << first.dims.z() << "\nspace directions:";
  if (layered) out << " none";
  for (int axis = 0; axis < 3; ++axis) put(first.direction.col(axis) * first.spacing_mm[axis]);
  out << "\nkinds:" << (layered ? " list" : "") << " domain domain domain\nencoding: raw\nspace origin:";
  put(first.origin_mm);
  out << "\n" << header_lines << "\n";
  for (std::size_t n = 0; n < first.value.size(); ++n) {
    for (const TestImage& layer : layers) out.put(static_cast<char>(layer.value[n]));
  }
  std::ofstream(path, std::ios::binary) << out.str();
}

TestImage cropped(const TestImage& image, const Vec3i& start, const Vec3i& size) {
  TestImage out = image;
  out.dims = size;
  out.origin_mm = image.point_mm(start.x(), start.y(), start.z());
  out.value.clear();
  for (int k = 0; k < size.z(); ++k) {
    for (int j = 0; j < size.y(); ++j) {
      for (int i = 0; i < size.x(); ++i) {
        const Vec3i c = start + Vec3i(i, j, k);
        out.value.push_back(
            image.value[static_cast<std::size_t>(c.x() + image.dims.x() * (c.y() + image.dims.y() * c.z()))]);
      }
    }
  }
  return out;
}

BoneSettings settings_for(const std::string& path, double voxel_mm) {
  BoneSettings settings;
  settings.source = BoneSource::ct;
  settings.voxel_mm = voxel_mm;
  settings.ct.path = path;
  settings.ct.threshold_hu = 200;
  settings.ct.closing_mm = 0;
  return settings;
}

void expect_same(const Voxmap& a, const Voxmap& b, const std::string& what) {
  EXPECT_EQ(a.grid.dims, b.grid.dims) << what;
  EXPECT_EQ(a.grid.voxel_mm, b.grid.voxel_mm) << what;
  EXPECT_LT((a.grid.origin_mm - b.grid.origin_mm).norm(), 1e-5) << what;
  EXPECT_TRUE(a.grade == b.grade) << what;
  EXPECT_EQ(a.frame, b.frame) << what;
}

double volume_mm3(const Voxmap& voxmap) {
  return static_cast<double>(voxmap.grade.count()) * voxmap.grid.voxel_mm3();
}

Vec3 centroid_mm(const FilledVoxmap& voxmap) {
  Vec3 sum = Vec3::Zero();
  std::int64_t count = 0;
  for_each_bone_voxel(voxmap, [&](const Vec3i& c, std::uint8_t, std::uint16_t) {
    sum += voxmap.grid.center_mm(c);
    ++count;
  });
  return sum / static_cast<double>(count);
}

std::uint8_t grade_at(const Voxmap& voxmap, const Vec3& point_mm) {
  const Vec3i c = voxmap.grid.voxel_of(point_mm);
  if (!voxmap.grid.contains(c)) return 0;
  return voxmap.grade.get(c);
}

double knobbed_egg(const Vec3& p) {
  const Vec3 centre(-20, 35, 110);
  const Vec3 q = p - centre;
  const double egg = q.cwiseQuotient(Vec3(9, 11, 10)).norm();
  const double knob = (q - Vec3(5, 7, 6)).norm();
  if (egg > 1 && knob > 3.5) return 0;
  return egg < 0.6 ? 100 : 250;
}

TestImage egg_image() {
  TestImage image;
  image.dims = {26, 30, 24};
  image.spacing_mm = {1, 1, 1.25};
  image.origin_mm = {-32.5, 20.25, 96};
  image.sample(knobbed_egg);
  return image;
}

}  // namespace reamsim::test
