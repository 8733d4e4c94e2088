// Walks that differ as repeats of an experiment do, and what a run says of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/units.h"
#include "scenarios/code/runs/recorded_walk.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class VariationRunTest : public testing::Test {
 protected:
  VariationRunTest() { setenv("GAITCAM_DATA", TestData().c_str(), 1); }
  const TemporaryFolder temporary_;
};

TEST_F(VariationRunTest, ARobotStartsWhereItsSeedSaysAndTheSameSeedGivesTheSameBytes) {
  const std::vector<std::string> third{"variation=repeat", "seed=3"}, fourth{"variation=repeat", "seed=4"};
  const DatasetFolders a = RecordTinyWalk(temporary_.path() / "a", "tum", third);
  const DatasetFolders again = RecordTinyWalk(temporary_.path() / "again", "tum", third);
  const DatasetFolders b = RecordTinyWalk(temporary_.path() / "b", "tum", fourth);
  EXPECT_EQ(ReadText(a.truth / "groundtruth.txt"), ReadText(again.truth / "groundtruth.txt"));
  EXPECT_NE(ReadText(a.truth / "groundtruth.txt"), ReadText(b.truth / "groundtruth.txt"));
  const RecordedWalk walk = ReadRecordedWalk(a), same = ReadRecordedWalk(again), other = ReadRecordedWalk(b);
  EXPECT_EQ(ReadText(walk.frames[4].image), ReadText(same.frames[4].image));
  EXPECT_NE(ReadText(walk.frames[4].image), ReadText(other.frames[4].image));
  for (const auto& [recorded, changes] : {std::pair{&walk, third}, {&other, fourth}}) {
    const Eigen::Vector3d start = *ReadScenario(temporary_.path() / "a" / "walk.yaml", changes).start;
    // It stands there for 0.3 s; the camera is some centimetres before and beside the root, which is put there.
    const Pose& X_WC = recorded->frames.front().X_WC;
    EXPECT_LT((X_WC.translation.head<2>() - start.head<2>()).norm(), 0.08);
    const Eigen::Vector3d forward = X_WC.R().col(2);
    EXPECT_NEAR(std::atan2(forward.y(), forward.x()), start.z() * kRadPerDeg, 0.02);
  }
  EXPECT_GT((walk.frames[0].X_WC.translation - other.frames[0].X_WC.translation).norm(), 0.01);
}

TEST_F(VariationRunTest, ARunSaysWhatWasDrawnAndWhatSteered) {
  std::ofstream(temporary_.path() / "s.yaml")
      << kTinyWalk << "score: {min_coverage_ratio: 0, min_pairs: 3}\nvideo: {enabled: false}\nsystem: orb_vo\n";
  const auto run = [&](const std::string& more) {
    const ProgramResult result = RunProgram("run s.yaml --out out -q" + more, temporary_.path());
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 3)) << result.err;
    return ReadText(temporary_.path() / "out/report.html") + ReadText(temporary_.path() / "out/scores.json");
  };
  const std::string plain = run("");
  EXPECT_THAT(plain, HasSubstr("steered by its true pose"));
  EXPECT_THAT(plain, HasSubstr("\"steered_by\": \"truth\""));
  EXPECT_THAT(plain, testing::Not(HasSubstr("variation drawn")));
  const std::string repeat = run(" --set path.feedback=odometry --set variation=repeat");
  EXPECT_THAT(repeat, HasSubstr("steered by its own odometry"));
  EXPECT_THAT(repeat, HasSubstr("\"steered_by\": \"odometry\""));
  EXPECT_THAT(repeat, HasSubstr("variation drawn: start"));
  EXPECT_THAT(repeat, HasSubstr("\"variation\": {"));
}

// A cmos camera's frames come from the cache as from the simulation: exposures that follow the light among them.
TEST_F(VariationRunTest, AutoExposureIsRecordedAsItWasFilmed) {
  const DatasetFolders folders =
      RecordTinyWalk(temporary_.path() / "dim", "tum",
                     {"camera.preset=cmos", "camera.jpeg={}", "camera.fixed_subframes=0", "scene=lab_dim"});
  const RecordedWalk walk = ReadRecordedWalk(folders);
  ASSERT_EQ(walk.frames.size(), 20U);
  EXPECT_EQ(walk.frames.front().exposure_ms, 10);
  EXPECT_EQ(walk.frames.back().exposure_ms, 30);  // a tenth of the light: all the time that there is
  EXPECT_EQ(walk.calibration.readout_ms, 20);
  EXPECT_TRUE(walk.calibration.camera.IsDistorted());
  const ProgramResult valid = RunProgram("validate dim", temporary_.path());
  EXPECT_EQ(valid.exit_code, 0) << valid.out << valid.err;
}

}  // namespace
}  // namespace gaitcam
