// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/row_decimator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace reamsim {

namespace {

/// About two buckets per pixel of a printed figure when there are most of them.
constexpr std::size_t kMaxBuckets = 4096;
/// Rows that wait in a bucket before it is reduced.
constexpr std::size_t kWaiting = 256;

/// The quantities whose extremes are kept.
constexpr double (*kQuantities[])(const ForceRow&) = {
    [](const ForceRow& row) { return row.axial_force_n; },
    [](const ForceRow& row) { return row.spin_torque_nmm; },
    [](const ForceRow& row) { return row.depth_mm; },
    [](const ForceRow& row) { return row.layer_axial_force_n; },
    [](const ForceRow& row) { return row.layer_spin_torque_nmm; },
    [](const ForceRow& row) { return row.layer_force_n.norm(); },
    [](const ForceRow& row) { return std::abs(row.balance); },
    [](const ForceRow& row) { return row.push ? row.push->feed_mm_s : 0; },
    [](const ForceRow& row) { return row.push ? row.push->drill_power_w : 0; },
};

}  // namespace

RowDecimator::RowDecimator(std::vector<std::int64_t> keep, std::size_t most_rows)
    : keep_(std::move(keep)), most_rows_(most_rows) {}

void RowDecimator::add(const ForceRow& row) {
  last_ = row;
  if (bucket_rows_ > 1) {
    add_to_bucket(row);
    return;
  }
  rows_.push_back(row);
  if (rows_.size() > most_rows_) start_buckets();
}

std::vector<ForceRow> RowDecimator::finish() {
  for (Bucket& bucket : buckets_) {
    reduce(bucket);
    rows_.insert(rows_.end(), bucket.begin(), bucket.end());
    bucket = {};
  }
  if (!rows_.empty() && rows_.back().frame != last_.frame) rows_.push_back(last_);
  return std::move(rows_);
}

void RowDecimator::start_buckets() {
  const Bucket all = std::exchange(rows_, {});
  bucket_rows_ = 2;
  while (all.size() > kMaxBuckets / 2 * static_cast<std::size_t>(bucket_rows_)) bucket_rows_ *= 2;
  for (const ForceRow& row : all) add_to_bucket(row);
}

void RowDecimator::add_to_bucket(const ForceRow& row) {
  if (buckets_.empty() || in_last_ == bucket_rows_) {
    if (!buckets_.empty()) reduce(buckets_.back());
    if (buckets_.size() == kMaxBuckets) merge_pairs();
    buckets_.emplace_back();
    in_last_ = 0;
  }
  Bucket& bucket = buckets_.back();
  bucket.push_back(row);
  ++in_last_;
  if (bucket.size() > kWaiting + keep_.size()) reduce(bucket);
}

void RowDecimator::merge_pairs() {
  for (std::size_t i = 0; i < kMaxBuckets; i += 2) {
    Bucket pair = std::move(buckets_[i]);
    pair.insert(pair.end(), buckets_[i + 1].begin(), buckets_[i + 1].end());
    reduce(pair);
    buckets_[i / 2] = std::move(pair);
  }
  buckets_.resize(kMaxBuckets / 2);
  bucket_rows_ *= 2;
}

void RowDecimator::reduce(Bucket& bucket) const {
  std::vector<bool> chosen(bucket.size(), false);
  chosen[0] = true;
  for (const auto quantity : kQuantities) {
    const auto [least, most] = std::ranges::minmax_element(bucket, {}, quantity);
    chosen[static_cast<std::size_t>(least - bucket.begin())] = true;
    chosen[static_cast<std::size_t>(most - bucket.begin())] = true;
  }
  Bucket out;
  for (std::size_t i = 0; i < bucket.size(); ++i) {
    if (chosen[i] || std::ranges::binary_search(keep_, bucket[i].frame)) out.push_back(bucket[i]);
  }
  bucket = std::move(out);
}

}  // namespace reamsim
