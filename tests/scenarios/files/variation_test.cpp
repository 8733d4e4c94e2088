// What differs from seed to seed as in repeats of an experiment, and what must not.

#include "scenarios/code/files/variation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "scenarios/code/files/experiment.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/scenario.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kAll = -std::numeric_limits<double>::infinity();

class VariationTest : public testing::Test {
 protected:
  VariationTest() { setenv("GAITCAM_DATA", TestData().c_str(), 1); }
  ResolvedScenario Read(const std::string& text, const std::vector<std::string>& changes = {}) const {
    std::ofstream(temporary_.path() / "s.yaml") << text;
    return ReadScenario(temporary_.path() / "s.yaml", changes);
  }
  const TemporaryFolder temporary_;
  const std::string circle_ = "scene: lab\npath: {kind: circle, diameter_m: 4}\n";
};

/// Places and colours of all boxes, and the pictures' recipes by what they show.
std::string Layout(const Scene& scene) {
  std::string text;
  for (const SceneBox& box : scene.boxes) {
    const Eigen::Vector3d& p = box.X_WB.translation;
    text += box.name + " " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  }
  return text;
}

TEST_F(VariationTest, WithoutOneNothingChanges) {
  const ResolvedScenario plain = Read(circle_);
  EXPECT_THAT(plain.ToYaml(), Not(HasSubstr("variation")));
  for (const char* block : {"variation: none\n", "variation: {start_m: 0}\n"}) {
    const ResolvedScenario none = Read(circle_ + block);
    EXPECT_EQ(none.ToYaml(), plain.ToYaml());
    EXPECT_EQ(FramesHashOf(none), FramesHashOf(plain));
    EXPECT_FALSE(none.start.has_value());
    EXPECT_EQ(Layout(none.scene), Layout(plain.scene));
  }
  EXPECT_EQ(Layout(plain.WithSeed(8).scene), Layout(plain.scene));
}

TEST_F(VariationTest, ItBelongsToTheFrames) {
  EXPECT_NE(FramesHashOf(Read(circle_ + "variation: repeat\n")), FramesHashOf(Read(circle_)));
}

TEST_F(VariationTest, ASeedIsAlwaysTheSameAndAnotherIsAnother) {
  const ResolvedScenario first = Read(circle_ + "variation: repeat\nseed: 1\n");
  const ResolvedScenario second = Read(circle_ + "variation: repeat\nseed: 2\n");
  EXPECT_NE(*first.start, *second.start);
  EXPECT_NE(first.scene.light, second.scene.light);
  EXPECT_NE(Layout(first.scene), Layout(second.scene));
  const ResolvedScenario again = first.WithSeed(2);
  EXPECT_EQ(*again.start, *second.start);
  EXPECT_EQ(again.scene.light, second.scene.light);
  EXPECT_EQ(Layout(again.scene), Layout(second.scene));
  EXPECT_EQ(HashOf(again), HashOf(second));
  // A job reads what a suite has resolved: the file with every default written out.
  std::ofstream(temporary_.path() / "again.yaml") << second.ToYaml();
  EXPECT_EQ(*ReadScenario(temporary_.path() / "again.yaml", {}).start, *second.start);
}

TEST_F(VariationTest, DrawsFillTheStatedLimitsWhereThereIsRoom) {
  const ResolvedScenario open = Read("scene: plain\npath: {length_m: 1}\nvariation: repeat\n");
  const Eigen::Vector3d nominal = Read("scene: plain\npath: {length_m: 1}\n").scene.start;
  Eigen::Vector3d most = Eigen::Vector3d::Zero(), sum = most;
  double dimmest = 2, brightest = 0;
  constexpr int kSeeds = 200;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Eigen::Vector3d off = *open.WithSeed(seed).start - nominal;
    off.z() -= nominal.z() * (kDegPerRad - 1);  // scenes have radians
    most = most.cwiseMax(off.cwiseAbs());
    sum += off;
    const double light = open.WithSeed(seed).scene.light;
    dimmest = std::min(dimmest, light);
    brightest = std::max(brightest, light);
  }
  // 200 uniform draws: the largest is within 5 % of the limit but for a chance of 3e-5; the mean is known to 1/25 of
  // it.
  for (const auto& [i, limit] : {std::pair{0, 0.15}, {1, 0.15}, {2, 10.0}}) {
    EXPECT_LE(most[i], limit);
    EXPECT_GT(most[i], 0.95 * limit);
    EXPECT_NEAR(sum[i] / kSeeds, 0, 0.17 * limit);
  }
  EXPECT_GE(dimmest, 0.8);
  EXPECT_LT(dimmest, 0.82);
  EXPECT_LE(brightest, 1.2);
  EXPECT_GT(brightest, 1.18);
}

TEST_F(VariationTest, NoPathLeadsIntoAnything) {
  for (const char* name : {"lab_loop", "corridor_40m", "corridor_loops", "floor_box", "floor_loop", "khr1hv_loops"}) {
    const std::filesystem::path file = DataFolder() / "scenarios" / (std::string(name) + ".yaml");
    const ResolvedScenario plain = ReadScenario(file, {});
    const Eigen::Vector3d of_scene(plain.scene.start.x(), plain.scene.start.y(), plain.scene.start.z() * kDegPerRad);
    const double kept = Clearance(plain.scenario.path, 1, plain.start.value_or(of_scene), plain.scene, kAll);
    ASSERT_GT(kept, 0) << name;
    const ResolvedScenario varied = ReadScenario(file, {"variation=repeat"});
    std::set<double> headings;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      const ResolvedScenario repeat = varied.WithSeed(seed);
      EXPECT_GE(Clearance(repeat.scenario.path, 1, *repeat.start, repeat.scene, kAll), std::min(0.25, 0.4 * kept))
          << name << ", seed " << seed;
      headings.insert(repeat.start->z());
    }
    EXPECT_EQ(headings.size(), 8U) << name;
  }
}

TEST_F(VariationTest, ClearanceIsTheDistanceToWhatStandsThereAndToTheFloorsEdge) {
  Scene scene;
  scene.floor_min = {-5, -5};
  scene.floor_max = {5, 5};
  SceneBox box;
  box.size = {0.4, 0.4, 0.5};
  box.X_WB = Pose(RotZ(kPi / 4), {1, 1, 0.25});
  scene.boxes = {box};
  PathOptions straight;
  straight.length_m = 2;
  // The box's corner lies 0.2 sqrt(2) from its middle, towards the path along the x axis.
  EXPECT_NEAR(Clearance(straight, 1, {0, 0, 0}, scene, kAll), 1 - 0.2 * std::sqrt(2.0), 1e-3);
  EXPECT_LT(Clearance(straight, 1, {0, 1, 0}, scene, kAll), 0);
  scene.boxes[0].collides = false;
  EXPECT_NEAR(Clearance(straight, 1, {0, 0, 0}, scene, kAll), 3, 1e-9);  // from (2, 0) to x = 5
  scene.boxes[0].collides = true;
  scene.boxes[0].X_WB.translation.z() = 3;  // a lamp
  EXPECT_NEAR(Clearance(straight, 1, {0, 0, 0}, scene, kAll), 3, 1e-9);
}

// Round a table on a circle of 2 m there is no way; the first seconds of it are free.
TEST_F(VariationTest, OnlyWhatIsWalkedBeforeTheTimeIsUpMustBeFree) {
  const std::string circle = "scene: lab\npath: {kind: circle, diameter_m: 2}\nvariation: repeat\n";
  EXPECT_TRUE(Read(circle + "duration_s: 6.5\n").start.has_value());
  EXPECT_THROW(Read(circle + "duration_s: 0\n"), BadInput);
  PathOptions straight;
  straight.length_m = 4;
  Scene scene;
  scene.floor_min = {-5, -5};
  scene.floor_max = {5, 5};
  EXPECT_NEAR(Clearance(straight, 0.5, {0, 0, 0}, scene, kAll), 3, 1e-9);
}

TEST_F(VariationTest, WhatCannotBeIsRefusedInOneLine) {
  const auto refusal = [&](const std::string& text) {
    try {
      Read(text);
    } catch (const BadInput& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal("variation: repeated\n"), testing::AllOf(HasSubstr("s.yaml:1"), HasSubstr("repeat")));
  EXPECT_THAT(refusal("variation: {start: 1}\n"), HasSubstr("start_m"));
  EXPECT_THAT(refusal("scene: lab\npath: {kind: straight, length_m: 30}\nduration_s: 0\nvariation: repeat\n"),
              testing::AllOf(HasSubstr("s.yaml:4"), HasSubstr("off the floor")));
}

TEST_F(VariationTest, MassAndFrictionAreOffByTheLargerOfBoth) {
  VariationOptions o = VariationOptions::Of(VariationPreset::kRepeat);
  PhysicsOptions physics;
  EXPECT_EQ(Varied(physics, o).mass_noise_ratio, 0.1);
  EXPECT_EQ(Varied(physics, o).friction_noise_ratio, 0.1);
  physics.mass_noise_ratio = 0.3;
  EXPECT_EQ(Varied(physics, o).mass_noise_ratio, 0.3);
}

}  // namespace
}  // namespace gaitcam
