// Files of many scenarios: what they stand for, and what is refused.

#include "scenarios/code/files/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "models/code/yaml/yaml_reader.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ExperimentTest : public testing::Test {
 protected:
  Experiment Read(const std::string& yaml, bool yes = false) {
    std::ofstream(temporary_.path() / "base.yaml") << "duration_s: 5\nvideo: {enabled: false}\n";
    std::ofstream(temporary_.path() / "e.yaml") << yaml;
    const OptionValue root = LoadYaml(temporary_.path() / "e.yaml");
    ExperimentOptions options;
    ReadOption(root, options);
    return ResolveExperiment(root, options, yes);
  }
  void ExpectRefusal(const std::string& yaml, const std::string& fragment) {
    try {
      Read(yaml);
      ADD_FAILURE() << "accepted: " << yaml;
    } catch (const BadInput& e) {
      EXPECT_THAT(e.what(), HasSubstr(fragment));
      EXPECT_THAT(e.what(), testing::Not(HasSubstr("\n")));
    }
  }

  const TemporaryFolder temporary_;
};

TEST_F(ExperimentTest, AxesGiveAllCombinationsTheLastOneFastest) {
  const Experiment e = Read(
      "base: base.yaml\naxes:\n  gait.preset: [slow, normal]\n  camera.exposure_ms: [0, 20]\n  system: "
      "[sift_vo]\nseeds: 3\n");
  EXPECT_THAT(e.keys, ElementsAre("gait.preset", "camera.exposure_ms", "system"));
  ASSERT_EQ(e.conditions.size(), 4U);
  EXPECT_EQ(e.runs(), 12U);
  EXPECT_EQ(e.conditions[1].Label(), "preset=slow, exposure_ms=20, system=sift_vo");
  EXPECT_EQ(e.conditions[1].resolved.scenario.camera.exposure.exposure_ms, 20);
  EXPECT_EQ(e.conditions[2].resolved.scenario.gait.preset, "normal");
  EXPECT_THAT(e.options.seeds, ElementsAre(1, 2, 3));
  EXPECT_EQ(e.conditions[0].resolved.scenario.duration_s, 5);
}

TEST_F(ExperimentTest, AListNamesItsConditionsOneByOneAndASystemMayBeAMap) {
  const Experiment e = Read(
      "base: base.yaml\nset: {duration_s: 2}\nlist:\n"
      "  - {system: {name: sift_vo, ratio: 0.7}}\n  - {camera.exposure_ms: 5}\nseeds: [4, 9]\n");
  ASSERT_EQ(e.conditions.size(), 2U);
  EXPECT_EQ(e.conditions[0].resolved.scenario.system.settings.at("ratio").AsNumber(), 0.7);
  EXPECT_EQ(e.conditions[1].resolved.scenario.duration_s, 2);
  EXPECT_EQ(e.conditions[1].WithSeed(9).scenario.seed, 9U);
  EXPECT_THAT(e.options.seeds, ElementsAre(4, 9));
}

TEST_F(ExperimentTest, APartOfAKeyMayBeSetAfterTheWholeAndTheSameKeyAnew) {
  const Experiment e =
      Read("base: base.yaml\nset: {camera: {rate_hz: 10}, camera.exposure_ms: 4}\naxes: {camera.exposure_ms: [20]}\n");
  EXPECT_EQ(e.conditions[0].resolved.scenario.camera.rate_hz, 10);
  EXPECT_EQ(e.conditions[0].resolved.scenario.camera.exposure.exposure_ms, 20);
}

TEST_F(ExperimentTest, HashesTellScenariosApartAndFramesHashesDoNotSeeTheSystem) {
  const Experiment e =
      Read("base: base.yaml\naxes:\n  camera.exposure_ms: [0, 20]\n  system: [sift_vo, {name: sift_vo, ratio: 0.7}]\n");
  std::set<std::string> hashes, frames;
  for (const Condition& condition : e.conditions) {
    for (const uint64_t seed : {1, 2}) {
      hashes.insert(HashOf(condition.WithSeed(seed)));
      frames.insert(FramesHashOf(condition.WithSeed(seed)));
    }
  }
  EXPECT_EQ(hashes.size(), 8U);
  EXPECT_EQ(frames.size(), 4U);
}

TEST_F(ExperimentTest, TheHashSurvivesWritingOutAndAnotherNameOrFilm) {
  const Experiment e = Read("base: base.yaml\naxes: {camera.exposure_ms: [3]}\n");
  const ResolvedScenario& scenario = e.conditions[0].resolved;
  std::ofstream(temporary_.path() / "again.yaml") << scenario.ToYaml();
  EXPECT_EQ(HashOf(ReadScenario(temporary_.path() / "again.yaml", {"name=other", "video.enabled=true"})),
            HashOf(scenario));
  EXPECT_NE(HashOf(ReadScenario(temporary_.path() / "again.yaml", {"system_seed=5"})), HashOf(scenario));
}

/// What names a recorded walk: whoever changes only these reads the frames that are there.
TEST_F(ExperimentTest, SystemHandicapScoreAndFilmChangeNoFrames) {
  Read("base: base.yaml\naxes: {camera.exposure_ms: [3]}\n");
  const std::filesystem::path file = temporary_.path() / "base.yaml";
  const ResolvedScenario scenario = ReadScenario(file, {});
  for (const char* change : {"system=orb_vo", "system_seed=5", "handicap.drop_every=5", "score.min_coverage_ratio=0.1",
                             "score.min_pairs=3", "video.enabled=true", "video.height_px=240", "name=other",
                             "description=other", "camera.renderer=software", "camera.renderer=device:3"}) {
    EXPECT_EQ(FramesHashOf(ReadScenario(file, {change})), FramesHashOf(scenario)) << change;
  }
  for (const char* change : {"seed=5", "camera.exposure_ms=7", "gait.preset=brisk", "scene=hall", "duration_s=9"}) {
    EXPECT_NE(FramesHashOf(ReadScenario(file, {change})), FramesHashOf(scenario)) << change;
  }
}

/// Two renderers' runs lie in two folders, but are compared with the same baseline.
TEST_F(ExperimentTest, TheRendererNamesARunYetNotWhatItsScoresAreComparedWith) {
  const Experiment e = Read("base: base.yaml\naxes: {camera.renderer: [auto, software, device:1]}\n");
  ASSERT_EQ(e.conditions.size(), 3U);
  std::set<std::string> hashes, comparable;
  for (const Condition& condition : e.conditions) {
    hashes.insert(HashOf(condition.resolved));
    comparable.insert(HashOf(condition.resolved.OnAnyRenderer()));
  }
  EXPECT_EQ(hashes.size(), 3U);
  EXPECT_THAT(comparable, ElementsAre(HashOf(e.conditions[0].resolved)));
  EXPECT_THAT(e.conditions[0].resolved.ToYaml(), testing::Not(HasSubstr("renderer")));
  EXPECT_THAT(e.conditions[2].resolved.ToYaml(), HasSubstr("\n  renderer: device:1\n"));
  std::ofstream(temporary_.path() / "again.yaml") << e.conditions[2].resolved.ToYaml();
  EXPECT_EQ(HashOf(ReadScenario(temporary_.path() / "again.yaml", {})), HashOf(e.conditions[2].resolved));
}

/// A scene's file says where a picture lies, not what it shows.
TEST_F(ExperimentTest, APictureThatASceneNamesIsHashedByWhatItShows) {
  const auto paint = [&](int grey) {
    cv::imwrite((temporary_.path() / "floor.png").string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar::all(grey)));
  };
  std::ofstream(temporary_.path() / "room.yaml") << "floor: {texture: {kind: image, file: floor.png}}\n";
  std::ofstream(temporary_.path() / "walk.yaml") << "scene: ./room.yaml\n";
  const auto hash = [&] { return FramesHashOf(ReadScenario(temporary_.path() / "walk.yaml", {})); };
  paint(100);
  const std::string first = hash();
  paint(200);
  EXPECT_NE(hash(), first);
  paint(100);
  EXPECT_EQ(hash(), first);
}

TEST_F(ExperimentTest, BadFilesAreToldApart) {
  ExpectRefusal("axes: {seed: [1]}\n", "expected the key `base`");
  ExpectRefusal("base: none.yaml\n", "none.yaml: cannot read");
  ExpectRefusal("base: base.yaml\naxis: {}\n", "e.yaml:2:1: axis: unknown key; did you mean axes?");
  ExpectRefusal("base: base.yaml\naxes: {}\n", "e.yaml:2:7: axes: expected a map");
  ExpectRefusal("base: base.yaml\naxes: {duration_s: []}\n", "axes.duration_s: expected a list of at least one value");
  ExpectRefusal("base: base.yaml\naxes: {duration_s: [1, 1]}\n", "1 is there twice");
  ExpectRefusal("base: base.yaml\naxes: {durations: [1]}\n",
                "axes.durations[0]: unknown key; did you mean duration_s?");
  ExpectRefusal("base: base.yaml\naxes: {place: [lab]}\n", "e.yaml:2:16: axes.place[0]: this key is called scene now");
  ExpectRefusal("base: base.yaml\nset: {place: lab}\n", "e.yaml:2:14: set.place: this key is called scene now");
  ExpectRefusal("base: base.yaml\naxes: {duration_s: [long]}\n",
                "e.yaml:2:21: axes.duration_s[0]: \"long\" is not a number");
  ExpectRefusal("base: base.yaml\nset: {camera.rate_hz: 10}\naxes: {camera: [{preset: cmos}]}\n",
                "e.yaml:3:17: axes.camera[0]: would replace all of camera, also camera.rate_hz, which was set before");
  ExpectRefusal("base: base.yaml\nlist: [{system.ratio: 0.7, system: sift_vo}]\n", "say ratio in it, too");
  ExpectRefusal("base: base.yaml\nlist: [{duration_s: 1}]\naxes: {duration_s: [1]}\n", "not both");
  ExpectRefusal("base: base.yaml\nseeds: 0\n", "e.yaml:2:8: seeds: expected a number of seeds of 1 to");
  ExpectRefusal("base: base.yaml\nseeds: [1, 1]\n", "this seed is there twice");
  ExpectRefusal("base: base.yaml\nseeds: many\n", "seeds: \"many\" is not a whole number");
  ExpectRefusal("base: base.yaml\naxes: {duration_s: [1, 2]}\nseeds: 60000\n", "120000 runs; more than 100000");
}

TEST_F(ExperimentTest, ManyRunsAreAllowedWhenAskedFor) {
  EXPECT_EQ(Read("base: base.yaml\naxes: {duration_s: [1, 2]}\nseeds: 60000\n", true).runs(), 120000U);
}

}  // namespace
}  // namespace gaitcam
