// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scan/scan.h"

namespace reamsim::ct {

/// The decoded pixels of a multi-frame DICOM file, for child processes. Private to sim/scan.
class DicomFrames {
 public:
  /// Throws InputError: truncated, damaged, not one integer per pixel.
  DicomFrames(const std::string& path, const std::string& key);

  /// Columns, rows, frames.
  [[nodiscard]] const Vec3i& dims() const { return dims_; }
  /// Writes the pixels of a frame in a box (whose third axis is not used), as slope·value + intercept.
  void copy(int frame, const IndexBox& box, double slope, double intercept, float* out) const;

 private:
  void set_format(const std::string& path, const std::string& key, int samples, int bits, int stored, int high_bit,
                  bool is_signed);
  /// Takes pixels that are not compressed, of any kind of file. False: they are compressed.
  bool take_plain(const std::string& path, const std::string& key);
  void decode(const std::string& path, const std::string& key);
  [[nodiscard]] double value_at(std::size_t pixel) const;

  Vec3i dims_ = Vec3i::Zero();
  int bytes_per_pixel_ = 2;
  int shift_ = 0;  ///< of the lowest stored bit
  std::uint32_t mask_ = 0;
  std::uint32_t sign_ = 0;  ///< the sign bit after the shift; 0: unsigned
  std::vector<char> raw_;
};

}  // namespace reamsim::ct
