// What a user who slips gets: one line that says where and what would be right, exit 2, and nothing written.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

class BadInputTest : public testing::Test {
 protected:
  /// Writes `yaml` as s.yaml, calls a verb on it and expects one line with `fragment` and nothing new in the folder.
  void ExpectRefusal(const std::string& yaml, const std::string& fragment, const std::string& more = "",
                     const std::string& verb = "run") {
    std::ofstream(temporary_.path() / "s.yaml") << yaml;
    const ProgramResult result = RunProgram(verb + " s.yaml " + more, temporary_.path());
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_LT(result.err.size(), 400U) << "no limit of a number written out";
    EXPECT_EQ(result.out, "");
    int files = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(temporary_.path())) ++files;
    EXPECT_EQ(files, 1) << "something was written beside s.yaml";
  }

  const TemporaryFolder temporary_;
};

TEST_F(BadInputTest, UnknownKeyNamesTheNearestKnownOne) {
  ExpectRefusal("seed: 1\ngait:\n  perid_s: 0.3\n", "s.yaml:3:3: gait.perid_s: unknown key; did you mean period_s?");
  ExpectRefusal("sytem: sift_vo\n", "s.yaml:1:1: sytem: unknown key; did you mean system?", "", "validate");
}

TEST_F(BadInputTest, AKeyThatWasRenamedIsRefusedByItsNewName) {
  ExpectRefusal("seed: 1\nplace: lab\n", "s.yaml:2:1: place: this key is called scene now");
  ExpectRefusal("", "--set place=lab: this key is called scene now", "--set place=lab", "validate");
}

TEST_F(BadInputTest, WrongTypeAndRangeNameLineAndColumn) {
  ExpectRefusal("duration_s: long\n", "s.yaml:1:13: duration_s: \"long\" is not a number");
  ExpectRefusal("seed: -1\n", "s.yaml:1:7: seed:");
  ExpectRefusal("camera: {exposure_ms: 900}\n", "s.yaml:1:23: camera.exposure_ms: 900 is not permitted; expected");
}

TEST_F(BadInputTest, ARendererThatIsNoChoiceIsToldWhatWouldBe) {
  const std::string permitted = "is not permitted; expected one of auto, gpu, software, device:N";
  ExpectRefusal("camera:\n  renderer: softwar\n",
                "s.yaml:2:13: camera.renderer: \"softwar\" " + permitted + " (did you mean software?)");
  ExpectRefusal("camera: {renderer: 'device:-1'}\n", "s.yaml:1:20: camera.renderer: \"device:-1\" " + permitted, "",
                "validate");
  ExpectRefusal("camera: {renderer: [gpu]}\n", "s.yaml:1:20: camera.renderer: expected a text");
  ExpectRefusal("", "--set camera.renderer=device:one: \"device:one\" " + permitted,
                "--set camera.renderer=device:one");
}

TEST_F(BadInputTest, NamesThatDoNotExistAreNamedWithTheNearest) {
  ExpectRefusal("robot: khr1v\n", "khr1hv");
  ExpectRefusal("scene: labb\n", "lab");
  ExpectRefusal("system: sift_v0\n", "sift_vo");
  ExpectRefusal("system: {name: sift_vo, ration: 0.8}\n", "ratio");
  ExpectRefusal("gait: {preset: briskly}\n", "it has brisk, normal, slow");
  ExpectRefusal("robot: my/own.yaml\n", "own.yaml");
}

TEST_F(BadInputTest, ASettingOfTheSystemIsNamedWhereItStands) {
  ExpectRefusal("system:\n  name: sift_vo\n  ratio: fast\n",
                "s.yaml:3:10: system.ratio: sift_vo.ratio: \"fast\" is not");
  ExpectRefusal("system: sift_vo\n", "--set system.ratio=2: sift_vo.ratio: 2 is not", "--set system.ratio=2",
                "validate");
  ExpectRefusal("", "--set system.feature=syft: ", "--set system.feature=syft", "validate");
  ExpectRefusal("system: {name: sift_vo, ratio: [1]}\n", "expected a number or a word");
}

TEST_F(BadInputTest, AStepOutOfReachIsRefusedBeforeTheRun) {
  ExpectRefusal("gait: {step_length_m: 0.3}\n", "gait.step_length_m: 0.3");
  ExpectRefusal("", "gait.step_length_m: 0.3", "--set gait.step_length_m=0.3", "validate");
}

TEST_F(BadInputTest, TwoCamerasThatSeeNothingInCommonAreRefusedBeforeTheRun) {
  ExpectRefusal("camera:\n  stereo: {baseline_m: 0.1, right_rotation_deg: [0, 90, 0]}\n",
                "stereo rig: the two cameras see at most 0 % of the left image in common", "", "validate");
  ExpectRefusal("camera: {stereo: {baseline_m: 0.1}}\n", "stereo rig: the two cameras see at most 0 %",
                "--set camera.stereo.right_rotation_deg=[0,180,0]", "validate");
}

TEST_F(BadInputTest, CommandLineValuesAreNamedAsSuch) {
  ExpectRefusal("", "--set gait.period_s=soon: \"soon\" is not a number", "--set gait.period_s=soon");
  ExpectRefusal("", "expected key=value", "--set gait.period_s");
}

TEST_F(BadInputTest, BrokenYamlAndMissingFiles) {
  ExpectRefusal("gait: [1, 2\n", "s.yaml:2:1: not valid YAML");
  const ProgramResult missing = RunProgram("run nowhere.yaml", temporary_.path());
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("nowhere.yaml: cannot read this file"));
  const ProgramResult no_verb = RunProgram("walk s.yaml", temporary_.path());
  EXPECT_EQ(no_verb.exit_code, 2);
}

TEST_F(BadInputTest, NumbersThatNoWalkHasAreRefusedBeforeIt) {
  const std::string polyline = "path: {kind: polyline, points: [[1, 0], [";
  ExpectRefusal(polyline + ".nan, 0]]}\n",
                "s.yaml:1:42: path.points[1][0]: .nan is not permitted; expected a number from", "", "validate");
  ExpectRefusal(polyline + ".inf, 0]]}\n", ".inf is not permitted; expected a number from", "", "validate");
  ExpectRefusal(polyline + "1e200, 0]]}\n", "1e200 is not permitted; expected a number from", "", "validate");
  ExpectRefusal(polyline + "1e6, 0]]}\n", "m long; expected at most 10000 m", "", "validate");
  ExpectRefusal("start: [1e308, 0, 0]\n", "start[0]: 1e308 is not permitted", "", "validate");
  ExpectRefusal("start: [1e6, 0, 0]\n", "s.yaml:1:8: start: this is far from every scene", "", "validate");
  ExpectRefusal("kidnap: {to: [0, 0, 0]}\n", "s.yaml:1:9: kidnap: robot khr1hv walks; only a wheeled base", "",
                "validate");
  ExpectRefusal("robot: omni_base\nkidnap: {to: [0, 90, 0]}\n", "s.yaml:2:14: kidnap.to: expected x from", "",
                "validate");
  ExpectRefusal("people: [{path: [[0, 0], [1e300, 0]]}]\n", "1e300 is not permitted", "", "validate");
}

TEST_F(BadInputTest, AnErrorOfTheCameraIsNamedWhereItStands) {
  ExpectRefusal("system: mobif_vo\ncamera:\n  rate_hz: 30\n",
                "--set camera.exposure_ms=200: 200 is not permitted; expected at most", "--set camera.exposure_ms=200",
                "validate");
  ExpectRefusal("system: mobif_vo\ncamera:\n  exposure_ms: 200\n", "s.yaml:3:16: camera.exposure_ms: 200 is not", "",
                "validate");
}

TEST_F(BadInputTest, YamlThatMultipliesItselfOrComesTwiceIsRefused) {
  ExpectRefusal("people: &a [*a]\n", "s.yaml:1:", "", "validate");
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string below = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    bomb += name + ": &" + name + " [";
    for (int k = 0; k < 10; ++k) bomb += (k ? ", " : "") + below;
    bomb += "]\n";
  }
  ExpectRefusal(bomb, "more than a million values", "", "validate");
  ExpectRefusal("seed: 1\n---\nseed: 2\n", "s.yaml:3:1: a second document begins here", "", "validate");
  // yaml-cpp finds documents without end in it, and took all memory.
  ExpectRefusal(",,seed: 1\n", "s.yaml:1:1: not valid YAML: no value begins like this", "", "validate");
}

TEST_F(BadInputTest, ANameThatNoFileCanHaveIsRefused) {
  for (const std::string name : {"'..'", "'.'", "a/b", "\"a\\nb\"", "\"\\0\""}) {
    ExpectRefusal("name: " + name + "\n", "s.yaml:1:7: name: files are named after this", "", "validate");
  }
  const std::string too_long(300, 'x');
  ExpectRefusal("name: " + too_long + "\n", "expected 1 to 100 characters", "", "validate");
  for (const std::string key : {"robot", "scene", "system"}) {
    std::ofstream(temporary_.path() / "s.yaml") << key << ": " << too_long << "\n";
    const ProgramResult result = RunProgram("validate s.yaml", temporary_.path());
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_THAT(result.err, testing::MatchesRegex("gaitcam: s.yaml:1:[0-9]+: " + key + ": .*" + too_long + ".*\n"));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

TEST_F(BadInputTest, NumbersOfTheCommandLineAreCheckedToo) {
  ExpectRefusal("", "--seed", "--seed -1");
  ExpectRefusal("duration_s: 1\n", "--cache-gb: nan is not permitted", "--cache-gb nan", "study");
  for (const char* verb : {"record", "study", "check"}) {
    ExpectRefusal("duration_s: 1\n", "--jobs: Value -1 not in range", "-j -1", verb);
    ExpectRefusal("duration_s: 1\n", "--jobs: Value 10001 not in range", "-j 10001", verb);
  }
}

TEST_F(BadInputTest, ARecordingIsNotPutIntoAStrangersFolder) {
  std::filesystem::create_directory(temporary_.path() / "thesis");
  std::ofstream(temporary_.path() / "thesis" / "chapter.tex") << "text";
  std::ofstream(temporary_.path() / "s.yaml") << "duration_s: 1\n";
  const ProgramResult result = RunProgram("record s.yaml --out thesis", temporary_.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("holds something else"));
}

TEST_F(BadInputTest, ScoresDoNotReplaceWhatTheyAreMadeOf) {
  const std::string poses = "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n3 1 1 0 0 0 0 1\n4 2 1 0 0 0 0 1\n";
  std::ofstream(temporary_.path() / "e.txt") << poses;
  const ProgramResult result = RunProgram("score e.txt e.txt --out ./e.txt", temporary_.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("this file is read"));
  std::ostringstream kept;
  kept << std::ifstream(temporary_.path() / "e.txt").rdbuf();
  EXPECT_EQ(kept.str(), poses);
}

TEST_F(BadInputTest, AFolderThatHoldsSomethingElseIsNotReplaced) {
  std::ofstream(temporary_.path() / "s.yaml") << "duration_s: 1\n";
  const ProgramResult result = RunProgram("run s.yaml --out .", temporary_.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("holds something else"));
}

}  // namespace
}  // namespace gaitcam
