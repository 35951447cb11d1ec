// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <map>

#include "tests/cli/cli_fixture.h"
#include "tests/scan/test_images.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Elements of a DICOM file that identify a patient (PS3.15, Table E.1-1), with texts that occur nowhere else.
const std::map<std::string, std::string> kIdentifying{
    {"0008|0050", "ACCESSION-55"},     {"0008|0080", "HOSPITAL-77"},    {"0008|0081", "STREET-88"},
    {"0008|0090", "REFERRING^DOCTOR"}, {"0008|1030", "STUDY-TEXT-12"},  {"0008|1050", "PERFORMING^DOCTOR"},
    {"0008|1070", "OPERATOR^ONE"},     {"0010|0010", "DOE^ZACHARIAS"},  {"0010|0020", "PATIENT-ID-314"},
    {"0010|0030", "19430217"},         {"0010|1040", "HOME-STREET-99"}, {"0010|4000", "PATIENT-COMMENT-5"},
    {"0018|1030", "PROTOCOL-NAME-6"},  {"0020|4000", "IMAGE-COMMENT-7"}};

class Privacy : public CliTest {
 protected:
  /// No file below `dir` holds one of the texts.
  void expect_none(const std::string& dir, const std::vector<std::string>& texts) const {
    int files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(path(dir))) {
      if (!entry.is_regular_file()) continue;
      ++files;
      const std::string bytes = file_bytes(entry.path().string());
      for (const std::string& text : texts) {
        EXPECT_EQ(bytes.find(text), std::string::npos) << entry.path() << " holds " << text;
      }
    }
    EXPECT_GT(files, 0);
  }
  ProgramResult at_home(const std::vector<std::string>& arguments) const {
    return reamsim(
        {.arguments = arguments, .environment = {{"HOME", path("home")}}, .folder = "", .interrupt_when = {}});
  }
};

const std::string kScan =
    "  source: ct\n  voxel_mm: 1\n  ct:\n    path: home/scan\n    threshold_hu: 200\n    closing_mm: 0\n";

TEST_F(Privacy, NothingThatIdentifiesAPatientIsWritten) {
  const TestImage egg = egg_image();
  write_dicom(egg, path("home/scan/a"), -1,
              {.series = "1.2.8.31337", .number = 2, .description = "SERIES-TEXT-1", .more = kIdentifying});
  write_dicom(cropped(egg, {0, 0, 0}, {26, 30, 20}), path("home/scan/b"), -1,
              {.series = "1.2.9.31338", .number = 3, .description = "SERIES-TEXT-2", .more = kIdentifying});
  std::vector<std::string> texts{"1.2.8.31337", "1.2.9.31338", "SERIES-TEXT", path("home")};
  for (const auto& [tag, text] : kIdentifying) texts.push_back(text);
  const std::string scans = file_bytes(path("home/scan/a/slice001.dcm")) + file_bytes(path("home/scan/b/slice001.dcm"));
  for (const auto& [tag, text] : kIdentifying) EXPECT_THAT(scans, HasSubstr(text)) << "the test would not find it";
  const std::string drawn =
      with(with_bone(kScan), "  enabled: false\n", "  width_px: 320\n  height_px: 240\n  report: true\n");
  write("s.yaml", with(drawn, "  plunge:\n", "  plunge:\n    entry_mm: [0, 0, 20]\n    axis: [0, 0, -1]\n"));
  const ProgramResult result = at_home({"run", "s.yaml", "-o", "home/out"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("1.2.8.31337"));  // on the terminal, to choose by
  expect_none("home/out", texts);
  fs::create_directory(path("home/grid"));
  const ProgramResult imported = at_home({"import", "home/scan", "-o", "home/grid/bone.vdb", "--set", "bone.voxel_mm=1",
                                          "--set", "bone.ct.threshold_hu=200", "--set", "bone.ct.closing_mm=0"});
  ASSERT_EQ(imported.status, 0) << imported.err;
  expect_none("home/grid", texts);
}

TEST_F(Privacy, TheHomeFolderIsAVariableThatReadsBack) {
  fs::create_directories(path("home/data"));
  fs::copy(REAMSIM_ROOT "/assets/reamer_flat.stl", path("home/data/flat.stl"));
  const std::string mesh = REAMSIM_ROOT "/assets/reamer_flat.stl";
  write("home/s.yaml", with(kSmall, mesh, "data/flat.stl"));
  ASSERT_EQ(at_home({"run", "home/s.yaml", "-o", "home/out"}).status, 0);
  expect_none("home/out", {path("home")});
  EXPECT_THAT(read("home/out/scenario.yaml"), HasSubstr("mesh: \"${HOME}/data/flat.stl\""));
  EXPECT_THAT(read("home/out/summary.json"), HasSubstr("\"${HOME}/s.yaml\""));
  ASSERT_EQ(at_home({"run", "home/out/scenario.yaml", "-o", "home/again"}).status, 0);
  EXPECT_EQ(read("home/again/forces.csv"), read("home/out/forces.csv"));
}

}  // namespace
}  // namespace reamsim::test
