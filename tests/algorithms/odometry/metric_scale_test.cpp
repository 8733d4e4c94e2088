#include "algorithms/odometry/metric_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

constexpr double kHeight_m = 0.35;

/// A camera that walks straight on, looking 20 degrees down, and sees points through eight keyframes; W is level.
class WalkedMap {
 public:
  /// @param points in W, m. @param assumed inverse depths that the map is told with 6 %, by camera and point; 0: none.
  explicit WalkedMap(const std::vector<Eigen::Vector3d>& points,
                     const std::function<double(const Pose&, const Eigen::Vector3d&)>& assumed = nullptr) {
    RandomStream random(5, "map");
    std::vector<int> landmark_of(points.size(), -1);
    for (int k = 0; k < 8; ++k) {
      FrameView view;
      view.X_WC = CameraAt(k);
      std::vector<LandmarkMatch> matches;
      std::vector<size_t> seen;
      for (size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d p_C = view.X_WC.Inverse() * points[i];
        if (p_C.z() < 0.2 || p_C.hnormalized().norm() > 0.6) continue;
        if (landmark_of[i] >= 0) matches.push_back({landmark_of[i], int(view.xy.size())});
        view.xy.push_back(p_C.hnormalized() + 0.001 * Eigen::Vector2d(random.Normal(), random.Normal()));
        view.sigma.push_back(0.001);
        seen.push_back(i);
      }
      view.features.descriptors = cv::Mat(int(seen.size()), 1, CV_32FC1);
      for (size_t j = 0; j < seen.size(); ++j) view.features.descriptors.at<float>(int(j), 0) = float(seen[j]);
      size_t next = 0;
      const auto prior = [&](const Pose& X_WC, const Eigen::Vector2d& xy) -> std::optional<DepthPrior> {
        while (view.xy[next] != xy) ++next;  // asked in the order of the features
        const double rho = assumed ? assumed(X_WC, points[seen[next]]) : 0;
        if (rho > 0) return DepthPrior{rho, 0.06 * rho};
        return std::nullopt;
      };
      map_.AddKeyframe(view, matches, 1, prior);
      landmark_of.assign(points.size(), -1);
      for (size_t j = 0; j < map_.landmarks().size(); ++j) {
        landmark_of[size_t(map_.landmarks()[j].descriptor.at<float>(0, 0))] = int(j);
      }
    }
  }
  const KeyframeMap& map() const { return map_; }
  Carried AsCarried(const Eigen::Matrix3d& tilt = Eigen::Matrix3d::Identity()) const {
    Carried carried{tilt * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()};
    for (const Pose& X_WC : map_.keyframes()) carried.at_W += X_WC.translation / double(map_.keyframes().size());
    return carried;
  }
  /// The map's unit is its own: metres by the way walked.
  double MetresPerUnit() const {
    const std::vector<Pose>& keyframes = map_.keyframes();
    return (CameraAt(7).translation - CameraAt(0).translation).norm() /
           (keyframes.back().translation - keyframes.front().translation).norm();
  }

 private:
  static Pose CameraAt(int k) {
    const Eigen::Matrix3d level = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
    const double bob_m = 0.003 * std::cos(2.5 * k);
    return {RotY(0.35) * level, Eigen::Vector3d(0.08 * k, 0.01 * std::sin(1.3 * k), kHeight_m + bob_m)};
  }
  KeyframeMap map_{{20, 100, 20, 3.5}};
};

std::vector<Eigen::Vector3d> Points(int floor, int wall, double floor_z = 0) {
  RandomStream random(1, "points");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < floor; ++i) points.emplace_back(random.Uniform(0.7, 2.5), random.Uniform(-1, 1), floor_z);
  for (int i = 0; i < wall; ++i)
    points.emplace_back(random.Uniform(2.4, 2.6), random.Uniform(-1, 1), random.Uniform(0, 0.8));
  return points;
}

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

TEST(MeasureCarriedHeight, IsTheHeightOverTheFloorAmongWallPoints) {
  const WalkedMap walked(Points(200, 100));
  const auto measured = MeasureCarriedHeight(walked.map(), walked.AsCarried());
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->height * walked.MetresPerUnit(), kHeight_m, 0.01 * kHeight_m);
  EXPECT_LT(measured->relative_sigma, 0.03);
  EXPECT_GT(measured->seen_on_floor_W.size(), 100u);
  const Eigen::Vector3d at_W = walked.AsCarried().at_W;
  const Pose X_CW = walked.map().keyframes().back().Inverse();
  for (const Eigen::Vector3d& p_W : measured->seen_on_floor_W) {
    EXPECT_NEAR((p_W - at_W).z() * walked.MetresPerUnit(), -kHeight_m, 0.2 * kHeight_m) << "3 sigmas of a far one";
    EXPECT_LT((X_CW * p_W).hnormalized().norm(), 0.62) << "out of view: 0.6 and noise";
  }
}

TEST(MeasureCarriedHeight, DoesNotConfirmWhatTheMapWasTold) {
  const auto too_high = [](const Pose& X_WC, const Eigen::Vector3d& p) {
    return p.z() == 0 ? 1 / (1.25 * (X_WC.Inverse() * p).z()) : 0;
  };
  const WalkedMap walked(Points(200, 100), too_high);
  const auto measured = MeasureCarriedHeight(walked.map(), walked.AsCarried());
  ASSERT_TRUE(measured);
  EXPECT_NEAR(measured->height * walked.MetresPerUnit(), kHeight_m, 0.02 * kHeight_m);
}

TEST(MeasureCarriedHeight, GravityMayBeADegreeOff) {
  const WalkedMap walked(Points(200, 100));
  for (const double tilt : {-0.017, 0.017}) {
    const auto measured = MeasureCarriedHeight(walked.map(), walked.AsCarried(RotY(tilt)));
    ASSERT_TRUE(measured);
    EXPECT_NEAR(measured->height * walked.MetresPerUnit(), kHeight_m, 0.02 * kHeight_m);
    EXPECT_LT(std::acos(std::min(1.0, measured->normal_W.dot(kUp))), 0.008) << "the floor knows better";
  }
}

TEST(MeasureCarriedHeight, AWallIsNoFloorAndATableIsNone) {
  const WalkedMap wall(Points(0, 200));
  EXPECT_FALSE(MeasureCarriedHeight(wall.map(), wall.AsCarried()));
  std::vector<Eigen::Vector3d> table = Points(100, 0, 0.15);
  for (const Eigen::Vector3d& p : Points(50, 0)) table.push_back(p);
  const WalkedMap walked(table);
  const auto measured = MeasureCarriedHeight(walked.map(), walked.AsCarried());
  EXPECT_TRUE(!measured || measured->height * walked.MetresPerUnit() > 0.9 * kHeight_m);
}

/// Part of a step of the vertical that the mean has taken up after a time, at a frame rate.
double TakenUpAfter(double time_s, double rate_hz) {
  CarriedMean carried;
  const auto stamp_ns = [&](int i) { return int64_t(std::llround(1e9 * i / rate_hz)); };
  const int before = int(6 * rate_hz), after = int(std::lround(time_s * rate_hz));
  const double step = 0.02;
  for (int i = 0; i < before; ++i) carried.Add(stamp_ns(i), kUp, Eigen::Vector3d::Zero());
  for (int i = before; i < before + after; ++i) carried.Add(stamp_ns(i), RotY(step) * kUp, Eigen::Vector3d(step, 0, 0));
  EXPECT_NEAR(carried.mean().at_W.x(), carried.mean().up_W.x(), 1e-4 * step) << "both are means over the same frames";
  return carried.mean().up_W.x() / std::sin(step);
}

TEST(CarriedMean, FollowsWithinTwoSecondsAtAnyFrameRate) {
  for (const double rate_hz : {5.0, 10.0, 15.0, 30.0, 100.0}) {
    // (1 - gain)^n of the old is left: at 5 frames/s 0.9^10 for 1 / e.
    EXPECT_NEAR(TakenUpAfter(2, rate_hz), 1 - std::exp(-1.0), 0.025) << rate_hz;
    EXPECT_GT(TakenUpAfter(6, rate_hz), 0.94) << rate_hz;
  }
}

TEST(CarriedMean, WeighsItsFirstFramesAlikeAndALateFrameByItsTime) {
  CarriedMean carried;
  for (int i = 0; i < 5; ++i) carried.Add(int64_t(i) * 100'000'000, kUp, Eigen::Vector3d(i, 0, 0));
  EXPECT_NEAR(carried.mean().at_W.x(), 2, 1e-12);
  carried.Add(1'400'000'000, kUp, Eigen::Vector3d(7, 0, 0));
  EXPECT_NEAR(carried.mean().at_W.x(), 4.5, 1e-12) << "a second without a pose is half of the time";
  carried.Restart();
  carried.Add(1'500'000'000, kUp, Eigen::Vector3d(1, 0, 0));
  EXPECT_NEAR(carried.mean().at_W.x(), 1, 1e-12);
}

CarriedHeight Measured(double height) { return {height, 0.02, kUp, {}}; }

TEST(MetricScale, IsUnknownUntilMeasuredAndThenKnownBackwards) {
  MetricScale scale(kHeight_m);
  scale.Add(std::nullopt, true);
  scale.Add(std::nullopt, false);
  EXPECT_FALSE(scale.latest());
  for (int k = 0; k < 20; ++k) scale.Add(Measured(0.7), false);
  ASSERT_TRUE(scale.latest());
  EXPECT_NEAR(*scale.latest(), 0.5, 1e-9);
  const std::vector<double> smoothed = scale.Smoothed();
  ASSERT_EQ(smoothed.size(), 22U);
  for (const double s : smoothed) EXPECT_NEAR(s, 0.5, 1e-9);
}

TEST(MetricScale, FollowsADriftingUnitInBothDirections) {
  MetricScale scale(1);
  scale.Add(std::nullopt, true);
  for (int k = 0; k < 200; ++k) scale.Add(Measured(k < 100 ? 1 : 1.1), false);
  EXPECT_NEAR(*scale.latest(), 1 / 1.1, 0.005);
  const std::vector<double> smoothed = scale.Smoothed();
  EXPECT_NEAR(smoothed[20], 1, 0.005);
  EXPECT_NEAR(smoothed[180], 1 / 1.1, 0.005);
  EXPECT_NEAR(smoothed[101], 0.955, 0.01) << "half-way, from both sides";
}

TEST(MetricScale, AnotherMapHasAnotherUnit) {
  MetricScale scale(1);
  scale.Add(std::nullopt, true);
  for (int k = 0; k < 10; ++k) scale.Add(Measured(2), false);
  scale.Add(std::nullopt, true);
  EXPECT_FALSE(scale.latest());
  for (int k = 0; k < 10; ++k) scale.Add(Measured(4), false);
  EXPECT_NEAR(*scale.latest(), 0.25, 1e-9);
  scale.Add(std::nullopt, true);
  const std::vector<double> smoothed = scale.Smoothed();
  EXPECT_NEAR(smoothed[5], 0.5, 1e-9);
  EXPECT_NEAR(smoothed[15], 0.25, 1e-9);
  EXPECT_NEAR(smoothed[22], 0.25, 1e-9) << "never measured: as the map before";
}

}  // namespace
}  // namespace gaitcam
