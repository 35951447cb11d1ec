// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/error.h"

#include <gtest/gtest.h>

namespace reamsim {
namespace {

TEST(InputError, NamesPlaceKeyFoundAndExpected) {
  const InputError error({"a.yaml", 12, 7}, "tool.scale", "found -1", "expected 0.001 to 1000");
  EXPECT_STREQ(error.what(), "a.yaml:12:7: tool.scale: found -1; expected 0.001 to 1000");
}

TEST(InputError, LeavesOutWhatIsUnknown) {
  EXPECT_STREQ(InputError({"a.nrrd", 0, 0}, "", "is truncated", "").what(), "a.nrrd: is truncated");
  EXPECT_STREQ(InputError({}, "engine.device", "\"x\" matches nothing", "expected auto").what(),
               "engine.device: \"x\" matches nothing; expected auto");
  EXPECT_EQ((SourceLocation{"a.csv", 3, 0}.text()), "a.csv:3");
}

TEST(MistakeList, ThrowsAllInTheOrderOfTheFile) {
  MistakeList list;
  EXPECT_TRUE(list.attempt([] {}));
  EXPECT_NO_THROW(list.throw_if_any());
  list.add(InputError({"a.yaml", 0, 0}, "bone", "missing", ""));
  EXPECT_FALSE(list.attempt([] { throw InputError({"a.yaml", 12, 7}, "tool.scale", "found -1", ""); }));
  list.add(InputError({"a.yaml", 3, 1}, "name", "found 2", "expected a text"));
  try {
    list.throw_if_any();
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "a.yaml:3:1: name: found 2; expected a text\na.yaml:12:7: tool.scale: found -1\na.yaml: bone: missing");
    EXPECT_EQ(error.mistakes().size(), 3U);
  }
}

TEST(MistakeList, KnowsWhatItConcerns) {
  MistakeList list;
  list.add(InputError({}, "bone.ct.path", "missing", ""));
  list.doubt("tool");
  for (const char* key : {"bone.ct.path", "bone.ct", "bone", "tool", "tool.mesh"})
    EXPECT_TRUE(list.concerns(key)) << key;
  for (const char* key : {"bone.ct.path_b", "bone.c", "bone.mesh", "motion", "tools"})
    EXPECT_FALSE(list.concerns(key)) << key;
  EXPECT_TRUE(list.has_key_in("bone.ct"));
  EXPECT_FALSE(list.has_key_in("bone"));
}

}  // namespace
}  // namespace reamsim
