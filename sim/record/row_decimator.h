// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "sim/record/force_log.h"

namespace reamsim {

/// Collects the rows of a log in bounded memory, in one pass. Up to a number of rows it keeps all. From a longer log it
/// keeps the first and the last row, those of given frames, and of each of 2048 to 4096 buckets of successive rows the
/// first and those with the least and the greatest depth, force, torque, their means, and energy balance: curves keep
/// their peaks.
class RowDecimator {
 public:
  /// `keep`: frames, ascending.
  RowDecimator(std::vector<std::int64_t> keep, std::size_t most_rows);

  void add(const ForceRow& row);
  /// The rows that were kept, ascending.
  std::vector<ForceRow> finish();
  /// Rows per bucket; 1 as long as all rows are kept.
  [[nodiscard]] std::int64_t bucket_rows() const { return bucket_rows_; }

 private:
  using Bucket = std::vector<ForceRow>;

  void start_buckets();
  void add_to_bucket(const ForceRow& row);
  void merge_pairs();
  /// Removes rows that are neither first, extreme nor kept.
  void reduce(Bucket& bucket) const;

  std::vector<std::int64_t> keep_;
  std::size_t most_rows_;
  Bucket rows_;  ///< all rows, or none once there are buckets
  std::vector<Bucket> buckets_;
  std::int64_t bucket_rows_ = 1;
  std::int64_t in_last_ = 0;  ///< rows that the last bucket has received
  ForceRow last_;
};

}  // namespace reamsim
