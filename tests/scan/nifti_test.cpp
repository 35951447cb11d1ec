// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Headers of NIfTI files as other programs write them, and as they should not.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "sim/scan/scan.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A transform from indices to RAS in the unit of the file.
struct Form {
  Mat3 steps = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
  int code = 0;
};

/// What a header says. The qform is a rotation, with the spacings of pixdim.
struct Header {
  Vec3 pixdim = Vec3::Ones();
  Form sform, qform;
  double mm = 1;  ///< in the unit of the file
  int version = 1;
  bool big_endian = false;
};

/// Appends a number, in the order of bytes of the header.
template <class T>
void append(std::string& bytes, T value, bool big_endian) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof value);
  if (big_endian) std::ranges::reverse(raw);
  bytes.append(raw.data(), raw.size());
}

/// The bytes of a header with fields set by offset, as nifti1.h and nifti2.h define them.
class HeaderBytes {
 public:
  HeaderBytes(std::size_t size, bool big_endian) : bytes_(size, '\0'), big_endian_(big_endian) {}
  template <class T>
  void set(std::size_t offset, T value) {
    std::string raw;
    append(raw, value, big_endian_);
    bytes_.replace(offset, raw.size(), raw);
  }
  template <class T>
  void set_vector(std::size_t offset, const Vec3& v) {
    for (int n = 0; n < 3; ++n) set(offset + sizeof(T) * static_cast<std::size_t>(n), static_cast<T>(v[n]));
  }
  template <class T>
  void set_rows(std::size_t offset, const Form& form) {
    for (int row = 0; row < 3; ++row) {
      const std::size_t at = offset + 4 * sizeof(T) * static_cast<std::size_t>(row);
      set_vector<T>(at, form.steps.row(row));
      set(at + 3 * sizeof(T), static_cast<T>(form.origin[row]));
    }
  }
  void set_text(std::size_t offset, const std::string& text) { bytes_.replace(offset, text.size(), text); }
  [[nodiscard]] const std::string& text() const { return bytes_; }

 private:
  std::string bytes_;
  bool big_endian_;
};

/// b, c and d of the rotation of a qform, and qfac.
std::pair<Vec3, double> quaternion_of(const Form& qform, const Vec3& pixdim) {
  Mat3 rotation = qform.steps * pixdim.cwiseInverse().asDiagonal();
  const double qfac = rotation.determinant() < 0 ? -1 : 1;
  rotation.col(2) *= qfac;
  const Quat q(rotation);
  return {(q.w() < 0 ? -1 : 1) * q.vec(), qfac};
}

std::string header_bytes(const Header& h, const Vec3i& dims) {
  const auto [quaternion, qfac] = quaternion_of(h.qform, h.pixdim);
  const char unit = h.mm == 1e3 ? 1 : h.mm == 1e-3 ? 3 : 2;
  if (h.version == 1) {
    HeaderBytes out(352, h.big_endian);
    out.set(0, std::int32_t{348});
    out.set(40, std::int16_t{3});
    for (int n = 0; n < 3; ++n) out.set(42 + 2 * static_cast<std::size_t>(n), static_cast<std::int16_t>(dims[n]));
    out.set(70, std::int16_t{4});
    out.set(72, std::int16_t{16});
    out.set(76, static_cast<float>(qfac));
    out.set_vector<float>(80, h.pixdim);
    out.set(108, 352.0F);
    out.set(112, 1.0F);
    out.set(123, unit);
    out.set(252, static_cast<std::int16_t>(h.qform.code));
    out.set(254, static_cast<std::int16_t>(h.sform.code));
    out.set_vector<float>(256, quaternion);
    out.set_vector<float>(268, h.qform.origin);
    out.set_rows<float>(280, h.sform);
    out.set_text(344, "n+1");
    return out.text();
  }
  HeaderBytes out(544, h.big_endian);
  out.set(0, std::int32_t{540});
  out.set_text(4, std::string("n+2\0\r\n\032\n", 8));
  out.set(12, std::int16_t{4});
  out.set(14, std::int16_t{16});
  out.set(16, std::int64_t{3});
  for (int n = 0; n < 3; ++n) out.set(24 + 8 * static_cast<std::size_t>(n), std::int64_t{dims[n]});
  out.set(104, qfac);
  out.set_vector<double>(112, h.pixdim);
  out.set(168, std::int64_t{544});
  out.set(176, 1.0);
  out.set(344, std::int32_t{h.qform.code});
  out.set(348, std::int32_t{h.sform.code});
  out.set_vector<double>(352, quaternion);
  out.set_vector<double>(376, h.qform.origin);
  out.set_rows<double>(400, h.sform);
  out.set(500, std::int32_t{unit});
  return out.text();
}

class Nifti : public ::testing::Test {
 protected:
  /// Writes the egg's voxels with a header; packed by gzip where wanted.
  std::string put(const std::string& name, const Header& header, bool packed = false) {
    std::string bytes = header_bytes(header, egg_.dims);
    for (const double value : egg_.value) append(bytes, static_cast<std::int16_t>(value), header.big_endian);
    const std::string path = folder_.file(name);
    if (packed) {
      gzFile file = gzopen(path.c_str(), "wb");
      gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
      gzclose(file);
    } else {
      std::ofstream(path, std::ios::binary) << bytes;
    }
    return path;
  }

  /// The same voxels as an NRRD in mm, which another reader places.
  std::string put_nrrd(const Form& form, double mm) {
    std::ostringstream out;
    out.precision(17);
    const auto vector = [](const Vec3& v) { return fmt::format("({:.17g},{:.17g},{:.17g})", v.x(), v.y(), v.z()); };
    out << "NRRD0004\ntype: int16\ndimension: 3\nspace: RAS\nsizes: " << egg_.dims.transpose()
        << "\nendian: little\nencoding: raw\nspace directions:";
    for (int axis = 0; axis < 3; ++axis) out << " " << vector(mm * form.steps.col(axis));
    out << "\nspace origin: " << vector(mm * form.origin) << "\n\n";
    std::string bytes = out.str();
    for (const double value : egg_.value) append(bytes, static_cast<std::int16_t>(value), false);
    const std::string path = folder_.file("expected.nrrd");
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  /// The same voxels as a MetaImage, whose axes are LPS.
  std::string put_meta_image(const Mat3& steps, const Vec3& origin) {
    std::ostringstream out;
    out.precision(17);
    const Vec3 spacing = steps.colwise().norm().transpose();
    const Mat3 axes = steps * spacing.cwiseInverse().asDiagonal();
    out << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
        << "TransformMatrix =";
    for (int axis = 0; axis < 3; ++axis) out << " " << axes.col(axis).transpose();
    out << "\nOffset = " << origin.transpose() << "\nElementSpacing = " << spacing.transpose()
        << "\nDimSize = " << egg_.dims.transpose() << "\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    std::string bytes = out.str();
    for (const double value : egg_.value) append(bytes, static_cast<std::int16_t>(value), false);
    const std::string path = folder_.file("expected.mha");
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  FilledVoxmap import(const std::string& path, double voxel_mm = 1) {
    Diagnostics report;
    FilledVoxmap out = voxmap_from_ct(settings_for(path, voxel_mm), report);
    warnings_ = report.warnings;
    return out;
  }

  std::string error_of(const std::string& path) {
    try {
      import(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  /// The place of the egg in RAS.
  [[nodiscard]] Form place(int code) const {
    const Vec3 ras(-1, -1, 1);
    return {ras.asDiagonal() * Mat3(egg_.spacing_mm.asDiagonal()), ras.cwiseProduct(egg_.origin_mm), code};
  }
  /// The same turned about the axis of the body by half a turn.
  [[nodiscard]] Form turned(int code) const {
    Form out = place(code);
    out.steps = Vec3(-1, -1, 1).asDiagonal() * out.steps;
    return out;
  }
  [[nodiscard]] Header header(const Form& sform, const Form& qform) const {
    return {.pixdim = egg_.spacing_mm, .sform = sform, .qform = qform};
  }

  TempFolder folder_;
  TestImage egg_ = egg_image();
  std::vector<std::string> warnings_;
};

TEST_F(Nifti, ScannerComesBeforeTemplateAndSformBeforeQform) {
  const FilledVoxmap right = import(put_nrrd(place(1), 1)), other = import(put_nrrd(turned(1), 1));
  for (const auto& [s_code, q_code, takes_sform] : {std::tuple(1, 1, true),
                                                    {2, 1, true},
                                                    {1, 2, true},
                                                    {1, 4, true},
                                                    {4, 3, true},
                                                    {4, 1, false},
                                                    {5, 2, false},
                                                    {0, 1, false},
                                                    {3, 0, true}}) {
    const std::string path = put("codes.nii", header(place(s_code), turned(q_code)));
    const std::string codes = fmt::format("codes {} and {}", s_code, q_code);
    expect_same(import(path), takes_sform ? right : other, codes);
    if (s_code == 0 || q_code == 0) {
      EXPECT_THAT(warnings_, IsEmpty()) << codes;
    } else {
      ASSERT_THAT(warnings_, SizeIs(1)) << codes;
      EXPECT_THAT(warnings_[0], AllOf(HasSubstr(fmt::format("sform (code {}", s_code)), HasSubstr("differ by up to"),
                                      HasSubstr(takes_sform ? "the sform is taken" : "the qform is taken")));
    }
  }
}

TEST_F(Nifti, FormsThatAgreeAreNotWarnedOf) {
  Header h = header(place(1), place(1));
  h.sform.origin += Vec3::Constant(0.02);  // rounded
  import(put("agree.nii", h));
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(Nifti, ColumnsOfTheSformCountBeforePixdim) {
  Header h = header(place(1), {});
  h.pixdim *= 0.7;
  expect_same(import(put("pixdim.nii", h)), import(put_nrrd(place(1), 1)), "pixdim");
  import(put("pixdim.nii", h));
  ASSERT_THAT(warnings_, SizeIs(1));
  EXPECT_THAT(warnings_[0], AllOf(HasSubstr("pixdim says voxels of 0.7 x 0.7 x 0.875 mm"),
                                  HasSubstr("columns of the sform say 1 x 1 x 1.25 mm")));
}

TEST_F(Nifti, AShearedSformIsResampled) {
  Form tilted = place(1);
  tilted.steps(1, 2) = std::tan(20 * 3.14159265358979 / 180) * egg_.spacing_mm.z();
  const FilledVoxmap expected = import(put_nrrd(tilted, 1));
  expect_same(import(put("sheared.nii", header(tilted, place(1)))), expected, "with a qform");
  EXPECT_THAT(warnings_, ::testing::Contains(HasSubstr("miss right angles by up to 20°")));
  expect_same(import(put("sheared.nii", header(tilted, {}))), expected, "without");
}

TEST_F(Nifti, EveryVersionOrderOfBytesAndNameIsReadByContent) {
  const FilledVoxmap expected = import(put_nrrd(place(1), 1));
  for (const int version : {1, 2}) {
    for (const bool big_endian : {false, true}) {
      for (const bool packed : {false, true}) {
        for (const char* name : {"a.nii", "a.nii.gz", "a.img", "a.dat", "a.nrrd", "a"}) {
          Header h = header(place(1), place(1));
          h.version = version;
          h.big_endian = big_endian;
          expect_same(import(put(name, h, packed)), expected,
                      fmt::format("{} {} {} {}", name, version, big_endian, packed));
          EXPECT_THAT(warnings_, IsEmpty());
        }
      }
    }
  }
  std::filesystem::copy_file(put_nrrd(place(1), 1), folder_.file("nrrd.nii"));
  expect_same(import(folder_.file("nrrd.nii")), expected, "an NRRD");
}

TEST_F(Nifti, HeadersThatPlaceNothingAreRefusedWithTheReason) {
  Header h = header(place(1), place(1));
  h.sform.steps.setZero();
  h.qform.code = 0;
  EXPECT_THAT(error_of(put("zero.nii", h)), HasSubstr("(sform, qform) are not finite, zero or degenerate"));
  h.qform.code = 1;
  expect_same(import(put("qform.nii", h)), import(put_nrrd(place(1), 1)), "the other one");
  import(put("qform.nii", h));
  ASSERT_THAT(warnings_, SizeIs(1));
  EXPECT_THAT(warnings_[0],
              HasSubstr("the sform (code 1, scanner coordinates) of the NIfTI header is not finite, zero"));
  h = header({}, {});
  h.pixdim.setZero();
  EXPECT_THAT(error_of(put("spacing.nii", h)), HasSubstr("pixdim) in the NIfTI header is zero"));
}

/// A random transform: turned, flipped, perhaps sheared.
Form random_form(std::mt19937& random, bool shears, const Vec3& spacing) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> part(-0.3, 0.3);
  Quat q(normal(random), normal(random), normal(random), normal(random));
  q.normalize();
  Form out{q.toRotationMatrix(), 30 * Vec3(normal(random), normal(random), normal(random)), 0};
  if (random() % 4 == 0) out.steps = Mat3::Identity();
  if (random() % 2 == 0) out.steps.col(2) *= -1;
  if (shears) out.steps.col(2) += part(random) * out.steps.col(1) + part(random) * out.steps.col(0);
  out.steps *= spacing.asDiagonal();
  return out;
}

// REAMSIM_CAMPAIGN: number of headers. A reference by another reader from the transform that the rule of docs/inputs.md
// takes.
TEST_F(Nifti, RandomHeadersArePlacedAsTheRuleSays) {
  const char* const wanted = std::getenv("REAMSIM_CAMPAIGN");
  const int runs = wanted == nullptr ? 40 : std::atoi(wanted);
  std::mt19937 random(20261128);
  for (int run = 0; run < runs; ++run) {
    Header h;
    h.version = random() % 4 == 0 ? 2 : 1;
    h.big_endian = random() % 4 == 0;
    h.mm = std::array{1.0, 1.0, 1e3, 1e-3}[random() % 4];
    h.pixdim = egg_.spacing_mm / h.mm;
    const bool same = random() % 3 == 0;
    h.sform = random_form(random, random() % 2 == 0, egg_.spacing_mm * (random() % 4 == 0 ? 1.2 : 1.0));
    h.qform = random_form(random, false, egg_.spacing_mm);
    for (Form* form : {&h.sform, &h.qform}) {
      form->steps /= h.mm;
      form->origin /= h.mm;
      form->code = static_cast<int>(random() % 5);
    }
    if (h.sform.code + h.qform.code == 0) h.sform.code = 1;
    if (same) {
      const int code = h.sform.code;
      h.sform = h.qform;
      h.sform.code = code;
    }
    const auto rank = [](int code) { return code == 0 ? 2 : code > 2 ? 1 : 0; };
    const Form& taken = rank(h.qform.code) < rank(h.sform.code) ? h.qform : h.sform;
    const FilledVoxmap expected = import(put_nrrd(taken, h.mm), 1.5);
    const FilledVoxmap found = import(put("random.nii", h), 1.5);
    const std::string what = fmt::format("header {}, codes {} and {}", run, h.sform.code, h.qform.code);
    EXPECT_NEAR(volume_mm3(found), volume_mm3(expected), 1e-3 * volume_mm3(expected)) << what;
    EXPECT_LT((centroid_mm(found) - centroid_mm(expected)).norm(), 2e-3) << what;
    const bool warned =
        std::ranges::any_of(warnings_, [](const std::string& w) { return w.find("differ by") != std::string::npos; });
    EXPECT_EQ(warned, h.sform.code > 0 && h.qform.code > 0 && !same) << what;
  }
}

// 100 transforms each, of which half are sheared.
TEST_F(Nifti, RandomDirectionsOfNrrdAndMetaImageAreTakenAsTheyStand) {
  std::mt19937 random(20261129);
  const Vec3 lps_from_ras(-1, -1, 1);
  for (int run = 0; run < 100; ++run) {
    const Form form = random_form(random, run % 2 == 0, egg_.spacing_mm);
    const Mat3 steps = lps_from_ras.asDiagonal() * form.steps;
    const Vec3 origin = lps_from_ras.cwiseProduct(form.origin);
    for (const std::string& path : {put_nrrd(form, 1), put_meta_image(steps, origin)}) {
      Diagnostics report;
      CtSettings settings;
      settings.path = path;
      const ct::ScanGeometry found = ct::open_scan(settings, report).geometry;
      EXPECT_LT((found.step_mm - steps).norm(), 1e-6) << path << " " << run;
      EXPECT_LT((found.origin_mm - origin).norm(), 1e-6) << path << " " << run;
    }
  }
}

}  // namespace
}  // namespace reamsim::test
