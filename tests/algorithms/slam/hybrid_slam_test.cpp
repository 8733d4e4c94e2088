#include "algorithms/slam/hybrid_slam.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "algorithms/core/errors.h"
#include "algorithms/core/planar_pose.h"
#include "tests/algorithms/odometry/odometry_trials.h"
#include "tests/algorithms/slam/taught_room.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

/// 50 cm to the side and back to where it began, in 40 frames, with wheels that say so.
const Film& OutAndBack() {
  static const Film film = [] {
    constexpr double kTurn_s = 0.667, kTimesAsFast = 3;
    const auto pose = [](double t_s) { return SidewaysPose(kTimesAsFast * (t_s < kTurn_s ? t_s : 2 * kTurn_s - t_s)); };
    Film made = FilmPath(Room(), kCamera, 40, pose, 5, 1);
    const Pose X_CB = DepthAndWheels().odometry.X_BC.Inverse();
    // Two readings per frame, the second at its stamp: where the camera turns round at once, none can be extrapolated.
    constexpr int64_t kPeriod_ns = 16'666'666;
    int64_t next_ns = made.frames.front().stamp_ns - kPeriod_ns;
    for (size_t i = 0; i < made.frames.size(); ++i) {
      Observation& frame = made.frames[i];
      frame.depth = Image{frame.stamp_ns, Room().Depth(kCamera, made.truth[i].pose)};
      for (; next_ns <= frame.stamp_ns; next_ns += kPeriod_ns) {
        const PlanarPose body(pose(double(next_ns - 1'000'000'000) * 1e-9) * X_CB);
        frame.odometry.push_back({next_ns, body.position, body.heading});
      }
    }
    return made;
  }();
  return film;
}

HybridSlamOptions Near() {
  HybridSlamOptions options;
  options.sight.sensitivity = 4;  // small pictures with noise: the weakest features are of the noise
  options.model_m = 0.03;
  options.search.apart_models = 4;
  return options;
}

struct Learned {
  std::vector<FrameEstimate> live, final;
  PoseGraph graph;

  Learned(const HybridSlamOptions& options, const std::vector<Observation>& frames,
          const Calibration& calibration = DepthAndWheels()) {
    HybridSlam slam(calibration, options, 1);
    for (const Observation& frame : frames) live.push_back(slam.Track(frame));
    final = slam.Finish();
    graph = slam.graph();
  }
  int Links(bool loop, bool dead_reckoned) const {
    return int(std::count_if(graph.links.begin(), graph.links.end(), [&](const GraphLink& link) {
      return link.loop == loop && link.dead_reckoned == dead_reckoned && link.trust > 0.5;
    }));
  }
};

/// Distance of a frame's pose from the true one, both from the first frame on.
double Error_m(size_t frame, const Pose& X_WC) {
  const Trajectory& truth = OutAndBack().truth;
  return (X_WC.translation - (truth.front().pose.Inverse() * truth[frame].pose).translation).norm();
}

/// The largest of all frames that have a pose.
double Worst_m(const std::vector<FrameEstimate>& answers) {
  double worst = 0;
  for (size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].pose) worst = std::max(worst, Error_m(i, *answers[i].pose));
  }
  return worst;
}

// A pixel is 14 mm on the wall, of which a feature is off by half, and fits are of dozens of them.
constexpr double kTolerance_m = 0.015;

TEST(HybridSlam, TracksAndClosesLoopsInEitherDirectionAndByEitherCorrection) {
  for (const IcgmDirection direction : {IcgmDirection::kSingle, IcgmDirection::kDouble}) {
    for (const LoopCorrection correction : {LoopCorrection::kGraph, LoopCorrection::kSemiConsensus}) {
      HybridSlamOptions options = Near();
      options.robust.icgm.direction = direction;
      options.correction = correction;
      const Learned learned(options, OutAndBack().frames);
      ASSERT_EQ(learned.live.size(), 40u);
      ASSERT_EQ(learned.final.size(), 40u);
      for (const FrameEstimate& answer : learned.live) ASSERT_TRUE(answer.pose);
      EXPECT_LT(Worst_m(learned.live), kTolerance_m);
      EXPECT_LT(Worst_m(learned.final), kTolerance_m);
      EXPECT_GE(learned.Links(true, false), 1);
      EXPECT_EQ(learned.Links(false, true), 0) << "all of it is seen";
      EXPECT_EQ(learned.final.back().covariance.has_value(), correction == LoopCorrection::kGraph);
    }
  }
}

/// Black from frame 10 to 14: 12 cm without sight, so that the last model is hardly in sight afterwards.
std::vector<Observation> Blinded(bool wheels) {
  std::vector<Observation> frames = OutAndBack().frames;
  const cv::Mat black(frames.front().image.pixels.size(), CV_8UC1, cv::Scalar(0));
  for (size_t i = 0; i < frames.size(); ++i) {
    if (i >= 10 && i < 15) frames[i].image.pixels = black;
    if (!wheels) frames[i].odometry.clear();
  }
  return frames;
}

TEST(HybridSlam, WheelsGoOnWhereNothingIsSeen) {
  const Learned learned(Near(), Blinded(true));
  for (size_t i = 0; i < learned.live.size(); ++i) {
    const FrameEstimate& answer = learned.live[i];
    const bool blind = i >= 10 && i < 15;
    EXPECT_EQ(answer.status, blind ? TrackingStatus::kLost : TrackingStatus::kTracking) << i;
    EXPECT_EQ(answer.pose.has_value(), !blind) << i;
    EXPECT_EQ(answer.predicted.has_value(), blind) << i << ": a pose by wheels is no measurement of the camera";
    if (blind) {
      EXPECT_LT(Error_m(i, *answer.predicted), kTolerance_m) << i;
    }
  }
  EXPECT_GE(learned.Links(false, true), 1);
  EXPECT_GT(learned.Links(false, false), learned.Links(false, true));
  EXPECT_LT(Worst_m(learned.live), kTolerance_m);
}

TEST(HybridSlam, WithoutWheelsTheSameFramesAreLostAndThenFoundAgain) {
  const Learned learned(Near(), Blinded(false));
  for (size_t i = 10; i < 15; ++i) {
    EXPECT_EQ(learned.live[i].status, TrackingStatus::kLost);
    EXPECT_FALSE(learned.live[i].pose);
    EXPECT_TRUE(learned.live[i].predicted);
  }
  EXPECT_EQ(learned.Links(false, true), 0);
  EXPECT_TRUE(learned.final.back().pose);
  EXPECT_LT(Worst_m(learned.final), kTolerance_m);
}

TEST(HybridSlam, SaysTheSameTwice) {
  const Learned a(Near(), OutAndBack().frames), b(Near(), OutAndBack().frames);
  for (size_t i = 0; i < a.final.size(); ++i) {
    ASSERT_TRUE(a.final[i].pose && b.final[i].pose) << i;
    ASSERT_TRUE(a.live[i].pose && b.live[i].pose) << i;
    EXPECT_EQ(a.final[i].pose->translation, b.final[i].pose->translation);
    EXPECT_EQ(a.live[i].pose->rotation.coeffs(), b.live[i].pose->rotation.coeffs());
  }
}

TEST(HybridSlam, LiveAnswersKnowNothingOfLaterFrames) {
  const std::vector<Observation> half(OutAndBack().frames.begin(), OutAndBack().frames.begin() + 25);
  const Learned part(Near(), half), whole(Near(), OutAndBack().frames);
  for (size_t i = 0; i < half.size(); ++i) {
    ASSERT_TRUE(part.live[i].pose && whole.live[i].pose) << i;
    EXPECT_EQ(part.live[i].pose->translation, whole.live[i].pose->translation) << i;
  }
}

TEST(HybridSlam, RefusesACameraWithoutDepthAndAFrameWithoutIt) {
  EXPECT_NE(ErrorOf([] { HybridSlam(OneCamera(), {}, 1); }).find("needs depth images"), std::string::npos);
  HybridSlam slam(DepthAndWheels(), {}, 1);
  Observation blind = OutAndBack().frames.front();
  blind.depth.reset();
  EXPECT_NE(ErrorOf([&] { slam.Track(blind); }).find("has no depth image"), std::string::npos);
  blind.depth = Image{blind.stamp_ns, cv::Mat::ones(10, 10, CV_32FC1)};
  EXPECT_NE(ErrorOf([&] { slam.Track(blind); }).find("size of the image"), std::string::npos);
}

}  // namespace
}  // namespace gaitcam
