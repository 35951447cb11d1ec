// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

BenchPlot some_plot(int voxmaps) {
  BenchPlot plot;
  plot.device = "a \"device\" with_marks {and} \\ more";
  for (int v = 0; v < voxmaps; ++v) {
    for (int shell = 64; shell <= 1024; shell *= 2) {
      plot.severe.push_back({"direct, published", 128 << v, shell, 0.01 * shell, 0.001 * shell});
      plot.severe.push_back({"bricked", 128 << v, shell, 0.001 * shell, std::nullopt});
    }
  }
  return plot;
}

void expect_figure(const std::string& dir) {
  const test::Picture figure = test::read_picture(dir + "/bench.png");
  EXPECT_EQ(figure.width, 1600);
  EXPECT_EQ(figure.height, 1000);
  int colored = 0;
  for (const std::uint32_t pixel : figure.pixels) {
    const std::uint32_t rgb = pixel & 0xffffff;
    colored += rgb == 0x009e73 || rgb == 0x0072b2 ? 1 : 0;
  }
  EXPECT_GT(colored, 500) << "curves in their colours";
  EXPECT_THAT(test::file_bytes(dir + "/bench.svg"), ::testing::HasSubstr("</svg>"));
}

TEST(BenchFigure, FourVoxmapsAndTheVoi) {
  const test::TempDir dir;
  BenchPlot plot = some_plot(4);
  for (int tenth = 1; tenth <= 10; ++tenth) plot.voi.push_back({"bricked", 10.0 * tenth, 0.1 * tenth, 1.2});
  write_bench_plot(dir.path(), plot);
  expect_figure(dir.path());
}

TEST(BenchFigure, OneVoxmapWithoutVoiOrPaper) {
  const test::TempDir dir;
  BenchPlot plot = some_plot(1);
  for (auto& point : plot.severe) point.paper_ms.reset();
  write_bench_plot(dir.path(), plot);
  expect_figure(dir.path());
}

TEST(BenchFigure, FolderThatIsNotThere) {
  EXPECT_THROW(write_bench_plot("/nonexistent/folder", some_plot(1)), RunError);
}

}  // namespace
}  // namespace reamsim
