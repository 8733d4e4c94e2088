/// The pose of a camera from the landmarks of a map.
///
/// Near the predicted position only a rotation has to be found; elsewhere three landmarks make a hypothesis (P3P). The
/// pose is refined over all inliers, each weighted by how exactly its depth is known: landmarks of unknown depth
/// constrain the rotation alone.
///
/// A blurred frame locates its features worse than their keypoints tell: where no consensus is found, a second attempt
/// assumes more noise. Far from the prediction a consensus by chance is likely in repetitive texture: there at least
/// half of the expected inliers are required, or the frame gets no pose.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/pose.h"
#include "algorithms/core/random.h"
#include "algorithms/odometry/keyframe_map.h"
#include "algorithms/odometry/landmark_search.h"

namespace gaitcam {

struct LandmarkLocalizerOptions {
  using DescribedTag = void;

  double sigma_px = 0.4;            ///< Standard deviation of a feature's position, px, for a keypoint of size 0 ...
  double sigma_per_size = 0.05;     ///< ... and what each px of a keypoint's diameter adds to it.
  double search_deg = 10;           ///< Radius around its prediction in which a landmark is searched for first.
  double outlier_sigmas = 3.0;      ///< Largest Mahalanobis distance of an inlier.
  double retry_noise_factor = 2.5;  ///< The second attempt multiplies the features' standard deviations by this.
  double usual_speed = 0.6;         ///< Median depths per second: standard deviation of the expected velocity per axis.
  int min_inliers = 15;             ///< With fewer a frame has no pose.
};

template <class Visitor>
void VisitFields(Visitor& visit, LandmarkLocalizerOptions& o) {
  visit("sigma_px", o.sigma_px, Between(0.01, 100.0), "standard deviation of the smallest feature's position, px");
  visit("sigma_per_size", o.sigma_per_size, Between(0.0, 10.0), "what each px of a keypoint's diameter adds to it");
  visit("search_deg", o.search_deg, Between(0.1, 180.0), "search radius around a landmark's prediction, degrees");
  visit("outlier_sigmas", o.outlier_sigmas, Between(1.0, 100.0), "largest Mahalanobis distance of an inlier");
  visit("retry_noise_factor", o.retry_noise_factor, Between(1.0, 100.0), "noise of the second attempt over the first");
  visit("usual_speed", o.usual_speed, Between(0.001, 1e6), "standard deviation of the velocity, median depths per s");
  visit("min_inliers", o.min_inliers, Between(6, 100000), "with fewer inliers a frame has no pose");
}

/// What is known of a frame's pose before its landmarks are searched for.
struct PosePrediction {
  Pose X_WC;                           ///< Landmarks are searched for from here first.
  std::optional<PositionPrior> prior;  ///< Nothing: any position is as likely as another.
  double expected_inliers = 0;         ///< Half of these are required away from the prior.
  int min_inliers = 0;                 ///< Required near the prior; 0: the options' min_inliers.
};

struct LandmarkPose {
  Pose X_WC;
  std::vector<LandmarkMatch> inliers;
  int matches = 0;  ///< Found near where this pose expects them; the inliers are of these.
};

class LandmarkLocalizer {
 public:
  /// @param ratio nearest over second nearest descriptor distance
  LandmarkLocalizer(double focal_px, double ratio, const LandmarkLocalizerOptions& options)
      : focal_px_(focal_px), ratio_(ratio), options_(options) {}

  /// @param position_W where the camera is expected to be `apart_ns` after it was seen last
  /// @returns it with a standard deviation of usual_speed times the time.
  PositionPrior PredictPosition(const Eigen::Vector3d& position_W, int64_t apart_ns, double median_depth) const {
    return {position_W, options_.usual_speed * median_depth * double(apart_ns) * 1e-9};
  }

  /// The pose lies within 4 standard deviations of the prior.
  static bool IsWithinReach(const PositionPrior& prior, const Pose& X_WC) {
    constexpr double kMaxSigmas = 4;
    return (X_WC.translation - prior.position_W).norm() < kMaxSigmas * prior.sigma;
  }

  /// @returns nothing where no consensus is found in three attempts. Never NaN.
  std::optional<LandmarkPose> Localize(const KeyframeMap& map, const FrameView& view, const PosePrediction& prediction,
                                       RandomStream& random) const;

  /// One attempt.
  /// @param noise factor on the standard deviations `view.sigma`
  std::optional<LandmarkPose> LocalizeWithNoise(const KeyframeMap& map, const FrameView& view,
                                                const PosePrediction& prediction, double noise,
                                                RandomStream& random) const;

  /// A frame that got no pose when it came, between two that have one: the prediction is interpolated, so that half of
  /// the inliers and a narrower search will do. The result is within reach of the prediction.
  std::optional<LandmarkPose> LocalizeBetween(const KeyframeMap& map, const FrameView& view, int64_t stamp_ns,
                                              const StampedPose& before, const StampedPose& after, double median_depth,
                                              double expected_inliers, RandomStream& random) const;

  /// The position from which landmarks are seen at a rotation that is known otherwise.
  /// @param X_WC about where, and the rotation
  Pose Reposition(const KeyframeMap& map, const FrameView& view, const std::vector<LandmarkMatch>& inliers,
                  const Pose& X_WC, const PositionPrior& prior) const;

 private:
  class Attempt;
  static constexpr double kHuber = 2;  ///< Standard deviations.
  /// What does not depend on the noise that an attempt assumes, found when the first one asks for it.
  struct Candidates {
    std::optional<std::vector<LandmarkMatch>> nearby, anywhere;
  };
  LandmarkSearchOptions SearchOptions(double radius, double ratio) const;
  std::optional<LandmarkPose> LocalizeSoon(const KeyframeMap& map, const FrameView& view,
                                           const PosePrediction& prediction, RandomStream& random) const;
  std::optional<LandmarkPose> LocalizeAmong(Candidates& candidates, const KeyframeMap& map, const FrameView& view,
                                            const PosePrediction& prediction, double noise, RandomStream& random) const;
  std::optional<LandmarkPose> LocalizeNearby(const KeyframeMap& map, const FrameView& view,
                                             const PosePrediction& prediction, double noise,
                                             RandomStream& random) const;

  double focal_px_, ratio_;
  LandmarkLocalizerOptions options_;
};

/// Scales `view.sigma` by the median residual of `matches`, by 0.5 to 3: blur that the keypoints' sizes do not tell.
void ScaleNoise(const KeyframeMap& map, const std::vector<LandmarkMatch>& matches, FrameView& view);

}  // namespace gaitcam
