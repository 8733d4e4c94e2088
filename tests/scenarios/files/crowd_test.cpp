// A scenario's crowd: of the run's seed, round its robot's planned course, instead of its scene's own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/errors.h"
#include "models/code/people/person_walk.h"
#include "scenarios/code/files/scenario.h"
#include "sim/walking/planned_course.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

class CrowdScenarioTest : public testing::Test {
 protected:
  CrowdScenarioTest() { setenv("GAITCAM_DATA", TestData().c_str(), 1); }
  ResolvedScenario Read(const std::string& text, const std::vector<std::string>& changes = {}) const {
    return ReadScenario(temporary_.Write("crowded.yaml", text), changes);
  }
  std::string ErrorOf(const std::string& text) const {
    try {
      Read(text);
    } catch (const BadInput& e) {
      return e.what();
    }
    return "";
  }
  const TemporaryFolder temporary_;
  const std::string hall_ = "robot: omni_base\nscene: hall\nduration_s: 6\npath: {length_m: 8}\n";
};

/// Where everybody begins, as text.
std::string Begins(const ResolvedScenario& resolved) {
  std::string text;
  for (const PersonOptions& person : resolved.scene.people) {
    const Eigen::Vector2d& p = person.path[0];
    text += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(person.height_m) + "\n";
  }
  return text;
}

TEST_F(CrowdScenarioTest, FollowsTheRunsSeedAndComesBackWithIt) {
  const std::string crowd = hall_ + "crowd: {count: 12}\npeople: [{path: [[0, 0]], speed_m_s: 0}]\n";
  const ResolvedScenario first = Read(crowd), second = Read(crowd, {"seed=2"});
  EXPECT_EQ(first.scene.people.size(), 13u);  // the crowd comes beside people with paths of their own
  EXPECT_NE(Begins(first), Begins(second));
  EXPECT_EQ(Begins(first.WithSeed(2)), Begins(second));
  EXPECT_EQ(Begins(first.WithSeed(2).WithSeed(1)), Begins(first));
  EXPECT_NE(FramesHashOf(first), FramesHashOf(Read(crowd, {"crowd.talking=0.5"})));
  EXPECT_EQ(Begins(Read(first.ToYaml())), Begins(first));  // what is written gives the same run
  EXPECT_EQ(FramesHashOf(Read(first.ToYaml())), FramesHashOf(first));
}

TEST_F(CrowdScenarioTest, ReplacesItsScenesOwn) {
  temporary_.Write("busy.yaml", "base: hall\ncrowd: {count: 5}\n");
  const std::string busy = "robot: omni_base\nscene: " + (temporary_.path() / "busy.yaml").string() + "\n";
  EXPECT_EQ(Read(busy).scene.people.size(), 5u);
  EXPECT_EQ(Read(busy + "crowd: {count: 7}\n").scene.people.size(), 7u);
  EXPECT_EQ(Read(busy + "crowd: {count: 0}\n").scene.people.size(), 0u);
}

TEST_F(CrowdScenarioTest, TheShippedOneKeepsOffItsRobot) {
  const ResolvedScenario resolved = ReadScenario(TestData() / "scenarios" / "cafeteria.yaml", {});
  ASSERT_EQ(resolved.scene.people.size(), 40u);
  const Scenario& scenario = resolved.scenario;
  const Eigen::Vector3d& s = resolved.scene.start;
  const PlannedCourse course = PlanCourse(resolved.robot, scenario.gait.options, scenario.drive, scenario.path,
                                          Pose(RotZ(s.z()), {s.x(), s.y(), 0}));
  double nearest = 100;
  for (const PersonOptions& person : resolved.scene.people) {
    const PersonWalk walk(person);
    for (double t = 0; t <= scenario.duration_s; t += 0.1) {
      const Pose hips = walk.At(t)[size_t(PersonPart::kHips)];
      nearest = std::min(nearest, (hips.translation.head<2>() - course(t).position).norm());
    }
  }
  RecordProperty("nearest_m", std::to_string(nearest));
  EXPECT_GT(nearest, 0.6);  // 0.7 is kept; footsteps are a few centimetres beside
  // It does drive through the crowd.
  EXPECT_LT(nearest, 1.5);
}

TEST_F(CrowdScenarioTest, IsRefusedWhereItStandsIfItDoesNotFit) {
  EXPECT_THAT(ErrorOf(hall_ + "crowd: {count: 500}\n"), HasSubstr("crowded.yaml:5:8: crowd: of 500 people"));
  EXPECT_THAT(ErrorOf(hall_ + "crowd: {count: 3, goals: [[0, 20]]}\n"), HasSubstr("goals: [0, 20] cannot be reached"));
  EXPECT_THAT(ErrorOf(hall_ + "crowd: {speed_m_s: 9}\n"), HasSubstr("crowd.speed_m_s"));
  temporary_.Write("full.yaml", "base: hall\ncrowd: {count: 500}\n");
  EXPECT_THAT(ErrorOf("robot: omni_base\nscene: " + (temporary_.path() / "full.yaml").string() + "\n"),
              HasSubstr("crowded.yaml:2:8: scene: its crowd: of 500 people"));
}

}  // namespace
}  // namespace gaitcam
