// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {

/// DICOM as clinics export it.
class Dicom : public ::testing::Test {
 protected:
  void SetUp() override {
    write_image<std::int16_t>(egg_, folder_.file("reference.nrrd"));
    reference_ = import("reference.nrrd");
    report_ = {};
  }

  /// Reads a file or folder of the test; report_ has its messages alone.
  FilledVoxmap import(const std::string& name) {
    report_ = {};
    return voxmap_from_ct(settings(name), report_);
  }
  BoneSettings settings(const std::string& name) const {
    BoneSettings out = settings_for(folder_.file(name), 1);
    out.ct.series = series_;
    out.ct.modality = modality_;
    out.ct.uneven = uneven_;
    return out;
  }
  std::string error_of(const std::string& name) {
    report_ = {};
    try {
      import(name);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_THAT(message, ::testing::Not(::testing::HasSubstr("\n")));
      return message;
    }
    ADD_FAILURE() << "no error for " << name;
    return "";
  }
  void expect_egg(const std::string& name) { expect_same(import(name), reference_, name); }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_.file(name), std::ios::binary) << bytes;
  }
  /// The egg, displaced: another volume.
  TestImage other() const {
    TestImage out = egg_;
    out.sample([](const Vec3& p) { return knobbed_egg(p + Vec3(2, 0, 0)); });
    return out;
  }

  TempFolder folder_;
  TestImage egg_ = egg_image();
  FilledVoxmap reference_;
  Diagnostics report_;
  std::string series_;
  Uneven uneven_ = Uneven::refuse;
  Modality modality_ = Modality::ct;
};

}  // namespace reamsim::test
