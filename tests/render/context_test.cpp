// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "render/gl/context.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using Maker = std::unique_ptr<OffscreenContext> (*)();

class Contexts : public ::testing::TestWithParam<Maker> {};

/// A picture filled with one colour.
std::vector<std::uint32_t> cleared(const Gl& gl, float red) {
  const GlTarget target(gl, 5, 3, true);
  target.bind();
  gl.ClearColor(red, 0.0F, 1.0F, 1.0F);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  return target.read();
}

TEST_P(Contexts, DrawsIntoAPictureOfItsOwn) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = GetParam()();
  } catch (const RunError& error) {
    GTEST_SKIP() << error.what();
  }
  EXPECT_EQ(cleared(context->gl(), 1.0F), std::vector<std::uint32_t>(15, 0xFFFF00FF));
  EXPECT_THROW(GlTarget(context->gl(), 0, 4, true), RunError);
  EXPECT_THROW(GlTarget(context->gl(), 1 << 20, 4, true), RunError);
  EXPECT_THROW(GlProgram(context->gl(), "broken", {"#version 450 core\nvoid main() { oops }"},
                         {"#version 450 core\nvoid main() {}"}),
               RunError);
}

INSTANTIATE_TEST_SUITE_P(Both, Contexts, ::testing::Values(&make_osmesa_context, &make_egl_context));

TEST(ContextTest, BothLiveInOneProcess) {
  std::unique_ptr<OffscreenContext> osmesa;
  std::unique_ptr<OffscreenContext> egl;
  try {
    osmesa = make_osmesa_context();
    egl = make_egl_context();
  } catch (const RunError& error) {
    GTEST_SKIP() << error.what();
  }
  for (int turn = 0; turn < 3; ++turn) {
    osmesa->make_current();
    EXPECT_EQ(cleared(osmesa->gl(), 0.0F).front(), 0xFF0000FF);
    egl->make_current();
    EXPECT_EQ(cleared(egl->gl(), 1.0F).front(), 0xFFFF00FF);
  }
}

TEST(ContextTest, ChosenByName) {
  std::string fallback;
  EXPECT_NE(make_context(RenderContext::osmesa, fallback), nullptr);
  EXPECT_NE(make_context(RenderContext::egl, fallback), nullptr);
}

TEST(ContextTest, AutomaticTakesWhatThisSystemHasWithoutAWarning) {
  std::string fallback;
  const auto context = make_context(RenderContext::automatic, fallback);
  EXPECT_EQ(fallback, "");
  bool has_osmesa = true;
  try {
    const DynamicLibrary osmesa({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}, "OSMesa");
  } catch (const RunError&) {
    has_osmesa = false;
  }
  const std::string expected = has_osmesa ? "osmesa: llvmpipe" : "egl: llvmpipe";
  EXPECT_EQ(context->description().substr(0, expected.size()), expected) << "neither needs a GPU";
  EXPECT_NE(context->description().find("Mesa"), std::string::npos);
}

TEST(DynamicLibraryTest, AMissingLibraryIsARunErrorThatNamesIt) {
  try {
    const DynamicLibrary missing({"libnowhere.so.1"}, "Nowhere");
    ADD_FAILURE();
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("libnowhere.so.1"), std::string::npos);
  }
}

}  // namespace
}  // namespace reamsim
