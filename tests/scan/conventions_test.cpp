// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <regex>
#include <sstream>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Fields of a NIfTI-1 header: offset in bytes, from its definition.
constexpr std::size_t kPixdim = 80, kScale = 112, kUnits = 123, kCodes = 252, kOrigin = 268, kRows = 280;

template <typename Value>
Value get_at(const std::string& bytes, std::size_t offset) {
  Value value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <typename Value>
void put_at(std::string& bytes, std::size_t offset, Value value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// What a file says of axes, units and scale, in headers that ITK does not write itself.
class Conventions : public ::testing::Test {
 protected:
  void SetUp() override {
    write_image<std::int16_t>(egg_, folder_.file("reference.nrrd"));
    write_image<std::int16_t>(egg_, folder_.file("reference.nii"));
    reference_ = import(folder_.file("reference.nrrd"));
    ASSERT_THAT(warnings_, IsEmpty());
    ASSERT_GT(volume_mm3(reference_), 3000);
  }

  FilledVoxmap import(const std::string& path, const Vec3& crop_max_mm = Vec3::Constant(1e6)) {
    Diagnostics report;
    BoneSettings settings = settings_for(path, 1);
    settings.ct.crop_max_mm = crop_max_mm;
    FilledVoxmap out = voxmap_from_ct(settings, report);
    warnings_ = report.warnings;
    return out;
  }

  /// Writes the image as an NRRD whose space has the axes of LPS times `signs`; a space with time has a fourth axis.
  std::string nrrd(const std::string& name, const std::string& space, const Vec3& signs) {
    const bool time = space.ends_with("time") || space.ends_with("ST");
    const auto vector = [&](const Vec3& v) {
      return fmt::format("({},{},{}{})", v.x(), v.y(), v.z(), time ? ",0" : "");
    };
    std::ostringstream out;
    out << "NRRD0004\ntype: int16\ndimension: " << (time ? 4 : 3) << "\n" << space << "\nsizes: ";
    out << egg_.dims.transpose() << (time ? " 1" : "") << "\nendian: little\nencoding: raw\nspace directions:";
    for (int axis = 0; axis < 3; ++axis) {
      out << " " << vector(signs.cwiseProduct(egg_.direction.col(axis)) * egg_.spacing_mm[axis]);
    }
    out << (time ? " (0,0,0,1)" : "") << "\nspace origin: " << vector(signs.cwiseProduct(egg_.origin_mm)) << "\n\n";
    for (const double value : egg_.value) {
      const auto stored = static_cast<std::int16_t>(value);
      out.write(reinterpret_cast<const char*>(&stored), sizeof stored);
    }
    const std::string path = folder_.file(name);
    std::ofstream(path, std::ios::binary) << out.str();
    return path;
  }

  /// Writes reference.nii with another header.
  template <typename Change>
  std::string nifti(const std::string& name, const Change& change) {
    std::string bytes = bytes_of(folder_.file("reference.nii"));
    change(bytes);
    const std::string path = folder_.file(name);
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }

  /// Writes a MetaImage again without its size of compressed data.
  void without_size(const std::string& from, const std::string& to) {
    std::string text = bytes_of(folder_.file(from));
    const std::size_t line = text.find("CompressedDataSize");
    ASSERT_NE(line, std::string::npos);
    text.erase(line, text.find('\n', line) + 1 - line);
    std::ofstream(folder_.file(to), std::ios::binary) << text;
  }

  TempFolder folder_;
  TestImage egg_ = egg_image();
  FilledVoxmap reference_;
  std::vector<std::string> warnings_;
};

TEST_F(Conventions, EveryAnatomicalSpaceOfNrrdGivesTheSameVoxmap) {
  const std::pair<const char*, Vec3> spaces[] = {{"left-posterior-superior", {1, 1, 1}},
                                                 {"LPS", {1, 1, 1}},
                                                 {"left-posterior-superior-time", {1, 1, 1}},
                                                 {"right-anterior-superior", {-1, -1, 1}},
                                                 {"RAS", {-1, -1, 1}},
                                                 {"right-anterior-superior-time", {-1, -1, 1}},
                                                 {"RAST", {-1, -1, 1}},
                                                 {"left-anterior-superior", {1, -1, 1}},
                                                 {"LAS", {1, -1, 1}},
                                                 {"left-anterior-superior-time", {1, -1, 1}},
                                                 {"LAST", {1, -1, 1}}};
  for (const auto& [space, signs] : spaces) {
    expect_same(import(nrrd("space.nrrd", std::string("space: ") + space, signs)), reference_, space);
    EXPECT_THAT(warnings_, IsEmpty()) << space;
  }
}

TEST_F(Conventions, FieldsOfNrrdAreFoundAsTheyAreWritten) {
  const std::string long_text(70'000, 'x');
  for (const std::string& fields : {std::string("Space: left-anterior-superior"), std::string("SPACE: LAS"),
                                    std::string("space:=left-posterior-superior\nspace: LAS"),
                                    std::string("# space: LPS\nspace: LAS"), "note:=" + long_text + "\nspace: LAS"}) {
    const std::string label = fields.substr(0, 60);
    expect_same(import(nrrd("space.nrrd", fields, {1, -1, 1})), reference_, label);
    EXPECT_THAT(warnings_, IsEmpty()) << label;
  }
}

TEST_F(Conventions, ANrrdWithoutAnatomicalSpaceIsReadAsLpsWithAWarning) {
  for (const char* space : {"space dimension: 3", "space: scanner-xyz", "space: 3D-right-handed"}) {
    const std::string path = nrrd("space.nrrd", space, Vec3::Ones());
    expect_same(import(path), reference_, space);
    ASSERT_THAT(warnings_, SizeIs(1)) << space;
    EXPECT_THAT(warnings_[0], HasSubstr(path + ": the header does not say how the axes lie in the body"));
  }
}

TEST_F(Conventions, ANiftiWithoutQformAndSformIsWarnedOf) {
  const std::string path = nifti("codes.nii", [](std::string& bytes) { put_at(bytes, kCodes, std::int32_t{0}); });
  EXPECT_NEAR(volume_mm3(import(path)), volume_mm3(reference_), 0.02 * volume_mm3(reference_));
  ASSERT_THAT(warnings_, SizeIs(1));
  EXPECT_THAT(warnings_[0], HasSubstr("the header does not say how the axes lie in the body"));
  for (const std::size_t code : {kCodes, kCodes + 2}) {  // one of both is enough
    expect_same(import(nifti("code.nii", [&](std::string& bytes) { put_at(bytes, code, std::int16_t{0}); })),
                reference_, "one code");
    EXPECT_THAT(warnings_, IsEmpty());
  }
}

TEST_F(Conventions, UnitsOfNrrdCountForSpacingAndOrigin) {
  const std::pair<const char*, double> units[] = {
      {"m", 1e3},          {"cm", 10},   {"mm", 1},        {"um", 1e-3},      {"\xC2\xB5m", 1e-3},  {"CM", 10},
      {"centimetres", 10}, {"in", 25.4}, {"Inches", 25.4}, {"Millimetre", 1}, {"micrometers", 1e-3}};
  const TestImage in_mm = egg_;
  for (const auto& [unit, mm] : units) {
    egg_.spacing_mm = in_mm.spacing_mm / mm;
    egg_.origin_mm = in_mm.origin_mm / mm;
    const std::string lines = fmt::format("space: RAS\nspace units: \"{0}\" \"{0}\" \"{0}\"", unit);
    expect_same(import(nrrd("units.nrrd", lines, {-1, -1, 1})), reference_, unit);
    EXPECT_THAT(warnings_, IsEmpty()) << unit;
  }
}

TEST_F(Conventions, AnUnknownUnitOfNrrdIsTakenAsMillimetresWithAWarning) {
  const std::string path = nrrd("units.nrrd", "space: LPS\nspace units: \"mm\" \"furlong\" \"mm\"", Vec3::Ones());
  expect_same(import(path), reference_, "furlong");
  ASSERT_THAT(warnings_, SizeIs(1));
  EXPECT_THAT(warnings_[0], HasSubstr(path + ": lengths are in \"furlong\", an unknown unit; mm are assumed"));
}

TEST_F(Conventions, ANrrdThatNamesASpaceWithoutDirectionsIsWarnedOf) {
  egg_.direction = Mat3::Identity();
  std::string bytes = bytes_of(nrrd("named.nrrd", "space: left-anterior-superior", Vec3::Ones()));
  const std::size_t first = bytes.find("space directions"), end = bytes.find("\n\n", first);
  bytes.erase(first - 1, end - first + 1);
  std::ofstream(folder_.file("named.nrrd"), std::ios::binary) << bytes;
  import(folder_.file("named.nrrd"));
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("does not say how the axes lie")));
}

TEST_F(Conventions, UnitsOfTheAxesOfNrrdCountForSpacings) {
  const Vec3 spacing = egg_.spacing_mm;
  egg_.direction = Mat3::Identity();
  egg_.origin_mm = Vec3::Zero();
  const auto spaced = [&](const std::string& fields, double mm) {
    std::string bytes = bytes_of(nrrd("directions.nrrd", "content: x", Vec3::Ones()));
    const std::size_t first = bytes.find("space directions"), end = bytes.find("\n\n", first);
    const Vec3 s = spacing / mm;
    bytes.replace(first, end - first, fmt::format("spacings: {} {} {}\n{}", s.x(), s.y(), s.z(), fields));
    return bytes;
  };
  const auto import_bytes = [&](const std::string& bytes) {
    std::ofstream(folder_.file("spaced.nrrd"), std::ios::binary) << bytes;
    return import(folder_.file("spaced.nrrd"));
  };
  const FilledVoxmap in_mm = import_bytes(spaced("units: \"mm\" \"\" \"mm\"", 1));
  ASSERT_GT(volume_mm3(in_mm), 3000);
  expect_same(import_bytes(spaced("units: \"cm\" \"cm\" \"CM\"", 10)), in_mm, "cm");
  EXPECT_THAT(warnings_, SizeIs(1)) << "of the orientation";
  std::string layers = spaced("kinds: list domain domain domain\nunits: \"\" \"m\" \"m\" \"m\"", 1e3);
  for (const auto& [from, to] :
       {std::pair{"dimension: 3", "dimension: 4"}, {"sizes: ", "sizes: 1 "}, {"spacings: ", "spacings: nan "}}) {
    layers.replace(layers.find(from), std::strlen(from), to);
  }
  expect_same(import_bytes(layers), in_mm, "the first axis is none of the space");
}

TEST_F(Conventions, UnitsOfNiftiCountForSpacingAndOrigin) {
  // NIFTI_UNITS_METER, NIFTI_UNITS_MICRON, NIFTI_UNITS_UNKNOWN.
  const std::pair<char, double> units[] = {{1, 1e3}, {3, 1e-3}, {0, 1}};
  for (const auto& unit : units) {
    const auto code = unit.first;  // clang 14 captures no structured binding
    const auto mm = unit.second;
    const std::string path = nifti("units.nii", [&](std::string& bytes) {
      bytes[kUnits] = code;
      for (const auto& [first, count] : {std::pair{kPixdim, 3}, {kOrigin, 3}, {kRows, 12}}) {
        for (int n = 0; n < count; ++n) {
          const std::size_t at = first + sizeof(float) * static_cast<std::size_t>(n);
          put_at(bytes, at, static_cast<float>(get_at<float>(bytes, at) / mm));
        }
      }
    });
    const FilledVoxmap found = import(path);
    EXPECT_NEAR(volume_mm3(found), volume_mm3(reference_), 1e-3 * volume_mm3(reference_)) << int{code};
    EXPECT_LT((centroid_mm(found) - centroid_mm(reference_)).norm(), 1e-3) << int{code};
  }
}

TEST_F(Conventions, ANiftiWithASlopeOfZeroIsNotScaled) {
  const auto scaled = [](float slope, float offset) {
    return [=](std::string& bytes) {
      put_at(bytes, kScale, slope);
      put_at(bytes, kScale + sizeof slope, offset);
    };
  };
  expect_same(import(nifti("zero.nii", scaled(0, -1024))), reference_, "slope 0");
  Diagnostics report;
  BoneSettings settings = settings_for(nifti("scaled.nii", scaled(2, -100)), 1);
  settings.ct.threshold_hu = 2 * 200 - 100;
  EXPECT_NEAR(volume_mm3(voxmap_from_ct(settings, report)), volume_mm3(reference_), 1e-6);
}

TEST_F(Conventions, AnyCropOfACompressedMetaImageIsTheSame) {
  write_image<std::int16_t>(egg_, folder_.file("packed.mha"), true);
  write_image<std::int16_t>(egg_, folder_.file("packed.mhd"), true);
  without_size("packed.mhd", "unsized.mhd");
  const Vec3 middle = centroid_mm(reference_);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 crop = Vec3::Constant(1e6);
    crop[axis] = middle[axis] + 1;
    const FilledVoxmap part = import(folder_.file("reference.nrrd"), crop);
    ASSERT_LT(volume_mm3(part), 0.8 * volume_mm3(reference_));
    for (const char* name : {"packed.mha", "packed.mhd", "unsized.mhd"}) {
      expect_same(import(folder_.file(name), crop), part,
                  name + std::string(" cut along axis ") + std::to_string(axis));
    }
  }
}

TEST_F(Conventions, CompressedVoxelsBehindAHeaderNeedTheirSize) {
  write_image<std::int16_t>(egg_, folder_.file("packed.mha"), true);
  without_size("packed.mha", "unsized.mha");
  std::string header = bytes_of(folder_.file("unsized.mha"));
  const std::size_t voxels = header.find("LOCAL\n") + 6;
  const std::string packed = header.substr(voxels);
  header.resize(voxels);
  const std::string windows = std::regex_replace(header, std::regex("\n"), "\r\n");
  std::ofstream(folder_.file("windows.mha"), std::ios::binary) << windows << packed;
  for (const char* name : {"unsized.mha", "windows.mha"}) {
    try {
      import(folder_.file(name));
      ADD_FAILURE() << name << " accepted";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("the MetaImage header has no CompressedDataSize")) << name;
    }
  }
}

}  // namespace
}  // namespace reamsim::test
