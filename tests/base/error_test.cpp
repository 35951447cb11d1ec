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

}  // namespace
}  // namespace reamsim
