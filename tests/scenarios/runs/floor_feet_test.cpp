/// The shipped scenario in which somebody's feet cross the robot's view.

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <vector>

#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/runner.h"
#include "sim/simulation.h"
#include "tests/data_folder.h"

namespace gaitcam {
namespace {

ResolvedScenario FloorFeet() {
  return ReadScenario(TestData() / "scenarios/floor_feet.yaml",
                      {"camera.width_px=160", "camera.height_px=120", "camera.rate_hz=5", "camera.exposure_ms=0",
                       "camera.fixed_subframes=1", "duration_s=12.5"});
}

struct Film {
  std::vector<cv::Mat> depth;
  std::vector<Pose> X_WB;

  Film(const ResolvedScenario& resolved, const Scene& scene) {
    TruthOptions truth;
    truth.sharp = truth.blur = false;
    Simulation simulation(resolved.robot, scene, SimulationOptionsOf(resolved), resolved.scenario.seed);
    while (const auto frame = simulation.Next(truth)) {
      depth.push_back(frame->truth.depth);
      X_WB.push_back(*frame->truth.X_WB);
    }
  }
};

TEST(FloorFeet, APersonFillsAThirdOfTheViewTwiceAndTheRobotWalksOnUnmoved) {
  const ResolvedScenario resolved = FloorFeet();
  ASSERT_EQ(resolved.scene.people.size(), 1u);
  Scene alone = resolved.scene;
  alone.people.clear();
  const Film with(resolved, resolved.scene), without(resolved, alone);
  ASSERT_EQ(with.depth.size(), without.depth.size());
  double first = 0, second = 0, between = 0;
  for (size_t i = 0; i < with.depth.size(); ++i) {
    EXPECT_EQ(with.X_WB[i].translation, without.X_WB[i].translation);
    const cv::Mat person = with.depth[i] != without.depth[i];
    const double cover = double(cv::countNonZero(person)) / double(person.total());
    const double time_s = double(i) / 5;
    (time_s < 7 ? first : second) = std::max(time_s < 7 ? first : second, cover);
    if (time_s > 6 && time_s < 9) between = std::max(between, cover);
  }
  EXPECT_GT(first, 0.33);
  EXPECT_GT(second, 0.33);
  EXPECT_EQ(between, 0);
}

TEST(FloorFeet, PeopleDecideTheFramesButNotTheirNames) {
  const ResolvedScenario as_is = FloorFeet();
  ResolvedScenario renamed = as_is, empty = as_is, slower = as_is;
  renamed.scenario.people[0].name = "somebody";
  slower.scenario.people[0].speed_m_s = 0.5;
  empty.scenario.people.clear();
  EXPECT_EQ(FramesHashOf(as_is), FramesHashOf(renamed));
  EXPECT_NE(FramesHashOf(as_is), FramesHashOf(slower));
  EXPECT_NE(FramesHashOf(as_is), FramesHashOf(empty));
  EXPECT_NE(HashOf(as_is), HashOf(empty));
  // The resolved scenario tells of them, and of nobody where nobody is.
  EXPECT_NE(as_is.ToYaml().find("people:"), std::string::npos);
  EXPECT_EQ(empty.ToYaml().find("people"), std::string::npos);
}

}  // namespace
}  // namespace gaitcam
