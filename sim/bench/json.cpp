// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <nlohmann/json.hpp>

#include "sim/bench/findings.h"
#include "sim/bench/peaks.h"

namespace reamsim::bench {

namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json place_json(const Place& at, bool with_case) {
  Json out{{"engine", at.who.engine}, {"variant", at.who.variant}, {"voxmap", at.voxmap}, {"shell", at.shell}};
  if (with_case) out["case"] = at.contact;
  return out;
}

void add_spread(Json& out, const Spread& ms) {
  out["median_ms"] = ms.median;
  out["min_ms"] = ms.min;
  out["max_ms"] = ms.max;
}

Json case_json(const CaseRow& row) {
  Json out = place_json(row.at, true);
  out["contacts"] = or_null(row.contacts);
  add_spread(out, row.ms);
  out["kernel_ms"] = row.kernel_ms;
  out["ratio_to_direct"] = or_null(row.ratio_to_direct);
  out["samples"] = row.ms.samples;
  return out;
}

Json phase_json(const PhaseRow& row) {
  Json out = place_json(row.at, true);
  out.update({{"obb_us", row.obb},
              {"voi_us", row.voi},
              {"upload_us", row.upload},
              {"kernel_us", row.kernel},
              {"read_us", row.read},
              {"total_us", row.total}});
  return out;
}

Json scatter_json(const ScatterRow& row) {
  Json out = place_json(row.at, true);
  out.update({{"repetitions", row.repetitions},
              {"points", row.points},
              {"voxels", or_null(row.voxels)},
              {"contacts_median", row.contacts.median},
              {"contacts_min", row.contacts.min},
              {"contacts_max", row.contacts.max},
              {"contacts_spread", row.contacts_spread},
              {"force_spread", row.force_spread},
              {"component_spread", row.component_spread}});
  return out;
}

Json voi_json(const VoiRow& row) {
  return {{"engine", row.who.engine},
          {"variant", row.who.variant},
          {"fraction", row.fraction},
          {"contacts", row.contacts},
          {"with_ms", row.with_ms.median},
          {"with_min_ms", row.with_ms.min},
          {"with_max_ms", row.with_ms.max},
          {"without_ms", row.without_ms.median},
          {"without_min_ms", row.without_ms.min},
          {"without_max_ms", row.without_ms.max}};
}

/// One object per row; an empty list stays a list.
template <class Row, class Make>
Json list(const std::vector<Row>& rows, Make make) {
  Json out = Json::array();
  for (const Row& row : rows) out.push_back(make(row));
  return out;
}

}  // namespace

std::string json_of(const Findings& findings) {
  Json out;
  out["program"] = "reamsim " REAMSIM_VERSION;
  out["device"] = findings.device;
  out["driver"] = findings.driver;
  out["compute_units"] = findings.compute_units;
  out["repetitions"] = findings.repetitions;
  out["seconds"] = findings.seconds;
  out["results"] = list(findings.cases, case_json);
  out["memory"] = list(findings.memory, [](const MemoryRow& row) {
    return Json{{"engine", row.engine},
                {"voxmap", row.voxmap},
                {"shell", row.shell},
                {"voxmap_mb", row.voxmap_mb},
                {"shell_mb", row.shell_mb}};
  });
  out["phases"] = list(findings.phases, phase_json);
  out["voi"] = list(findings.voi, voi_json);
  out["batches"] = list(findings.batches, [](const BatchRow& row) {
    Json json = place_json(row.at, true);
    json["batch"] = row.batch;
    add_spread(json, row.ms);
    return json;
  });
  out["scatter"] = list(findings.scatter, scatter_json);
  out["spheres"] = list(findings.spheres, [](const SphereRow& row) {
    Json json{{"engine", row.engine}, {"erosion", name_of(row.erosion)}, {"voxel_mm", row.voxel_mm}};
    add_spread(json, row.ms);
    json["times_real_time"] = row.times_real_time();
    const ExactFrames exact = row.exact.value_or(ExactFrames{});
    json["kernel_ms"] = or_null(row.exact ? std::optional(exact.kernel_ms) : std::nullopt);
    json["one_core_ms"] = or_null(exact.one_core_ms ? std::optional(exact.one_core_ms->median) : std::nullopt);
    json["one_core_kernel_ms"] = or_null(exact.one_core_kernel_ms);
    json["voxels"] = or_null(row.exact ? std::optional(exact.voxels) : std::nullopt);
    json["removed_mm3"] = row.removed_mm3;
    json["volume_error"] = row.volume_error;
    return json;
  });
  out["peaks"] = nullptr;
  if (const auto& peaks = findings.peaks) {
    out["peaks"] = {{"gops", peaks->gops},
                    {"gb_s", peaks->gb_s},
                    {"operations_per_voxel", kExactOperations},
                    {"bytes_per_voxel", kExactBytes}};
  }
  out["poses"] = list(findings.poses, [](const PoseCount& row) {
    return Json{{"case", row.contact}, {"pose", row.pose}, {"points", row.points}, {"wanted", row.wanted}};
  });
  out["shells"] = list(findings.shell_points, [](const auto& row) {
    return Json{{"shell", row.first}, {"points", row.second}};
  });
  out["skipped"] = list(findings.skipped, [](const Skipped& row) {
    Json json = place_json(row.at, true);
    json["reason"] = row.reason;
    return json;
  });
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace reamsim::bench
