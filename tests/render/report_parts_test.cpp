// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "render/viewer/page.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Bytes = std::vector<std::uint8_t>;

TEST(Markup, EscapesWhatHtmlWouldRead) {
  EXPECT_EQ(escape_html(R"(</script> & "a" 'b')"), "&lt;/script&gt; &amp; &quot;a&quot; &#39;b&#39;");
}

TEST(Markup, Base64IsThatOfRfc4648) {
  const auto encoded = [](const std::string& text) { return base64(Bytes(text.begin(), text.end())); };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
  // Longer than the pieces that it is encoded in.
  const std::string long_one = base64(Bytes((3 << 20) + 1));
  EXPECT_EQ(long_one.find_first_not_of('A'), long_one.size() - 2);
}

TEST(Markup, JsonCannotEndItsScript) {
  const nlohmann::ordered_json json{{"name", "</script><!-- \xff"}};
  const std::string text = json_for_script(json);
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(text)["name"], "</script><!-- \uFFFD");
}

TEST(Markup, WhatIsPutInIsNotLookedAtAgain) {
  EXPECT_EQ(fill_template("<{{a}}|{{b}}>", {{"a", "{{b}}"}, {"b", "2"}}), "<{{b}}|2>");
  EXPECT_THROW(fill_template("{{c}}", {{"a", ""}}), std::logic_error);
}

/// A summary with what every run has, and `metrics`.
nlohmann::ordered_json tables_of(const nlohmann::ordered_json& metrics) {
  nlohmann::ordered_json summary{
      {"program", "p"}, {"device", "d"}, {"engine", "e"}, {"erosion", "exact"}, {"law", "l"}};
  summary["warnings"] = summary["inputs"] = nlohmann::ordered_json::array();
  summary["metrics"] = metrics;
  return summary_data(summary, nullptr, "summary.json", "verification.json");
}

TEST(SummaryData, AConventionNeedsItsAngle) {
  nlohmann::ordered_json metrics{{"orientation",
                                  {{"inclination_convention", "superior tilt positive"},
                                   {"native_shape", "sphere"},
                                   {"native_reason", "no rim"}}}};
  const std::string without = tables_of(metrics)["measurements"].dump();
  EXPECT_THAT(without, HasSubstr(R"(["Native orientation unknown","no rim",""])"));
  EXPECT_THAT(without, Not(HasSubstr("superior tilt positive")));
  metrics["orientation"]["reamer"]["inclination_deg"] = 0.0007;
  const std::string with = tables_of(metrics)["measurements"].dump();
  EXPECT_THAT(with, HasSubstr("superior tilt positive"));
  EXPECT_THAT(with, HasSubstr(R"(["Inclination of the reamer",0.0007,"°"])"));
}

TEST(SummaryData, VersionsStandSideBySide) {
  using nlohmann::ordered_json;
  ordered_json metrics = ordered_json::parse(R"({"version": {"face_axis_deg": null, "face_axis_reason": "no rim",
      "two_planes_deg": 7.35, "two_planes_reason": null, "vault_2d_deg": null, "vault_2d_reason": "set it"}})");
  const std::string planes = "Two planes: rim against scapular plane (Ganapathi et al. 2011)";
  ordered_json expected{{"title", "Version before reaming, by definition"}, {"rows", {{planes, 7.35, "°"}}}};
  EXPECT_FALSE(tables_of(metrics).contains("measurements") &&
               tables_of(metrics)["measurements"].dump().find(planes) != std::string::npos)
      << "nothing stands beside the axis of the face";
  metrics["version"]["by_landmarks"] = 1;
  expected["rows"].push_back({"Axis of the face unknown", "no rim", ""});
  expected["rows"].push_back({"Margins against tip of the vault unknown", "set it", ""});
  EXPECT_EQ(tables_of(metrics)["measurements"].back(), expected);
}

TEST(PictureData, ChoosesEvenlyWithBothEnds) {
  EXPECT_THAT(evenly_spaced(11, 40), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_THAT(evenly_spaced(11, 3), ElementsAre(0, 5, 10));
  EXPECT_THAT(evenly_spaced(5, 1), ElementsAre(4));
  EXPECT_TRUE(evenly_spaced(0, 3).empty());
}

TEST(PlotData, KeepsTheSpikesOfALongRun) {
  ForceLog log;
  for (int i = 0; i < 50'000; ++i) {
    ForceRow row;
    row.frame = i;
    row.time_s = 1e-3 * i;
    row.axial_force_n = i == 31'234 ? 500 : 1;
    row.spin_torque_nmm = i == 7 ? -20 : 2;
    log.rows.push_back(row);
  }
  const auto json = plot_data(log, 0);
  const auto frames = json["frame"].get<std::vector<int>>();
  EXPECT_LE(frames.size(), 5001u);
  EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end()));
  EXPECT_EQ(frames.front(), 0);
  EXPECT_EQ(frames.back(), 49'999);
  for (const char* column : {"time_s", "depth_mm", "axial_force_n", "spin_torque_nmm", "removed_mm3"}) {
    EXPECT_EQ(json[column].size(), frames.size()) << column;
  }
  const auto spike = std::find(frames.begin(), frames.end(), 31'234);
  ASSERT_NE(spike, frames.end());
  EXPECT_EQ(json["axial_force_n"][static_cast<std::size_t>(spike - frames.begin())], 500);
  EXPECT_NE(std::find(frames.begin(), frames.end(), 7), frames.end());
  EXPECT_FALSE(json.contains("mean_axial_force_n"));
  EXPECT_EQ(plot_data(log, 0.25)["mean_axial_force_n"].size(), frames.size());
}

TEST(PlotData, APushHasFeedAndPowerWithTheirExtremes) {
  ForceLog log;
  for (int i = 0; i < 20'000; ++i) {
    ForceRow row;
    row.frame = i;
    row.push = PushResult{.feed_mm_s = i == 12'345 ? 4.5 : 0.5, .drill_power_w = 20};
    log.rows.push_back(row);
  }
  const auto json = plot_data(log, 0);
  ASSERT_EQ(json["feed_mm_s"].size(), json["frame"].size());
  const auto feeds = json["feed_mm_s"].get<std::vector<double>>();
  EXPECT_EQ(*std::ranges::max_element(feeds), 4.5);
  EXPECT_EQ(json["drill_power_w"][0], 20);
  for (ForceRow& row : log.rows) row.push.reset();
  EXPECT_FALSE(plot_data(log, 0).contains("feed_mm_s"));
}

TEST(SummaryData, PlanningIsThereWithAnImplantOnly) {
  using nlohmann::ordered_json;
  EXPECT_TRUE(tables_of({{"seating", nullptr}, {"planning", nullptr}})["planning"].empty());
  const ordered_json planning = tables_of(ordered_json::parse(R"({
      "seating": {"seated_percent": 91.27, "overhang_mm2": 0},
      "planning": {"native": {"version_deg": 15.0002, "inclination_deg": 8.0}, "planned": null, "planned_reason": "a <b>",
                   "vault": {"left_mm3": 9876.5}, "pegs": [
                     {"length_mm": 12, "in_bone_mm": 12, "perforated_mm": 0, "least_wall_mm": 2.13},
                     {"length_mm": 0, "in_bone_mm": 0, "perforated_mm": 0, "least_wall_mm": null}]}})"))["planning"];
  EXPECT_EQ(planning, ordered_json::parse(R"([
      {"title": "Implant and joint line", "rows": [["Version, native face", 15.0002, "°"],
                                                   ["Inclination, native face", 8.0, "°"],
                                                   ["No planned orientation", "a <b>", ""]]},
      {"title": "Support of the implant", "rows": [["Backside seated", 91.27, "%"], ["Overhang", 0, "mm²"]]},
      {"title": "Vault", "rows": [["Vault bone under the implant", 9876.5, "mm³"]]},
      {"title": "Pegs", "columns": ["Peg", "Length, mm", "In bone, mm", "Perforated, mm", "Least wall, mm"],
       "decimals": [0, 1, 1, 1, 1], "rows": [[1, 12, 12, 0, 2.13], [2, 0, 0, 0, null]]}])"));
  for (const char* damaged : {R"({"planning": {"pegs": [{"length_mm": "x"}]}})", R"({"planning": {"pegs": 5}})"})
    EXPECT_THROW(tables_of(ordered_json::parse(damaged)), InputError) << damaged;
}

TEST(DensityVolume, AveragesBoneAndCarriesItIntoTheAir) {
  VoxelGrid grid;
  grid.voxel_mm = 0.5;
  grid.dims = Vec3i(40, 40, 40);
  grid.origin_mm = Vec3(-3, 2, 7);
  FilledVoxmap voxmap(grid);
  for (int z = 10; z < 30; ++z) {
    for (int y = 10; y < 30; ++y) {
      for (int x = 10; x < 30; ++x) voxmap.grade.set({x, y, z}, x % 2 == 0 ? 100 : 120);
    }
  }
  const DensityVolume volume = density_volume(voxmap, 14 * 14 * 14);
  EXPECT_EQ(volume.cell_mm, 1.0);
  EXPECT_EQ(volume.dims, Vec3i(14, 14, 14));
  EXPECT_TRUE(volume.origin_mm.isApprox(grid.origin_mm + Vec3(3, 3, 3)));
  const auto at = [&](int x, int y, int z) {
    return int{volume.grades[static_cast<std::size_t>(x + 14 * (y + 14 * z))]};
  };
  EXPECT_EQ(at(7, 7, 7), 110);
  EXPECT_EQ(at(1, 7, 7), 110) << "carried on";
  EXPECT_EQ(at(0, 7, 7), 110) << "and on";
  EXPECT_EQ(at(0, 0, 0), 0);
}

TEST(DensityVolume, WithoutBoneIsWrongInput) {
  VoxelGrid grid;
  grid.dims = Vec3i(8, 8, 8);
  EXPECT_THROW(density_volume(Voxmap(grid), 1000), InputError);
}

/// A sphere as rings of triangles, the upper part "reamed".
BoneSurface sphere(int rings, float radius) {
  BoneSurface out;
  const int turns = 2 * rings;
  const auto put = [&](double polar, double turn) {
    const Eigen::Vector3d n(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
    const Eigen::Vector3f p = radius * n.cast<float>() + Eigen::Vector3f(100, -50, 3);
    const bool reamed = n.z() > 0.8;
    for (const float value : {p.x(), p.y(), p.z(), float(n.x()), float(n.y()), float(n.z()), reamed ? 1.5F : 0.0F,
                              reamed ? 1.0F : 0.0F, 1.2F, 0.9F}) {
      out.vertices.push_back(value);
    }
  };
  put(0, 0);
  for (int r = 1; r < rings; ++r) {
    for (int t = 0; t < turns; ++t) put(M_PI * r / rings, 2 * M_PI * t / turns);
  }
  put(M_PI, 0);
  const auto at = [&](int r, int t) {
    return static_cast<std::uint32_t>(r == 0       ? 0
                                      : r == rings ? 1 + (rings - 1) * turns
                                                   : 1 + (r - 1) * turns + t % turns);
  };
  for (int r = 0; r < rings; ++r) {
    for (int t = 0; t < turns; ++t) {
      if (r + 1 < rings) out.indices.insert(out.indices.end(), {at(r, t), at(r + 1, t), at(r + 1, t + 1)});
      if (r > 0) out.indices.insert(out.indices.end(), {at(r, t), at(r + 1, t + 1), at(r, t + 1)});
    }
  }
  return out;
}

/// Every edge is used as often one way as the other, so no crack is open.
bool closed(const BoneSurface& surface) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (std::size_t i = 0; i < surface.indices.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = surface.indices[i + c], b = surface.indices[i + (c + 1) % 3];
      balance[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  return std::all_of(balance.begin(), balance.end(), [](const auto& edge) { return edge.second == 0; });
}

TEST(MeshData, ThinningKeepsToTheBudgetAndOpensNoCrack) {
  const BoneSurface whole = sphere(120, 20);
  ASSERT_TRUE(closed(whole));
  const BoneSurface thin = simplified(whole, {.unreamed_triangles = 6000, .reamed_triangles = 2000});
  EXPECT_TRUE(closed(thin));
  // Borders between the two parts stay, so a few more than the budget may be left.
  EXPECT_LE(thin.indices.size() / 3, 8800u);
  EXPECT_GE(thin.indices.size() / 3, 4000u);
  const std::size_t count = thin.vertices.size() / BoneSurface::kStride;
  EXPECT_EQ(*std::max_element(thin.indices.begin(), thin.indices.end()), count - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::Vector3f> p(thin.vertices.data() + i * BoneSurface::kStride);
    EXPECT_NEAR((p - Eigen::Vector3f(100, -50, 3)).norm(), 20, 1e-3);
  }
}

TEST(MeshData, LeavesASmallMeshAsItIs) {
  const BoneSurface whole = sphere(12, 20);
  EXPECT_EQ(simplified(whole, MeshBudget()).indices.size(), whole.indices.size());
  EXPECT_TRUE(simplified(BoneSurface(), MeshBudget()).indices.empty());
}

/// Reads back what mesh_bytes() wrote.
struct Unpacked {
  Unpacked(const Bytes& bytes, std::size_t vertices, std::size_t corners, const Eigen::AlignedBox3f& box)
      : places(vertices), depth(vertices), attributes(vertices) {
    for (std::size_t i = 0; i < vertices; ++i) places[i] = box.min();
    for (std::size_t part = 0; part < 10; ++part) {
      std::uint16_t value = 0;
      for (std::size_t i = 0; i < vertices; ++i) {
        const int code = bytes[2 * part * vertices + i] | bytes[(2 * part + 1) * vertices + i] << 8;
        value = static_cast<std::uint16_t>(value + ((code >> 1) ^ -(code & 1)));
        const auto fraction = static_cast<float>(value) / 65535;
        if (part < 3) places[i][static_cast<int>(part)] += box.sizes()[static_cast<int>(part)] * fraction;
        if (part == 3) depth[i] = fraction;
        if (part > 3) attributes[i][part - 4] = value - (part < 7 ? 127 : 0);
      }
    }
    std::size_t at = 20 * vertices;
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      std::uint32_t below = 0;
      for (int shift = 0;; shift += 7) {
        below |= std::uint32_t{bytes.at(at)} % 128 << shift;
        if (bytes.at(at++) < 128) break;
      }
      indices.push_back(next - below);
      if (below == 0) ++next;
    }
    rest = bytes.size() - at;
  }
  std::vector<Eigen::Vector3f> places;
  std::vector<float> depth;  // of the greatest
  std::vector<std::array<int, 6>> attributes;
  std::vector<std::uint32_t> indices;
  std::size_t rest = 0;
};

TEST(MeshData, BytesReadBackWithinTheirSteps) {
  const BoneSurface surface = simplified(sphere(60, 20), {.unreamed_triangles = 3000, .reamed_triangles = 1000});
  const Eigen::AlignedBox3f box = bounds_of(surface);
  EXPECT_NEAR(box.sizes().x(), 40, 0.1);
  const std::size_t count = surface.vertices.size() / BoneSurface::kStride;
  const Unpacked back(mesh_bytes(surface, box, 2.0), count, surface.indices.size(), box);
  EXPECT_EQ(back.rest, 0u);
  EXPECT_EQ(back.indices, surface.indices);
  for (std::size_t i = 0; i < count; ++i) {
    const float* v = surface.vertices.data() + i * BoneSurface::kStride;
    EXPECT_LE((back.places[i] - Eigen::Map<const Eigen::Vector3f>(v)).cwiseAbs().maxCoeff(),
              0.51F * 40 / 65535 + 1e-5F);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(back.attributes[i][axis], 127 * v[3 + axis], 0.51);
    }
    EXPECT_NEAR(back.depth[i], v[6] / 2, 1e-5);
    EXPECT_NEAR(back.attributes[i][3], 255 * v[7], 0.51);
    EXPECT_NEAR(back.attributes[i][4], 255 * v[8] / 2, 0.51);
    EXPECT_NEAR(back.attributes[i][5], 255 * v[9], 0.51);
  }
}

TEST(MeshData, PlacesOutsideTheBoxGoToItsEdge) {
  BoneSurface surface;
  surface.vertices = {-5, 0, 50, 0, 0, 1, 9, 1, 3, 2};
  Eigen::AlignedBox3f box(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(10, 10, 10));
  const Unpacked back(mesh_bytes(surface, box, 2.0), 1, 0, box);
  EXPECT_EQ(back.places[0], Eigen::Vector3f(0, 0, 10));
  EXPECT_THAT(back.attributes[0], ElementsAre(0, 0, 127, 255, 255, 255));
}

}  // namespace
}  // namespace reamsim
