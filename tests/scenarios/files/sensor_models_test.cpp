// What a scenario says of its depth camera and of its body's odometry.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "scenarios/code/files/scenario.h"
#include "tests/data_folder.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SensorModels : public testing::Test {
 protected:
  SensorModels() { setenv("GAITCAM_DATA", TestData().c_str(), 1); }
  ResolvedScenario Read(const std::string& text) const {
    std::ofstream(temporary_.path() / "s.yaml") << "robot: omni_base\n" << text;
    return ReadScenario(temporary_.path() / "s.yaml", {});
  }
  const TemporaryFolder temporary_;
};

TEST_F(SensorModels, ScenariosThatDoNotNameThemAreWhatTheyWere) {
  const ResolvedScenario plain = Read("camera: {depth: true}\n");
  EXPECT_THAT(plain.ToYaml(), AllOf(Not(HasSubstr("depth_model")), Not(HasSubstr("odometry"))));
  const ResolvedScenario ideal = Read("camera: {depth: true, depth_model: ideal}\n");
  EXPECT_EQ(ideal.ToYaml(), plain.ToYaml());
  EXPECT_EQ(HashOf(ideal), HashOf(plain));
  EXPECT_EQ(FramesHashOf(ideal), FramesHashOf(plain));
}

TEST_F(SensorModels, WhatTheyAreSetToComesBackAndBelongsToTheFrames) {
  const std::string plain = FramesHashOf(Read("camera: {depth: true}\n"));
  for (const char* text : {"camera: {depth: true, depth_model: structured_light}\n",
                           "camera: {depth: true}\nsensors: {odometry: {slip_per_sqrt_m: 0.01}}\n"}) {
    const ResolvedScenario read = Read(text);
    EXPECT_NE(FramesHashOf(read), plain);
    temporary_.Write("again.yaml", read.ToYaml());
    const ResolvedScenario again = ReadScenario(temporary_.path() / "again.yaml", {});
    EXPECT_EQ(again.ToYaml(), read.ToYaml());
    EXPECT_EQ(again.scenario.camera.depth_model, read.scenario.camera.depth_model);
    EXPECT_EQ(again.scenario.sensors.odometry.has_value(), read.scenario.sensors.odometry.has_value());
  }
}

TEST_F(SensorModels, WhatTheyCannotBeIsRefusedInItsLine) {
  EXPECT_THAT(ErrorOf([&] { Read("camera: {depth: true, depth_model: kinect}\n"); }),
              AllOf(HasSubstr("s.yaml:2"), HasSubstr("structured_light")));
  EXPECT_THAT(ErrorOf([&] { Read("camera: {depth_model: time_of_flight}\n"); }),
              AllOf(HasSubstr("s.yaml"), HasSubstr("camera.depth: true")));
  EXPECT_THAT(ErrorOf([&] { Read("sensors: {odometry: {rate_hz: 0}}\n"); }),
              AllOf(HasSubstr("s.yaml:2"), HasSubstr("odometry.rate_hz")));
  EXPECT_THAT(ErrorOf([&] { Read("sensors: {odometry: {wheel: 0}}\n"); }), HasSubstr("wheel_radius_pct"));
}

}  // namespace
}  // namespace gaitcam
