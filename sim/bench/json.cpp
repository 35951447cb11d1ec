// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/suite.h"

namespace reamsim::bench {

namespace {

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json case_json(const CaseRow& row) {
  Json out = row_at(row.at);
  out["contacts"] = or_null(row.contacts);
  out.update(spread_ms(row.ms));
  out["kernel_ms"] = row.kernel_ms;
  out["ratio_to_direct"] = or_null(row.ratio_to_direct);
  out["samples"] = row.ms.samples;
  return out;
}

Json sphere_json(const SphereRow& row) {
  Json out{{"engine", row.engine}, {"erosion", name_of(row.erosion)}, {"voxel_mm", row.voxel_mm}};
  out.update(spread_ms(row.ms));
  out["times_real_time"] = row.times_real_time();
  const ExactFrames exact = row.exact.value_or(ExactFrames{});
  out["kernel_ms"] = row.exact ? Json(exact.kernel_ms) : Json(nullptr);
  out["one_core_ms"] = exact.one_core_ms ? Json(exact.one_core_ms->median) : Json(nullptr);
  out["one_core_kernel_ms"] = or_null(exact.one_core_kernel_ms);
  out["voxels"] = row.exact ? Json(exact.voxels) : Json(nullptr);
  out["removed_mm3"] = row.removed_mm3;
  out["volume_error"] = row.volume_error;
  return out;
}

/// One object per row; an empty list stays a list.
template <class Row, class Make>
Json list(const std::vector<Row>& rows, Make make) {
  Json out = Json::array();
  for (const Row& row : rows) out.push_back(make(row));
  return out;
}

}  // namespace

Json row_at(const Place& at) {
  return {{"engine", at.who.engine},
          {"variant", at.who.variant},
          {"voxmap", at.voxmap},
          {"shell", at.shell},
          {"case", at.contact}};
}

Json spread_ms(const Spread& ms) {
  return {{"median_ms", ms.median}, {"min_ms", ms.min}, {"max_ms", ms.max}};
}

std::string json_of(const Findings& findings) {
  Json out;
  out["program"] = "reamsim " REAMSIM_VERSION;
  out["device"] = findings.device;
  out["driver"] = findings.driver;
  out["compute_units"] = findings.compute_units;
  out["repetitions"] = findings.repetitions;
  out["seconds"] = findings.seconds;
  out["results"] = list(findings.cases, case_json);
  out["memory"] = findings.memory;
  out["phases"] = findings.phases;
  out["voi"] = findings.voi;
  out["batches"] = findings.batches;
  out["scatter"] = findings.scatter;
  out["spheres"] = list(findings.spheres, sphere_json);
  out["peaks"] = nullptr;
  if (const auto& peaks = findings.peaks) {
    out["peaks"] = {{"gops", peaks->gops},
                    {"gb_s", peaks->gb_s},
                    {"operations_per_voxel", kExactOperations},
                    {"bytes_per_voxel", kExactBytes}};
  }
  out["poses"] = findings.poses;
  out["shells"] = list(findings.shell_points, [](const auto& row) {
    return Json{{"shell", row.first}, {"points", row.second}};
  });
  out["skipped"] = list(findings.skipped, [](const Skipped& row) {
    Json json = row_at(row.at);
    json["reason"] = row.reason;
    return json;
  });
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace reamsim::bench
