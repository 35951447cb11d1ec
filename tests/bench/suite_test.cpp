// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A whole run at a small size: every row is there, and the JSON has the keys that docs/columns.md promises.
#include "sim/bench/suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/device/opencl.h"

namespace reamsim::bench {
namespace {

using ::testing::HasSubstr;

Plan small_plan() {
  Plan plan;
  plan.engines = engine_names();
  plan.sizes = {{32, 32}, {64, 32}, {64, 64}};
  plan.sampled = 64;
  plan.repetitions = 2;
  plan.verify_poses = false;
  plan.plunge_frames = 40;
  plan.sphere_voxels_mm = {1.0};
  return plan;
}

void expect_keys(const Json& rows, std::initializer_list<const char*> keys) {
  ASSERT_TRUE(rows.is_array());
  ASSERT_FALSE(rows.empty());
  for (const auto& row : rows) {
    for (const char* key : keys) EXPECT_TRUE(row.contains(key)) << key << " of " << row;
  }
}

TEST(BenchSuite, SpreadIsMedianAndExtremes) {
  const Spread odd = spread_of({3, 1, 2}), even = spread_of({4, 1, 2, 3});
  EXPECT_EQ(odd.median, 2);
  EXPECT_EQ(even.median, 2.5);
  EXPECT_EQ(even.min, 1);
  EXPECT_EQ(even.max, 4);
  EXPECT_EQ(even.samples, 4);
}

TEST(BenchSuite, SmallRunHasEveryRowAndKey) {
  std::vector<double> behind;
  BenchControl control;
  control.part = [&](double fraction, const std::string&) { behind.push_back(fraction); };
  const Json json = run_bench(small_plan(), control);
  ASSERT_FALSE(behind.empty());
  EXPECT_EQ(std::ranges::adjacent_find(behind, std::ranges::greater_equal{}), behind.end()) << "each step has its time";
  EXPECT_EQ(behind.front(), 0);
  EXPECT_LT(behind.back(), 1);
  EXPECT_FALSE(json["device"].get<std::string>().empty());
  expect_keys(json["results"], {"engine", "variant", "voxmap", "shell", "case", "contacts", "median_ms", "min_ms",
                                "max_ms", "kernel_ms", "ratio_to_direct"});
  expect_keys(json["memory"], {"engine", "voxmap", "shell", "voxmap_mb", "shell_mb"});
  expect_keys(json["phases"],
              {"engine", "variant", "obb_us", "voi_us", "upload_us", "kernel_us", "read_us", "total_us"});
  expect_keys(json["voi"], {"engine", "variant", "fraction", "contacts", "with_ms", "without_ms"});
  expect_keys(json["scatter"], {"engine", "variant", "points", "contacts_min", "contacts_max", "force_spread"});
  expect_keys(json["spheres"], {"engine", "erosion", "voxel_mm", "median_ms", "times_real_time", "kernel_ms",
                                "one_core_ms", "one_core_kernel_ms", "voxels", "removed_mm3", "volume_error"});
  for (const char* key : {"gops", "gb_s", "operations_per_voxel", "bytes_per_voxel"}) {
    EXPECT_GT(json["peaks"].value(key, 0.0), 0) << key;
  }

  for (const char* contact : {"severe", "light", "none", "plunge"}) {
    const Json* direct = find_result(json, {"direct", "published"}, 64, 64, contact);
    ASSERT_NE(direct, nullptr) << contact;
    EXPECT_EQ((*direct)["ratio_to_direct"], 1) << contact;
    EXPECT_LE((*direct)["min_ms"], (*direct)["median_ms"]);
    EXPECT_LE((*direct)["median_ms"], (*direct)["max_ms"]);
  }
  EXPECT_EQ((*find_result(json, {"direct", "deterministic"}, 64, 64, "severe"))["samples"], 2 * 4);
  const auto contacts = [&](const char* contact) {
    return (*find_result(json, {"direct", "deterministic"}, 64, 64, contact))["contacts"].get<double>();
  };
  EXPECT_GT(contacts("severe"), 3 * contacts("light"));
  // Voxels of 0.6 mm reach up to a reamer that stands 0.3 mm clear of the bone at 1024³.
  EXPECT_LT(contacts("none"), contacts("light") / 2);
  EXPECT_THAT(text_of(json), HasSubstr("direct, published, severe contact"));
}

TEST(BenchSuite, ExactHasEveryCaseAndItsSphere) {
  Plan plan = small_plan();
  plan.engines = {"exact"};
  const Json report = run_bench(plan, {});
  EXPECT_TRUE(report["skipped"].empty()) << text_of(report);
  for (const char* contact : {"severe", "light", "none", "plunge"}) {
    const Json* row = find_result(report, {"exact", "deterministic"}, 64, 64, contact);
    ASSERT_NE(row, nullptr) << contact;
    EXPECT_LE((*row)["kernel_ms"], (*row)["max_ms"]) << contact;
  }
  ASSERT_EQ(report["spheres"].size(), 1U);
  const Json& sphere = report["spheres"][0];
  EXPECT_LT(std::abs(sphere["volume_error"].get<double>()), 1e-3);
  EXPECT_GT(sphere["voxels"], 0);
  EXPECT_EQ(sphere["samples"], 4 * 4);  // windows at each depth
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  EXPECT_EQ(!sphere["one_core_ms"].is_null(), device.compute_units > 1 && device.max_parts > 0);
}

TEST(BenchSuite, AnEngineIsMeasuredOrListedWithTheReason) {
  Plan plan = small_plan();
  plan.details = false;
  plan.sphere_voxels_mm = {};
  const Json report = run_bench(plan, {});
  for (const std::string& engine : engine_names()) {
    const bool measured = find_result(report, {engine, "deterministic"}, 64, 64, "severe") != nullptr;
    const bool listed = std::ranges::any_of(report["skipped"], [&](const Json& row) {
      return row["engine"] == engine && row["variant"] == "deterministic" && row["reason"] != "";
    });
    EXPECT_NE(measured, listed) << engine;
  }
}

TEST(BenchSuite, PosesThatTouchSomethingElseAreAnError) {
  Plan plan = small_plan();
  plan.verify_poses = true;  // at 64³ a depth found at 1024³ is off by more than 5 %
  plan.sizes = {{32, 32}};
  try {
    run_bench(plan, {});
    FAIL() << "no error";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("points and should touch"));
  }
}

TEST(BenchSuite, WrongEngineOrDeviceIsAnInputError) {
  Plan plan = small_plan();
  plan.engines = {"direct", "sparse"};
  EXPECT_THROW(run_bench(plan, {}), InputError);
  plan = small_plan();
  plan.device = "serial";
  EXPECT_THROW(run_bench(plan, {}), InputError);
  plan.device = "no such device";
  EXPECT_THROW(run_bench(plan, {}), InputError);
}

TEST(BenchSuite, StopsWhenAsked) {
  BenchControl control;
  control.stop = [] { return true; };
  EXPECT_THROW(run_bench(small_plan(), control), Interrupted);
}

}  // namespace
}  // namespace reamsim::bench
