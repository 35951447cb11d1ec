// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

class Cite : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  static int count(const std::string& text, const std::string& part) {
    int n = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
    return n;
  }
};

TEST_F(Cite, TheProgramWithoutARun) {
  const ProgramResult text = call({"cite"});
  EXPECT_EQ(text.status, 0) << text.err;
  for (const char* part : {"the reamsim authors", "Faieghi, M.", "10.1016/j.cmpb.2019.105263", "OpenVDB"}) {
    EXPECT_THAT(text.out, HasSubstr(part));
  }
  EXPECT_THAT(text.out, Not(HasSubstr("\nData")));
}

TEST_F(Cite, ARunHasWhatItUsed) {
  expect_done(run(kSmall));
  const std::string text = call({"cite", "out"}).out;
  EXPECT_THAT(text, HasSubstr("Scardovelli")) << "exact erosion";
  EXPECT_THAT(text, Not(HasSubstr("Aslam"))) << "no scan";
  EXPECT_THAT(text, Not(HasSubstr("pocl"))) << "the serial engine";
  EXPECT_THAT(read("out/CITATION.txt"), HasSubstr(text));
  EXPECT_THAT(read("out/manifest.json"), HasSubstr("CITATION.txt"));
  EXPECT_EQ(run(kSmall, {"--overwrite"}).status, 0) << "the file is one of reamsim's";
}

TEST_F(Cite, TheEngineOfTheRun) {
  const std::string old = REAMSIM_ROOT "/tests/cli/results_0_1_0/results/";
  std::filesystem::create_directory(path("octree"));
  std::filesystem::copy(old + "scenario.yaml", path("octree/scenario.yaml"));
  const std::string summary = with(file_bytes(old + "summary.json"), "\"engine\": \"exact\"", "\"engine\": \"octree\"");
  write("octree/summary.json", with(summary, "\"erosion\": \"exact\"", "\"erosion\": \"remove\""));
  const std::string text = call({"cite", "octree"}).out;
  EXPECT_THAT(text, HasSubstr("Zheng et al., its reference 33"));
  EXPECT_THAT(text, Not(HasSubstr("Scardovelli")));
  EXPECT_THAT(text, Not(HasSubstr("MacAvelia")));
  Json drilled = Json::parse(summary);
  drilled["force_law"]["preset"] = "drill-human-femur";
  write("octree/summary.json", drilled.dump());
  EXPECT_THAT(call({"cite", "octree"}).out, HasSubstr("MacAvelia"));
}

TEST_F(Cite, APublicScanByItsSum) {
  const std::string old = REAMSIM_ROOT "/tests/cli/results_0_1_0/results/";
  std::filesystem::create_directory(path("ct"));
  std::filesystem::copy(old + "scenario.yaml", path("ct/scenario.yaml"));
  Json summary = Json::parse(file_bytes(old + "summary.json"));
  summary["segmentation"] = {{"method", "threshold"}};
  summary["inputs"].push_back({{"role", "bone.ct.path"},
                               {"path", "scan.nrrd"},
                               {"sha256", "67e5af7b99fbdeb342fb9b01b5c3e4e0f07da4fa79614dbdc76838baed767c96"}});
  write("ct/summary.json", summary.dump());
  const std::string text = call({"cite", "ct"}).out;
  for (const char* part :
       {"LIDC-IDRI", "10.7937/K9/TCIA.2015.LO9QL9SX", "CC BY 3.0", "Aslam", "Knowles", "McCormick"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("scan.nrrd")));
  write("ct/scenario.yaml", with(read("ct/scenario.yaml"), "ash_fraction: 0.6", "ash_fraction: 0.5"));
  const std::string own = call({"cite", "ct"}).out;
  EXPECT_THAT(own, Not(HasSubstr("Knowles")));
  EXPECT_THAT(own, HasSubstr("the source of your relation"));
}

TEST_F(Cite, AnUnknownInputByItsSum) {
  write("poses.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n0.2,0,0,-1,1,0,0,0\n");
  expect_done(run(kSmall, {"--set", "motion.plunge=null", "--set", "motion.csv.path=poses.csv"}));
  const Json summary = Json::parse(read("out/summary.json"));
  const std::string text = call({"cite", "out"}).out;
  EXPECT_THAT(text, HasSubstr("motion.csv.path, poses.csv"));
  EXPECT_THAT(text, HasSubstr("SHA-256 " + summary["inputs"].back()["sha256"].get<std::string>()));
}

TEST_F(Cite, BibtexAndJsonHaveTheSameEntries) {
  const std::string old = REAMSIM_ROOT "/tests/cli/results_0_1_0/results";
  const std::string bibtex = call({"cite", old, "--bibtex"}).out;
  const Json items = Json::parse(call({"cite", old, "--json"}).out);
  ASSERT_GE(items.size(), 4U);
  for (const Json& item : items) {
    EXPECT_THAT(bibtex, HasSubstr("{" + item["id"].get<std::string>() + ",\n"));
    EXPECT_TRUE(item.contains("type") && item.contains("title")) << item;
  }
  EXPECT_EQ(count(bibtex, "\n@") + 1, static_cast<int>(items.size()));
  EXPECT_EQ(count(bibtex, "{"), count(bibtex, "}"));
  EXPECT_EQ(items[1]["author"][1]["family"], "Tutunea-Fatan");
  EXPECT_EQ(items[1]["issued"]["date-parts"][0][0], 2020);
}

constexpr auto overwrite = std::filesystem::copy_options::overwrite_existing;

TEST_F(Cite, AStudyAndAComparisonHaveWhatTheirRunsUsed) {
  const std::string old = REAMSIM_ROOT "/tests/cli/results_0_1_0/results/";
  for (const std::string run : {"phantom", "ct", "broken"}) {
    std::filesystem::create_directories(path("study/runs/" + run));
    std::filesystem::copy(old + "scenario.yaml", path("study/runs/" + run + "/scenario.yaml"));
  }
  write("study/study.json", "{}");
  write("study/runs/broken/summary.json", "{");
  std::filesystem::copy(old + "summary.json", path("study/runs/phantom/summary.json"));
  Json summary = Json::parse(file_bytes(old + "summary.json"));
  summary["program"] = "reamsim " REAMSIM_VERSION;
  summary["segmentation"] = {{"method", "threshold"}};
  const std::string sum(64, 'a');
  for (int i = 0; i < 2; ++i)
    summary["inputs"].push_back({{"role", "bone.ct.path"}, {"path", "s.nrrd"}, {"sha256", sum}});
  summary["inputs"].push_back({{"role", "bone.ct.label_map.path"}, {"path", "without_a_sum.nrrd"}});
  write("study/runs/ct/summary.json", summary.dump());
  const std::string text = call({"cite", "study"}).out;
  for (const char* part : {"Scardovelli", "Aslam", "0.1.0", REAMSIM_VERSION, "s.nrrd", "without_a_sum.nrrd"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_EQ(count(text, "10.1016/j.cmpb.2019.105263"), 1) << "each work once";
  EXPECT_EQ(count(text, sum), 1);

  // A run whose scenario is damaged is left out; so is one that is not in the table, or is not finished.
  write("study/runs/ct/scenario.yaml", "[");
  const std::string without_ct = call({"cite", "study"}).out;
  EXPECT_THAT(without_ct, AllOf(HasSubstr("0.1.0"), Not(HasSubstr("Aslam")), Not(HasSubstr(REAMSIM_VERSION))));
  std::filesystem::copy(old + "scenario.yaml", path("study/runs/ct/scenario.yaml"), overwrite);
  EXPECT_EQ(call({"cite", "study"}).out, text);
  std::filesystem::rename(path("study/runs/ct"), path("study/runs/ct.partial"));
  EXPECT_EQ(call({"cite", "study"}).out, without_ct);
  std::filesystem::rename(path("study/runs/ct.partial"), path("study/runs/ct"));
  write("study/runs.csv", "run,id,status,message\n1,phantom,done,\n2,ct,failed,\"a, b\"\n");
  EXPECT_EQ(call({"cite", "study"}).out, without_ct);

  expect_done(run(kSmall));
  ASSERT_EQ(
      reamsim({.arguments = {"run", "s.yaml", "-o", "slow", "--set", "motion.plunge.feed_mm_s=4", "--device", "serial"},
               .environment = {},
               .folder = "",
               .interrupt_when = {}})
          .status,
      0);
  ASSERT_EQ(call({"compare", "out", "slow", "-o", "compared"}).status, 0);
  EXPECT_THAT(read("compared/CITATION.txt"), HasSubstr("Scardovelli")) << "exact erosion";
  const ProgramResult refused = call({"cite", "compared"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("compared"), HasSubstr("CITATION.txt")));
}

TEST_F(Cite, ARunWhoseSummaryIsAFolderIsLeftOut) {
  const std::string old = REAMSIM_ROOT "/tests/cli/results_0_1_0/results/";
  std::filesystem::create_directories(path("study/runs/good"));
  std::filesystem::create_directories(path("study/runs/bad/summary.json"));
  write("study/study.json", "{}");
  for (const char* file : {"scenario.yaml", "summary.json"})
    std::filesystem::copy(old + file, path("study/runs/good/") + file);
  const ProgramResult result = call({"cite", "study"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Scardovelli"));
  expect_refused(call({"cite", "study/runs/bad"}), 2, {"summary.json", "cannot be read"});
}

TEST_F(Cite, NoResults) {
  expect_refused(call({"cite", "nix"}), 2, {"nix", "not found"});
  std::filesystem::create_directory(path("empty"));
  expect_refused(call({"cite", "empty"}), 2, {"empty", "holds no results"});
  expect_refused(call({"cite", "--json", "--bibtex"}), 2, {"--json"});
}

TEST_F(Cite, DamagedSummary) {
  std::filesystem::create_directory(path("damaged"));
  write("damaged/summary.json", "{");
  expect_refused(call({"cite", "damaged"}), 2, {"damaged/summary.json", "is damaged"});
}

}  // namespace
}  // namespace reamsim::test
