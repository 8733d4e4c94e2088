// A crowd about a robot that a system commands: it minds where the robot is, not where it was planned to be.

#include <gtest/gtest.h>

#include "models/code/scenes/scene_crowd.h"
#include "sim/simulation.h"
#include "tests/data_folder.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// A base that is to cross the cafeteria along x, at a camera's few pixels, and thirty people who all walk.
class CommandedCrowdTest : public testing::Test {
 protected:
  CommandedCrowdTest() : robot_(ReadShippedRobot("omni_base")), scene_(ReadScene("cafeteria", TestData() / "models")) {
    CrowdEntry crowd;
    crowd.count = 30;
    crowd.standing = crowd.talking = 0;
    plan_ = {crowd, [](double time_s) { return Vector2d(-4 + 0.4 * time_s, 0); }, kDuration_s, 1};
    AddCrowd(plan_, scene_);
    options_.camera.width_px = 40;
    options_.camera.height_px = 30;
    options_.camera.rate_hz = 2;
    options_.camera.antialias = 1;
    options_.camera.exposure.fixed_subframes = 1;
    options_.path.kind = PathKind::kStand;
    options_.duration_s = kDuration_s;
    options_.start = {-4, 0, 0};
  }

  /// Where everybody went while the robot stands at its start.
  std::vector<PersonWalk> WalksAboutStandingRobot(const SimulationOptions& options) const {
    Simulation simulation(robot_, scene_, options, 1);
    while (simulation.Next({false, false, false})) simulation.Command(Velocity{});
    return *simulation.world().people();
  }

  static double NearestToStart(const std::vector<PersonWalk>& walks) {
    double nearest = 100;
    for (double t = 0; t < kDuration_s; t += 0.1) {
      for (const PersonWalk& walk : walks) {
        const Pose hips = walk.At(t)[size_t(PersonPart::kHips)];
        nearest = std::min(nearest, (hips.translation.head<2>() - Vector2d(-4, 0)).norm());
      }
    }
    return nearest;
  }

  static constexpr double kDuration_s = 15;
  Robot robot_;
  Scene scene_;
  CrowdPlan plan_;
  SimulationOptions options_;
};

TEST_F(CommandedCrowdTest, WalksRoundARobotThatDidNotSetOff) {
  const double led_by_the_plan = NearestToStart(WalksAboutStandingRobot(options_));
  options_.crowd = plan_;
  const double live = NearestToStart(WalksAboutStandingRobot(options_));
  constexpr double kTouch_m = 0.22 + 0.25;  // radii of robot and person, as a drive is scored
  EXPECT_LT(led_by_the_plan, kTouch_m);
  EXPECT_GT(live, kTouch_m);
}

TEST_F(CommandedCrowdTest, TheSameSeedGivesTheSameWalks) {
  options_.crowd = plan_;
  options_.duration_s = 4;
  const std::vector<PersonWalk> first = WalksAboutStandingRobot(options_), second = WalksAboutStandingRobot(options_);
  for (size_t i = 0; i < first.size(); ++i) {
    for (const double t : {0.5, 2.0, 4.0}) {
      EXPECT_EQ(first[i].At(t)[0].translation, second[i].At(t)[0].translation) << i << " " << t;
    }
  }
}

}  // namespace
}  // namespace gaitcam
