// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace reamsim::ct {
namespace {

using ::testing::HasSubstr;

std::string error_of(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments, int layers) {
  try {
    find_labels(wanted, segments, layers, "map.seg.nrrd");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(LabelNames, OfSlicersLayers) {
  const auto segments = segments_of_nrrd({{"Segment0_ID", "Segment_1"},
                                          {"Segment0_Name", "humerus"},
                                          {"Segment0_Layer", "1"},
                                          {"Segment0_LabelValue", "3"},
                                          {"Segment1_ID", "Segment_2"},
                                          {"Segment1_Layer", "0"},
                                          {"Segment1_LabelValue", "1"},
                                          {"Segmentation_Other", "x"}},
                                         2);
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[0].name, "humerus");
  EXPECT_EQ(segments[0].label.layer, 1);
  EXPECT_EQ(segments[0].label.value, 3);
  EXPECT_EQ(segments[1].name, "Segment_2") << "the ID where there is no name";
}

TEST(LabelNames, ALayerOrAValueThatIsNoWholeNumberIsNoOtherOne) {
  const std::vector<std::pair<std::string, std::string>> damaged{
      {"Segment0_Layer", "-1"}, {"Segment0_Layer", "1.5"}, {"Segment0_Layer", "x"}, {"Segment0_LabelValue", "abc"}};
  for (const auto& [key, text] : damaged) {
    const auto segments = segments_of_nrrd({{"Segment0_Name", "a"}, {key, text}}, 2);
    ASSERT_EQ(segments.size(), 1U);
    EXPECT_GE(segments[0].label.layer, 2) << key << " " << text << ": no layer of the map";
  }
}

TEST(LabelNames, OlderFilesHaveALayerPerSegment) {
  const auto segments = segments_of_nrrd({{"Segment0_Name", "a"}, {"Segment1_Name", "b"}}, 2);
  ASSERT_EQ(segments.size(), 2U);
  EXPECT_EQ(segments[1].label.layer, 1);
  EXPECT_EQ(segments[1].label.value, 1);
}

TEST(LabelNames, NamesAreMatchedWholeAndWithoutCase) {
  const std::vector<NamedSegment> segments{{"Scapula_Left", {0, 2}}, {"scapula_right", {1, 2}}};
  const auto found = find_labels({"scapula_left", "SCAPULA_RIGHT"}, segments, 2, "map.seg.nrrd");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].layer, 0);
  EXPECT_EQ(found[1].layer, 1);
  EXPECT_THAT(error_of({"scapula"}, segments, 2),
              HasSubstr("map.seg.nrrd: bone.ct.label_map.label: no segment is named "
                        "'scapula'; expected one of Scapula_Left, scapula_right"));
  EXPECT_THAT(error_of({"scapula"}, {}, 1), HasSubstr("the label map names no segments"));
}

TEST(LabelNames, NumbersThatTellNoLayer) {
  const std::vector<NamedSegment> segments{{"a", {0, 1}}, {"b", {1, 1}}, {"c", {1, 2}}};
  EXPECT_EQ(find_labels({"2"}, segments, 2, "m").front().layer, 1);
  EXPECT_THAT(error_of({"1"}, segments, 2), HasSubstr("label 1 stands for 2 segments of a label map with 2 layers"));
  EXPECT_THAT(error_of({"7"}, segments, 2), HasSubstr("no segment has label 7; choose a segment by its name: a, b, c"));
  EXPECT_THAT(error_of({"0"}, {}, 1), HasSubstr("label 0 is the background"));
  EXPECT_THAT(error_of({"1"}, {}, 3), HasSubstr("3 layers, none of them named"));
  EXPECT_THAT(error_of({"d"}, {{"d", {5, 1}}}, 2), HasSubstr("'d' is in layer 5, but the label map has 2"));
}

TEST(LabelNames, ANumberThatIsAlsoTheNameOfAnotherSegmentIsRefused) {
  const std::vector<NamedSegment> segments{{"humerus", {0, 1}}, {"1", {0, 7}}, {"2", {0, 2}}};
  EXPECT_THAT(error_of({"1"}, segments, 1),
              HasSubstr("'1' is ambiguous: label 1, or the segment named '1', whose label is 7"));
  EXPECT_EQ(find_labels({"2"}, segments, 1, "m").front().value, 2) << "name and number agree";
  EXPECT_EQ(find_labels({"7"}, segments, 1, "m").front().value, 7);
}

}  // namespace
}  // namespace reamsim::ct
