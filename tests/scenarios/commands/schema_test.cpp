// The JSON Schemas, held against an independent validator: what we ship is good, what the parser refuses is bad.

#include "scenarios/code/commands/schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Debian's python3-jsonschema, which knows nothing of gaitcam. Its arguments are pairs of schema and file; it prints a
/// line per error, or per file without one.
constexpr const char* kValidator = R"py(
import json
import re
import sys

import jsonschema
import yaml

# 2e-05 is a number in YAML 1.2, as yaml-cpp and editors read it.
yaml.SafeLoader.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(r"^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"),
                                      list("-+0123456789"))
for schema_file, file in zip(sys.argv[1::2], sys.argv[2::2]):
    with open(schema_file) as stream:
        schema = json.load(stream)
    jsonschema.Draft202012Validator.check_schema(schema)
    with open(file) as stream:
        errors = list(jsonschema.Draft202012Validator(schema).iter_errors(yaml.safe_load(stream)))
    for error in errors:
        print(f"{file}: bad: {'.'.join(map(str, error.path))}: {error.message[:200]}")
    if not errors:
        print(f"{file}: good")
)py";

class SchemaTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const std::string& kind : SchemaKinds()) std::ofstream(SchemaFile(kind)) << FileSchema(kind).dump();
    std::ofstream(temporary_.path() / "validate.py") << kValidator;
    if (RunShell("/usr/bin/python3 -c 'import jsonschema, yaml'", temporary_.path()).exit_code != 0)
      GTEST_SKIP() << "no python3-jsonschema or python3-yaml on this machine";
  }

  std::string SchemaFile(const std::string& kind) const { return (temporary_.path() / (kind + ".json")).string(); }
  /// @param pairs kind and file, both quoted for a shell.
  std::string Validate(const std::vector<std::pair<std::string, std::string>>& pairs) const {
    std::string command = "/usr/bin/python3 validate.py";
    for (const auto& [kind, file] : pairs) command += " " + SchemaFile(kind) + " " + file;
    const ProgramResult result = RunShell(command, temporary_.path());
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
  /// What the validator says of a text, and the parser of the same.
  std::string ValidateText(const std::string& kind, const std::string& text) const {
    std::ofstream(temporary_.path() / "planted.yaml") << text;
    return Validate({{kind, "planted.yaml"}});
  }

  const TemporaryFolder temporary_;
};

TEST_F(SchemaTest, EveryFileThatWeShipIsGood) {
  const std::pair<const char*, const char*> folders[] = {{"scenario", "scenarios"},
                                                         {"study", "scenarios/studies"},
                                                         {"suite", "scenarios/suites"},
                                                         {"matrix", "scenarios/matrices"}};
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const auto& [kind, folder] : folders) {
    for (const auto& entry : fs::directory_iterator(TestData() / folder)) {
      if (entry.path().extension() == ".yaml") pairs.emplace_back(kind, entry.path().string());
    }
  }
  ASSERT_GE(pairs.size(), 8u);
  const std::string said = Validate(pairs);
  EXPECT_THAT(said, testing::Not(HasSubstr(": bad: "))) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), long(pairs.size()));
}

TEST_F(SchemaTest, AResolvedScenarioWithEveryDefaultWrittenOutIsGood) {
  setenv("GAITCAM_DATA", TestData().c_str(), 1);
  const std::string said =
      ValidateText("scenario", ReadScenario(TestData() / "scenarios/quickstart.yaml", {"start=[0,0,90]"}).ToYaml());
  EXPECT_THAT(said, HasSubstr(": good"));
  for (const std::string renderer : {"auto", "gpu", "software", "device:0", "device:12"})
    EXPECT_THAT(ValidateText("scenario", "camera: {renderer: '" + renderer + "'}\n"), HasSubstr(": good")) << renderer;
}

TEST_F(SchemaTest, BlocksWithPresetsAreWordsOrMaps) {
  for (const std::string text :
       {"calibration_error: bench", "calibration_error: {preset: bench, pitch_deg: 1}", "variation: repeat",
        "variation: {light_ratio: 0.5}", "camera: {preset: cmos, jpeg: {quality: 80}, auto_exposure: {enabled: false}}",
        "system: {name: floor_slam, tracker: {alignment: {max_blur_samples: 1}}}",
        "system: {name: floor_slam, tracker.alignment.max_blur_samples: 1}"})
    EXPECT_THAT(ValidateText("scenario", text + "\n"), HasSubstr(": good")) << text;
  EXPECT_THAT(ValidateText("study", "{base: a.yaml, axes: {calibration_error.focal_pct: [0, 1], variation: [none]}}\n"),
              HasSubstr(": good"));
}

TEST_F(SchemaTest, PlantedErrorsAreBad) {
  const std::pair<const char*, const char*> planted[] = {
      {"scenario", "gait: {perid_s: 0.3}"},
      {"scenario", "duration_s: long"},
      {"scenario", "duration_s: -1"},
      {"scenario", "seed: 1.5"},
      {"scenario", "camera: {exposure_ms: 900}"},
      {"scenario", "camera: 3"},
      {"scenario", "camera: {renderer: fast}"},
      {"scenario", "camera: {renderer: 'device:-1'}"},
      {"scenario", "start: [1, 2]"},
      {"scenario", "calibration_error: benhc"},
      {"scenario", "calibration_error: {focal_pct: -1}"},
      {"scenario", "variation: true"},
      {"scenario", "variation: {start: 1}"},
      {"scenario", "camera: {preset: coms}"},
      {"scenario", "camera: {jpeg: {quality: 0}}"},
      {"scenario", "system: sift_v0"},
      {"scenario", "system: {ratio: 0.8}"},
      {"scenario", "system: {name: sift_vo, ration: 0.8}"},
      {"scenario", "system: {name: floor_slam, tracker: {alignment: {blur: 1}}}"},
      {"scenario", "system: {command: []}"},
      {"scenario", "system: {command: [a], format: tom}"},
      {"scenario", "score: {rpe_pairs: some}"},
      {"study", "axes: {seed: [1]}"},
      {"study", "base: a.yaml"},
      {"study", "{base: a.yaml, axes: {}}"},
      {"study", "{base: a.yaml, axes: {camera.exposure_ms: []}}"},
      {"study", "{base: a.yaml, axes: {camera.exposure_ms: [1, 1]}}"},
      {"study", "{base: a.yaml, axes: {camera.exposure_ms: [1, 900]}}"},
      {"study", "{base: a.yaml, axes: {camera.exposure: 3}}"},
      {"study", "{base: a.yaml, axes: {camera.exposre_ms: [3]}}"},
      {"study", "{base: a.yaml, axes: {seed: [1]}, list: [{seed: 1}]}"},
      {"study", "{base: a.yaml, axes: {seed: [1]}, seeds: 0}"},
      {"study", "{base: a.yaml, axes: {seed: [1]}, seeds: []}"},
      {"study", "{base: a.yaml, axes: {seed: [1]}, set: {duration: 3}}"},
      {"study", "{base: a.yaml, axes: {seed: [1]}, confidence: 95}"},
      {"suite", "scenarios: []"},
      {"suite", "{scenarios: [{scenario: a.yaml}], systems: [sift_vo], seeds: 0, metrics: [{name: a}]}"},
      {"suite", "{scenarios: [{scenario: a.yaml}], systems: [sift_vo], seeds: 5, metrics: [{nome: a}]}"},
      {"suite", "{scenarios: [{scenario: a.yaml}], systems: [sift], seeds: 5, metrics: [{name: a}]}"},
      {"matrix", "{base: a.yaml, format: kitti}"},
      {"matrix", "{base: a.yaml, pairs: {evry: 3}}"},
      {"matrix", "{base: a.yaml, pairs: 3}"},
      {"matrix", "{axes: {seed: [1]}}"}};
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const auto& [kind, text] : planted) {
    const std::string name = "planted" + std::to_string(pairs.size()) + ".yaml";
    std::ofstream(temporary_.path() / name) << text << "\n";
    pairs.emplace_back(kind, name);
  }
  const std::string said = Validate(pairs);
  for (size_t i = 0; i < pairs.size(); ++i)
    EXPECT_THAT(said, HasSubstr(pairs[i].second + ": bad: ")) << planted[i].first << ": " << planted[i].second;
}

// The same keys, limits and words as the parser's, because both read the same descriptions.
TEST_F(SchemaTest, TellsLimitsWordsDefaultsAndMeaning) {
  const Schema exposure = FileSchema("scenario")["properties"]["camera"]["properties"]["exposure_ms"];
  EXPECT_EQ(exposure["type"], "number");
  EXPECT_EQ(exposure["minimum"], 0);
  EXPECT_EQ(exposure["maximum"], 200);
  EXPECT_TRUE(exposure.contains("default"));
  EXPECT_FALSE(exposure["description"].get<std::string>().empty());
  const Schema pairs = FileSchema("scenario")["properties"]["score"]["properties"]["rpe_pairs"];
  EXPECT_EQ(pairs["enum"], Schema({"all", "consecutive"}));
  const Schema renderer = FileSchema("scenario")["properties"]["camera"]["properties"]["renderer"];
  EXPECT_EQ(renderer["default"], "auto");
  EXPECT_FALSE(renderer["description"].get<std::string>().empty());
  EXPECT_EQ(FileSchema("study")["$defs"]["axes"]["properties"]["camera.exposure_ms"]["items"]["$ref"],
            "#/$defs/scenario/properties/camera/properties/exposure_ms");
}

TEST_F(SchemaTest, TheProgramPrintsThem) {
  for (const std::string& kind : SchemaKinds()) {
    const ProgramResult result = RunProgram("schema " + kind, temporary_.path());
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(Schema::parse(result.out), FileSchema(kind));
  }
  EXPECT_EQ(RunProgram("schema robot", temporary_.path()).exit_code, 2);
  EXPECT_THROW(FileSchema("robot"), BadInput);
}

}  // namespace
}  // namespace gaitcam
