// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/dicom_tags.h"

namespace reamsim::ct {

namespace {

constexpr SeparatingTag kTags[] = {{"AcquisitionNumber", {0x0020, 0x0012}},
                                   {"FrameAcquisitionNumber", {0x0020, 0x9156}, DicomType::us},
                                   {"TemporalPositionIdentifier", {0x0020, 0x0100}},
                                   {"TemporalPositionIndex", {0x0020, 0x9128}, DicomType::ul},
                                   {"NominalPercentageOfCardiacPhase", {0x0020, 0x9241}, DicomType::fd},
                                   {"TriggerTime", {0x0018, 0x1060}},
                                   {"NominalCardiacTriggerDelayTime", {0x0020, 0x9153}, DicomType::fd},
                                   {"TemporalPositionTimeOffset", {0x0020, 0x930d}, DicomType::fd},
                                   {"EchoNumbers", {0x0018, 0x0086}},
                                   {"EchoTime", {0x0018, 0x0081}},
                                   {"EffectiveEchoTime", {0x0018, 0x9082}, DicomType::fd},
                                   {"ConvolutionKernel", {0x0018, 0x1210}},
                                   {"FilterType", {0x0018, 0x1160}},
                                   {"ReconstructionAlgorithm", {0x0018, 0x9315}},
                                   {"ImageType", {0x0008, 0x0008}},
                                   {"FrameType", {0x0008, 0x9007}},
                                   {"KVP", {0x0018, 0x0060}},
                                   {"ReferencedSegmentNumber", {0x0062, 0x000b}, DicomType::us},
                                   {"StackID", {0x0020, 0x9056}},
                                   {"SliceThickness", {0x0018, 0x0050}},
                                   {"ReconstructionDiameter", {0x0018, 0x1100}},
                                   {"ContrastBolusAgent", {0x0018, 0x0010}},
                                   {"SeriesNumber", {0x0020, 0x0011}},
                                   {"SeriesDescription", {0x0008, 0x103e}},
                                   {"StudyInstanceUID", {0x0020, 0x000d}, DicomType::text, true},
                                   {"FrameOfReferenceUID", {0x0020, 0x0052}, DicomType::text, true},
                                   {"IrradiationEventUID", {0x0008, 0x3010}, DicomType::text, true},
                                   {"AcquisitionDateTime", {0x0008, 0x002a}, DicomType::text, true},
                                   {"FrameAcquisitionDateTime", {0x0018, 0x9074}, DicomType::text, true},
                                   {"FrameReferenceDateTime", {0x0018, 0x9151}, DicomType::text, true},
                                   {"AcquisitionTime", {0x0008, 0x0032}, DicomType::text, true},
                                   {"ContentTime", {0x0008, 0x0033}, DicomType::text, true},
                                   {"SeriesTime", {0x0008, 0x0031}, DicomType::text, true},
                                   {"AcquisitionDate", {0x0008, 0x0022}, DicomType::text, true},
                                   {"ContentDate", {0x0008, 0x0023}, DicomType::text, true},
                                   // Of multi-frame files; those of slices all differ.
                                   {"InstanceNumber", {0x0020, 0x0013}, DicomType::text, true},
                                   {"SOPInstanceUID", {0x0008, 0x0018}, DicomType::text, true}};

}  // namespace

std::span<const SeparatingTag> separating_tags() {
  return kTags;
}

void add_tags(const DicomValues& values, std::map<std::string, std::string>& tags) {
  for (const SeparatingTag& tag : kTags) {
    const std::string value = values.text_of(tag.tag, tag.type);
    if (!value.empty()) tags[tag.keyword] = value;
  }
}

}  // namespace reamsim::ct
