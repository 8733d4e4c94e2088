#include "algorithms/places/scan_controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cylinder_world.h"

namespace gaitcam {
namespace {

using State = ScanController::State;
constexpr double kDegree = std::numbers::pi / 180;

/// A robot in one room, ten frames per second.
class ScanControllerTest : public testing::Test {
 protected:
  Observation Next(std::optional<double> pan_deg) {
    Observation observation;
    observation.stamp_ns = stamp_ns_ += 100'000'000;
    observation.image = {stamp_ns_, room_.View(Ers7Camera(), up_C_, pan_deg.value_or(0) * kDegree)};
    if (pan_deg) observation.scan = ScanState{*pan_deg * kDegree, 0};
    return observation;
  }
  std::optional<ScanController::Scan> Walk(int frames, double heading_rad = 0) {
    std::optional<ScanController::Scan> scan;
    for (int k = 0; k < frames && !scan; ++k) scan = controller_.Add(Next(std::nullopt), heading_rad);
    return scan;
  }
  /// From left to right; a gyroscope in the head turns with it.
  void Pan(double from_deg, double to_deg, double body_rad = 0) {
    for (double pan = from_deg; pan >= to_deg; pan -= 12)
      EXPECT_FALSE(controller_.Add(Next(pan), body_rad + pan * kDegree));
  }

  CylinderWorld room_{1};
  Eigen::Vector3d up_C_ = UpOf(4);
  int64_t stamp_ns_ = 0;
  PanoramaLayout layout_ = LayoutFor(Ers7Camera(), up_C_, 720, 160);
  CylinderProjection projection_{Ers7Camera(), up_C_, layout_};
  ScanController controller_{projection_, layout_, {{}, 1.0, 5.0}};
};

TEST_F(ScanControllerTest, GoesThroughItsStatesInTheOrderOfItsTable) {
  EXPECT_EQ(controller_.state(), State::kAsking);
  Walk(3);
  EXPECT_EQ(controller_.state(), State::kAsking);
  Pan(180, -180);
  EXPECT_EQ(controller_.state(), State::kScanning);
  EXPECT_TRUE(controller_.wants_scan());
  const auto scan = Walk(1);
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->panorama.image.size(), cv::Size(720, 160));
  EXPECT_EQ(scan->began_ns, 400'000'000);
  EXPECT_EQ(controller_.state(), State::kSettling);
  EXPECT_FALSE(controller_.wants_scan());
  Walk(9);
  EXPECT_EQ(controller_.state(), State::kSettling);  // 0.9 of 1.0 s
  Walk(1);
  EXPECT_EQ(controller_.state(), State::kWalking);
  controller_.Ask();
  EXPECT_EQ(controller_.state(), State::kAsking);
  EXPECT_FALSE(controller_.failed());
}

TEST_F(ScanControllerTest, WaitsForTheSecondHalfOfAScan) {
  Pan(180, 0);
  EXPECT_FALSE(Walk(5));  // the body turns
  EXPECT_EQ(controller_.state(), State::kScanning);
  Pan(0, -180);
  EXPECT_TRUE(Walk(1));
}

TEST_F(ScanControllerTest, WalksOnOnceAFootIsLifted) {
  Pan(180, -180);
  ASSERT_TRUE(Walk(1));
  for (const bool lifted : {false, true}) {
    for (int k = 0; k < 20; ++k) {
      Observation observation = Next(std::nullopt);
      JointSample sample;
      sample.left_contact = true;
      sample.right_contact = !lifted;
      observation.joints = {sample, sample};
      controller_.Add(observation, 0);
    }
    EXPECT_EQ(controller_.state(), lifted ? State::kWalking : State::kSettling);
  }
}

TEST_F(ScanControllerTest, AHeadThatHasTurnedToWhereASweepBeginsIsNotTheBody) {
  Walk(2, 0.1);
  Pan(180, -180, 0.15);  // the body has turned by 0.05 rad as it came to a halt
  const auto scan = Walk(1);
  ASSERT_TRUE(scan);
  EXPECT_NEAR(scan->ahead_rad, 0.15, 1e-12);
}

TEST_F(ScanControllerTest, FailsWhenItsPatienceIsOver) {
  Walk(51);  // 5.0 s since the first
  EXPECT_FALSE(controller_.failed());
  EXPECT_THAT(controller_.MissingText(), testing::HasSubstr("none came"));
  Walk(1);
  EXPECT_TRUE(controller_.failed());
  EXPECT_FALSE(controller_.wants_scan()) << "the body must not stand for ever";
  Pan(180, -180);
  Walk(200);
  EXPECT_TRUE(controller_.failed());
  EXPECT_THAT(controller_.MissingText(), testing::HasSubstr("none came"));
}

TEST_F(ScanControllerTest, AScanWithAGapFailsAndLetsTheBodyGo) {
  Pan(180, 20);
  Pan(-100, -180);
  Walk(53);
  EXPECT_TRUE(controller_.failed());
  EXPECT_FALSE(controller_.wants_scan());
  EXPECT_THAT(controller_.MissingText(), testing::HasSubstr("of 360 deg unseen"));
}

}  // namespace
}  // namespace gaitcam
