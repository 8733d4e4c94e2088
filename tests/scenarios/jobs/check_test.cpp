// `gaitcam check` from end to end on a suite so small that it runs in seconds.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "algorithms/core/errors.h"
#include "scenarios/code/jobs/suite.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Seven seeds are the fewest that can be significant at 1 %; who tracks the floor has poses from the first frame on.
constexpr const char* kScenario =
    "scene: plain\nduration_s: 2.2\n"
    "path: {kind: straight, length_m: 0.3}\n"
    "camera: {width_px: 160, height_px: 120, rate_hz: 10, exposure_ms: 4, fixed_subframes: 2}\n"
    "system: floor_slam\n";
constexpr const char* kSuite =
    "scenarios:\n  - {name: step, scenario: walk.yaml}\n"
    "systems: [floor_slam]\nseeds: 7\n"
    "metrics:\n  - {name: rpe_rot_rmse_deg_1f, margin: 0.05}\n  - {name: ate_rmse_m, margin: 0.02}\n"
    "gate: {history: 1}\n";

class CheckTest : public testing::Test {
 protected:
  CheckTest() {
    Write("walk.yaml", kScenario);
    Write("suite.yaml", kSuite);
  }
  void Write(const std::string& name, const std::string& text) const { std::ofstream(folder() / name) << text; }
  /// A copy of the suite with one piece of its text replaced.
  void Replace(const std::string& old_text, const std::string& new_text, const std::string& name = "suite.yaml") const {
    std::string text = ReadText(folder() / name);
    ASSERT_NE(text.find(old_text), std::string::npos) << old_text;
    Write(name, text.replace(text.find(old_text), old_text.size(), new_text));
  }
  ProgramResult Check(const std::string& more = "", const std::string& environment = "") const {
    return RunShell(environment + " GAITCAM_DATA=" + TestData().string() + " " + Program() +
                        " check ./suite.yaml -q --cache cache " + more,
                    folder());
  }
  /// @param verb what a slip does: exit code, one line with this fragment, nothing run.
  void ExpectRefusal(int code, const std::string& fragment, const std::string& more = "") const {
    const ProgramResult result = Check(more);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(folder() / "runs"));
    EXPECT_FALSE(fs::exists(folder() / "cache"));
  }
  const fs::path& folder() const { return temporary_.path(); }
  fs::path baseline() const { return folder() / "baselines/suite.json"; }

  const TemporaryFolder temporary_;
};

/// One story, so that the walks are rendered once.
TEST_F(CheckTest, AcceptsPassesCatchesAndRefuses) {
  const ProgramResult none = Check();
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("there is no such baseline; --update writes one"));
  EXPECT_FALSE(fs::exists(folder() / "runs"));

  const ProgramResult update = Check("--update");
  ASSERT_EQ(update.exit_code, 0) << update.err;
  ASSERT_TRUE(fs::exists(baseline()));
  const std::string accepted = ReadText(baseline());

  // The same program passes, reusing its runs, and says so in every format.
  const ProgramResult same =
      RunProgram("check ./suite.yaml --cache cache --junit check.xml --markdown check.md 2>/dev/null", folder());
  EXPECT_EQ(same.exit_code, 0) << same.out;
  EXPECT_THAT(same.out, AllOf(HasSubstr("suite: pass: 7 runs (7 reused)"), HasSubstr("coverage_ratio"),
                              HasSubstr("ate_rmse_m"), Not(HasSubstr("REGRESSION"))));
  EXPECT_THAT(ReadText(folder() / "check.xml"), HasSubstr("tests=\"3\" failures=\"0\" errors=\"0\" skipped=\"0\""));
  EXPECT_THAT(ReadText(folder() / "check.md"), HasSubstr("## gaitcam check suite: pass"));
  EXPECT_EQ(ReadText(baseline()), accepted) << "a check never writes the baseline";

  // GitHub's page is appended to.
  Write("summary.md", "before\n");
  EXPECT_EQ(Check("--json", "GITHUB_STEP_SUMMARY=summary.md").exit_code, 0);
  EXPECT_THAT(ReadText(folder() / "summary.md"),
              AllOf(testing::StartsWith("before\n"), HasSubstr("## gaitcam check suite: pass")));

  // Writing the same baseline again changes nothing.
  EXPECT_EQ(Check("--update").exit_code, 0);
  EXPECT_EQ(ReadText(baseline()), accepted);

  // The frames are the same, the poses are not: the baseline of the good system is given to the bad one.
  Write("suite.yaml", std::string(kSuite) + "self_test:\n  - {name: noise, set: {handicap.pose_noise_deg: 2}}\n");
  const ProgramResult caught = Check("--self-test --reruns 2 --record rates.md");
  EXPECT_EQ(caught.exit_code, 0) << caught.out << caught.err;
  EXPECT_THAT(ReadText(folder() / "rates.md"),
              AllOf(HasSubstr("caught 1 of 1 worse systems"), HasSubstr("in 2 re-runs"), HasSubstr("noise")));
  Write("suite.yaml", std::string(kSuite) + "self_test:\n  - {name: nothing, set: {handicap.pose_noise_deg: 0}}\n");
  const ProgramResult missed = RunProgram("check ./suite.yaml --cache cache --self-test 2>/dev/null", folder());
  EXPECT_EQ(missed.exit_code, 1) << "a worse system that is none must not be called caught";
  EXPECT_THAT(missed.out, HasSubstr("caught 0 of 1 worse systems"));
  Write("suite.yaml", kSuite);

  // A baseline of better days: exit 1, the metric named, in all reports.
  nlohmann::ordered_json better = nlohmann::ordered_json::parse(accepted);
  for (auto& run : better["entries"][0]["runs"]) {
    run["values"]["rpe_rot_rmse_deg_1f"] = 0.0001;
    run["history"]["rpe_rot_rmse_deg_1f"] = {0.0001};
  }
  Write("better.json", better.dump());
  const ProgramResult worse = Check("--baseline better.json --junit worse.xml");
  EXPECT_EQ(worse.exit_code, 1);
  EXPECT_THAT(worse.err, HasSubstr("REGRESSION: rpe_rot_rmse_deg_1f of floor_slam on step"));
  EXPECT_THAT(ReadText(folder() / "worse.xml"), HasSubstr("failures=\"1\""));

  // Another scenario: exit 2, and which key it is.
  Replace("exposure_ms: 4", "exposure_ms: 5", "walk.yaml");
  const ProgramResult other = Check();
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("camera.exposure_ms is 5, was 4 in the baseline"));
  Write("walk.yaml", kScenario);

  // A metric or a seed that the baseline does not have.
  Replace("ate_rmse_m", "ate_mean_m");
  EXPECT_THAT(Check().err, HasSubstr("it has no ate_mean_m of step with floor_slam"));
  Write("suite.yaml", kSuite);
  Replace("seeds: 7", "seeds: 8");
  EXPECT_THAT(Check().err, HasSubstr("it has no seed 8 of step"));
  Write("suite.yaml", kSuite);

  // Damage and another schema.
  Write("half.json", accepted.substr(0, accepted.size() / 2));
  EXPECT_EQ(Check("--baseline half.json").exit_code, 2);
  std::string schema = accepted;
  Write("schema.json", schema.replace(schema.find("baseline.1"), 10, "baseline.7"));
  const ProgramResult newer = Check("--baseline schema.json");
  EXPECT_EQ(newer.exit_code, 2);
  EXPECT_THAT(newer.err, HasSubstr("schema \"gaitcam.baseline.7\""));

  // Who is to render is no part of what is compared.
  Replace("exposure_ms: 4", "exposure_ms: 4, renderer: software", "walk.yaml");
  const ProgramResult chosen = Check();
  EXPECT_EQ(chosen.exit_code, 0) << chosen.err;
  Write("walk.yaml", kScenario);

  // A differing renderer is named and nothing more.
  std::string renderer = accepted;
  const size_t at = renderer.find("\"renderer\": \"") + 13;
  Write("renderer.json", renderer.replace(at, renderer.find('"', at) - at, "a graphics card"));
  const ProgramResult elsewhere =
      RunProgram("check ./suite.yaml --cache cache --baseline renderer.json 2>/dev/null", folder());
  EXPECT_EQ(elsewhere.exit_code, 0);
  EXPECT_THAT(elsewhere.out, HasSubstr("the baseline by a graphics card"));
}

TEST_F(CheckTest, ASystemThatCrashesFailsTheGateAndNeverBecomesABaseline) {
  Write("crash.sh", "#!/bin/sh\necho it broke >&2\nexit 7\n");
  fs::permissions(folder() / "crash.sh", fs::perms::owner_all);
  Replace("[floor_slam]", "[{command: [./crash.sh, \"{dataset}\", \"{output}\"]}]");
  Replace("duration_s: 2.2", "duration_s: 0.4", "walk.yaml");
  const ProgramResult update = Check("--update");
  EXPECT_EQ(update.exit_code, 2) << update.err;
  EXPECT_THAT(update.err, HasSubstr("no baseline was written: 7 runs failed; step with crash, seed 1: "));
  EXPECT_FALSE(fs::exists(baseline()));
}

TEST_F(CheckTest, UnknownKeysAndWrongTypesPointAtTheirPlace) {
  Replace("seeds: 7", "sedes: 7");
  ExpectRefusal(2, "suite.yaml:4:1: sedes: unknown key; did you mean seeds?");
  Write("suite.yaml", kSuite);
  Replace("history: 1", "alpha: 0.9");
  ExpectRefusal(2, "suite.yaml:8:15: gate.alpha: 0.9 is not permitted");
  Write("suite.yaml", kSuite);
  Replace("history: 1", "test: t_test");
  ExpectRefusal(2, "gate.test");
  Write("suite.yaml", kSuite);
  Replace("margin: 0.05", "margin: some");
  ExpectRefusal(2, "metrics[0].margin: \"some\" is not a number");
}

TEST_F(CheckTest, EmptyListsAreRefused) {
  for (const auto& [old_text, new_text, fragment] :
       {std::tuple{"systems: [floor_slam]", "systems: []", "expected at least one system"},
        {"seeds: 7", "seeds: 0", "expected a number of seeds of 1 to 1000000"},
        {"seeds: 7", "seeds: []", "expected at least one seed"},
        {"\nseeds: 7", "", "expected at least one seed"},
        {"\n  - {name: step, scenario: walk.yaml}", " []", "expected at least one scenario"}}) {
    Write("suite.yaml", kSuite);
    Replace(old_text, new_text);
    ExpectRefusal(2, fragment);
  }
}

TEST_F(CheckTest, NamesThatDoNotExistAreNamedWithTheNearest) {
  Replace("ate_rmse_m", "ate_rsme_m");
  ExpectRefusal(2, "suite.yaml:7:5: metrics[1]: scenario step has no score \"ate_rsme_m\"; did you mean ate_rmse_m?");
  Write("suite.yaml", kSuite);
  Replace("ate_rmse_m", "path_length_m");
  ExpectRefusal(2, "gets neither better nor worse");
  Write("suite.yaml", kSuite);
  Replace("ate_rmse_m", "coverage_ratio");
  ExpectRefusal(2, "coverage_ratio always gates");
  Write("suite.yaml", kSuite);
  Replace("[floor_slam]", "[floor_slams]");
  ExpectRefusal(2, "floor_slam");
  Write("suite.yaml", kSuite);
  Replace("scenario: walk.yaml", "scenario: run.yaml");
  ExpectRefusal(2, "run.yaml: cannot read this file");
  Write("suite.yaml", std::string(kSuite) + "self_test:\n  - {name: worse, set: {handicap.focal: 1.02}}\n");
  ExpectRefusal(2, "focal_factor");
  const ProgramResult shipped = RunProgram("check smok", folder());
  EXPECT_EQ(shipped.exit_code, 2);
  EXPECT_THAT(shipped.err, HasSubstr("there is no suite \"smok\"; there are full, smoke"));
}

TEST_F(CheckTest, TooFewSeedsToShowAnythingAreRefusedBeforeAnythingRuns) {
  Replace("seeds: 7", "seeds: 6");
  ExpectRefusal(3, "6 seeds can never show a regression; at alpha 0.01 at least 7 are needed");
}

TEST_F(CheckTest, AScenarioMayHaveSystemsAndMetricsOfItsOwn) {
  Write("suite.yaml",
        "scenarios:\n  - {name: one, scenario: walk.yaml}\n"
        "  - {name: two, scenario: walk.yaml, systems: [sift_vo, orb_vo], metrics: [{name: rotation_gain}]}\n"
        "systems: [floor_slam]\nseeds: 7\nmetrics: [{name: ate_rmse_m}]\n"
        "self_test:\n  - {name: noise, set: {handicap.pose_noise: 0.1}, scenarios: [two], systems: [orb_vo]}\n");
  const Suite suite = ReadSuite((folder() / "suite.yaml").string());
  std::vector<std::string> entries;
  for (const SuiteEntry& entry : suite.entries)
    entries.push_back(entry.scenario + " " + entry.system + " " + entry.metrics.at(0).name);
  EXPECT_THAT(entries, testing::ElementsAre("one floor_slam ate_rmse_m", "two sift_vo rotation_gain",
                                            "two orb_vo rotation_gain"));
  const std::vector<SuiteEntry> worse = suite.EntriesOf(suite.options.self_test[0]);
  ASSERT_EQ(worse.size(), 1u);
  EXPECT_EQ(worse[0].scenario + " " + worse[0].system, "two orb_vo");

  Replace("scenarios: [two]", "scenarios: [three]");
  ExpectRefusal(2, "the suite has no scenario three");
  Replace("scenarios: [three]", "scenarios: [two]");
  Replace("sift_vo, orb_vo", "orb_vo, orb_vo");
  ExpectRefusal(2, "this system is there twice");
  Replace("orb_vo, orb_vo", "orb_vo");
  Replace("{name: rotation_gain}", "{name: rotation_gains}");
  ExpectRefusal(2, "rotation_gain");
}

TEST_F(CheckTest, OptionsThatDoNotGoTogetherAreRefused) {
  ExpectRefusal(2, "--update and --self-test", "--update --self-test");
  ExpectRefusal(2, "belong to --self-test", "--reruns 5");
}

TEST(DifferenceOf, NamesKeysWithOldAndNewValue) {
  EXPECT_EQ(DifferenceOf("a: 1\nb: {c: 2}\n", "a: 1\nb: {c: 2}\n"), "");
  EXPECT_EQ(DifferenceOf("a: 1\nb: {c: 2}\n", "a: 1\nb: {c: 3}\nd: [1, 2]\n"),
            "b.c is 3, was 2 in the baseline; d is [1, 2], was absent in the baseline");
  EXPECT_THAT(DifferenceOf("{}", "{a: 1, b: 2, c: 3, d: 4, e: 5, f: 6, g: 7}"), HasSubstr("and 2 more keys"));
}

TEST(ShippedSuites, CanBeReadAndListEveryHandicap) {
  for (const char* name : {"smoke", "full"}) {
    const Suite suite = ReadSuite((TestData() / "scenarios/suites" / name).string() + ".yaml");
    EXPECT_GE(suite.options.seeds.size(), 8u);
    EXPECT_GE(suite.options.self_test.size(), 5u);
    EXPECT_TRUE(fs::exists(TestData() / "results/baselines" / (std::string(name) + ".json"))) << name;
  }
}

}  // namespace
}  // namespace gaitcam
