// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/scan_transfer.h"

#include <algorithm>

namespace reamsim::ct {

namespace {

void put_numbers(ResultWriter& out, const double* first, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out.put(first[i]);
}

void take_numbers(ResultReader& in, double* first, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) first[i] = in.get<double>();
}

}  // namespace

void put_geometry(ResultWriter& out, const ScanGeometry& geometry) {
  for (const int size : geometry.dims) out.put(size);
  put_numbers(out, geometry.step_mm.data(), 9);
  put_numbers(out, geometry.origin_mm.data(), 3);
}

ScanGeometry take_geometry(ResultReader& in) {
  ScanGeometry out;
  for (int& size : out.dims) size = in.get<int>();
  take_numbers(in, out.step_mm.data(), 9);
  take_numbers(in, out.origin_mm.data(), 3);
  if (!is_plausible(out)) in.fail();
  return out;
}

void put_facts(ResultWriter& out, const ImageFacts& facts) {
  out.put(facts.format);
  out.put(facts.pixel_type);
  put_geometry(out, facts.geometry);
  out.put(facts.layers);
  out.put(facts.bytes_per_voxel);
  out.put(facts.frame);
  out.put(facts.warnings);
}

ImageFacts take_facts(ResultReader& in) {
  ImageFacts out;
  out.format = in.text();
  out.pixel_type = in.text();
  out.geometry = take_geometry(in);
  out.layers = in.get<int>();
  out.bytes_per_voxel = in.get<double>();
  out.frame = in.text();
  out.warnings = in.texts();
  if (out.layers < 1 || !(out.bytes_per_voxel > 0)) in.fail();
  return out;
}

void put_texts(ResultWriter& out, const std::map<std::string, std::string>& texts) {
  out.put(std::uint64_t{texts.size()});
  for (const auto& [name, value] : texts) {
    out.put(name);
    out.put(value);
  }
}

std::map<std::string, std::string> take_texts(ResultReader& in) {
  std::map<std::string, std::string> out;
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) {
    std::string name = in.text();
    out[std::move(name)] = in.text();
  }
  return out;
}

}  // namespace reamsim::ct
