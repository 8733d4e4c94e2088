// The three ways in which somebody else's system comes to us, each by its shipped example, in every verb. The examples
// are one algorithm, so that each is also a test of the others: what it was given must have been the same.

#include <gmock/gmock.h>

#include <fstream>

#include "algorithms/io/trajectory_file.h"
#include "tests/scenarios/systems/foreign_run.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string Example(const std::string& name) { return (TestData() / "scenarios/examples" / name).string(); }

struct Way {
  std::string name, system;
};

std::vector<Way> Ways() {
  return {{"plugin", std::string("{plugin: ") + GYRO_PLUGIN + "}"},
          {"process", "{process: [python3, " + Example("gyro_process.py") + "], needs: [imu]}"},
          {"command", "{command: [python3, " + Example("gyro_command.py") +
                          R"(, "{dataset}", "{output}"], depends: [)" + Example("gyro_process.py") + "]}"}};
}

class ExamplesTest : public ForeignRun {
 protected:
  /// Both took the same samples and added them up in double precision.
  void ExpectSamePoses(const fs::path& a, const fs::path& b) const {
    const Trajectory one = ReadTrajectory(folder() / a).trajectory, other = ReadTrajectory(folder() / b).trajectory;
    ASSERT_EQ(one.size(), other.size());
    for (size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].stamp_ns, other[i].stamp_ns);
      EXPECT_LT((one[i].pose.translation - other[i].pose.translation).norm(), 1e-9) << b;
      EXPECT_LT(RotationAngle(one[i].pose.rotation, other[i].pose.rotation), 1e-7) << b;  // its arc cosine rounds
    }
  }
};

TEST_F(ExamplesTest, AnswerAlikeInRunAndTrack) {
  WriteScenario("sift_vo");
  ASSERT_EQ(RunProgram("record s.yaml --out walk", folder()).exit_code, 0);
  for (const Way& way : Ways()) {
    const ProgramResult run = Run(way.system, way.name);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json scores = ScoresOf(way.name);
    EXPECT_FALSE(scores["run"].contains("system_failed"));
    EXPECT_EQ(scores["scores"]["coverage_ratio"], 1);
    EXPECT_LT(scores["scores"]["rpe_rot_rmse_deg_1f"].get<double>(), 0.5)
        << "a frame's turn, by a gyroscope with noise";
    temporary_.Write(way.name + ".yaml", way.system);
    const ProgramResult track =
        RunProgram("track walk --system " + way.name + ".yaml --out " + way.name + ".txt", folder());
    ASSERT_EQ(track.exit_code, 0) << track.err;
    EXPECT_THAT(track.out, HasSubstr("ate_sim3_rmse_m"));
    ExpectSamePoses(way.name + "/estimate.txt", way.name + ".txt");
    ExpectSamePoses("plugin/estimate.txt", way.name + "/estimate.txt");
  }
  const ProgramResult set =
      RunProgram("track walk --system " + std::string(GYRO_PLUGIN) + " --set speed_m_s=20", folder());
  EXPECT_EQ(set.exit_code, 2);
  EXPECT_THAT(set.err, HasSubstr("speed_m_s"));
}

TEST_F(ExamplesTest, AreGatedAndStudiedLikeOurs) {
  WriteScenario("sift_vo");
  std::string suite = "scenarios:\n  - {name: step, scenario: s.yaml, set: {duration_s: 1.2}}\nsystems:\n", list;
  for (const Way& way : Ways()) {
    suite += "  - " + way.system + "\n";
    list += "  - {system: " + way.system + "}\n";
  }
  temporary_.Write("suite.yaml", suite + "seeds: 7\nmetrics:\n  - {name: rpe_rot_rmse_deg_1f, margin: 0.05}\n");
  temporary_.Write("study.yaml",
                   "base: s.yaml\nset: {duration_s: 1.2}\nlist:\n" + list + "seeds: 7\nmetrics: [coverage_ratio]\n");
  const ProgramResult update = RunProgram("check ./suite.yaml --update -q --cache cache", folder());
  ASSERT_EQ(update.exit_code, 0) << update.err;
  const ProgramResult check = RunProgram("check ./suite.yaml --cache cache", folder());
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("suite: pass: 21 runs (21 reused)"));
  const ProgramResult study = RunProgram("study study.yaml --out study -q --cache cache", folder());
  EXPECT_EQ(study.exit_code, 0) << study.err;
  const std::string runs = ReadText(folder() / "study/runs.csv");
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 22) << "a header and a row per run";
}

TEST_F(ExamplesTest, AreListedWithWhatIsKnownOfThem) {
  const ProgramResult plugin = RunProgram(std::string("list systems ") + GYRO_PLUGIN, folder());
  EXPECT_EQ(plugin.exit_code, 0) << plugin.err;
  EXPECT_THAT(plugin.out, HasSubstr("gyroscope and a constant speed"));
  EXPECT_THAT(plugin.out, HasSubstr("needs imu"));
  EXPECT_THAT(plugin.out, HasSubstr("speed_m_s = 0.1 m/s (a number from 0 to 10): along the optical axis"));
  const ProgramResult process = RunProgram("list systems '{process: [python3, x.py], needs: [depth]}'", folder());
  EXPECT_THAT(process.out, HasSubstr("needs depth"));
}

// An edited script is another program: what its older version answered is not taken for its answer.
TEST_F(ExamplesTest, AnEditedScriptIsRunAgain) {
  WriteScenario("sift_vo");
  const auto write = [&](const std::string& more) {
    temporary_.Write("helper.py", ReadText(Example("gyro_process.py")) + more);
  };
  const auto check = [&](const std::string& how) {
    return RunProgram("check ./suite.yaml -q --cache cache --json " + how, folder());
  };
  write("");
  temporary_.Write("slam.py",
                   "import runpy\nrunpy.run_path('" + (folder() / "helper.py").string() + "', run_name='__main__')\n");
  temporary_.Write("suite.yaml",
                   "scenarios:\n  - {name: step, scenario: s.yaml, set: {duration_s: 1.2}}\n"
                   "systems:\n  - {process: [python3, slam.py], depends: [helper.py]}\nseeds: 7\n"
                   "metrics:\n  - {name: rpe_rot_rmse_deg_1f, margin: 0.05}\n");
  ASSERT_EQ(check("--update").exit_code, 0);
  ASSERT_EQ(check("").exit_code, 0);
  // The gyroscope's readings times two, in the file that the command depends on.
  std::string text = ReadText(folder() / "helper.py");
  text.replace(text.find("angle = math.hypot(*w) * dt"), 27, "w = [2 * x for x in w]; angle = math.hypot(*w) * dt");
  temporary_.Write("helper.py", text);
  EXPECT_EQ(check("").exit_code, 1);
}

}  // namespace
}  // namespace gaitcam
