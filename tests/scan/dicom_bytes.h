// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <vector>

#include "test_images.h"

namespace reamsim::test {

// DICOM files written byte by byte, independent of the library that reads them.

/// An element, explicit VR, little endian. Texts are padded.
std::string element(unsigned group, unsigned number, const std::string& vr, std::string value);
/// Values of VR US, UL and FD.
std::string us(unsigned value);
std::string ul(unsigned value);
std::string fd(double value);
/// A sequence whose items are concatenated elements.
std::string sequence(unsigned group, unsigned number, const std::vector<std::string>& items);
/// "a\b\c" with `decimals` digits after the point.
std::string numbers_text(const std::vector<double>& values, int decimals = 6);

/// A file: preamble, meta information and elements.
std::string dicom_file(const std::string& sop_class, const std::string& instance, const std::string& elements,
                       const std::string& transfer_syntax = "1.2.840.10008.1.2.1");

/// Elements by group and element, 0xGGGGEEEE.
using DicomElements = std::map<unsigned, std::string>;

/// How slices are written.
struct SliceFiles {
  int decimals = 6;  ///< of positions
  int first_instance = 1;
  std::string series = "1.2.3.4";
  DicomElements more{};     ///< in each file, explicit VR
  bool ge_private = false;  ///< implicit VR, little endian, with pixels in big endian (1.2.840.113619.5.2)
};

/// Writes one file per slice of 16-bit signed pixels, IM0001 and so on by instance number.
void write_slices(const TestImage& image, const std::string& folder, const SliceFiles& how = {});

/// What an enhanced CT says where.
struct EnhancedCt {
  std::string sop_class = "1.2.840.10008.5.1.4.1.1.2.1";
  std::string instance = "1.2.3.9";
  int instance_number = 1;
  bool orientation_per_frame = false;
  bool rescale_per_frame = false;            ///< with an intercept of its own in each frame
  bool reversed = false;                     ///< frames from the top
  std::vector<std::string> frame_content{};  ///< elements of the frame content, one text for each volume
};

/// Frames of 16-bit unsigned pixels (value + 1024, intercept -1024), of the volumes one after the other.
std::string enhanced_ct(const std::vector<TestImage>& volumes, const EnhancedCt& how);

/// A segment; its voxels are those above 0.
struct TestSegment {
  int number = 1;
  std::string label;
  TestImage mask;
  std::string side{};  ///< a modifier of its type
};

/// A DICOM SEG as dcmqi writes it: BINARY (single bits, empty planes left out), FRACTIONAL or LABELMAP (bytes). `bits`
/// of a pixel: 0: as usual.
std::string dicom_seg(const std::vector<TestSegment>& segments, const std::string& type = "BINARY", unsigned bits = 0);

}  // namespace reamsim::test
