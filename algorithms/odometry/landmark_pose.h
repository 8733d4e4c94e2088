/// Where a camera stands that sees landmarks of a map. Near the place where it is expected a turn alone has to be
/// found; elsewhere three landmarks make a hypothesis. All that agree with it, each as exactly as its depth is known,
/// decide; depths that are not known constrain the turn alone.
///
/// Frames that are blurred more than their features can tell place them badly: where nothing agrees, a second look
/// expects more noise. Far from where the camera is expected chance agrees upon something too, on a floor of a thousand
/// like pebbles above all: there it takes many sightings, or the frame has no pose. Who asks marks such a step.

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/odometry/landmark_map.h"
#include "algorithms/odometry/landmark_search.h"

namespace gaitcam {

struct LandmarkPoseOptions {
  using DescribedTag = void;

  double sigma_px = 0.4;              ///< Standard deviation of where a feature is seen, px, for the smallest ...
  double sigma_per_size = 0.05;       ///< ... and what each px of a keypoint's diameter adds to it.
  double search_deg = 10;             ///< How far from where it is predicted a point is looked for first.
  double outlier_sigmas = 3.0;        ///< A sighting further from its projection is not believed.
  double noise_of_second_look = 2.5;  ///< Where no pose is agreed upon, noise may be so many times larger.
  double usual_speed = 0.6;           ///< Median depths per second: what is expected of the camera, along each axis.
  int min_inliers = 15;               ///< With fewer a frame has no pose.
};

template <class Visitor>
void VisitFields(Visitor& visit, LandmarkPoseOptions& o) {
  visit("sigma_px", o.sigma_px, Between(0.01, 100.0), "standard deviation of the smallest feature's place");
  visit("sigma_per_size", o.sigma_per_size, Between(0.0, 10.0), "what each px of a keypoint's diameter adds");
  visit("search_deg", o.search_deg, Between(0.1, 180.0), "how far from its prediction a point is looked for");
  visit("outlier_sigmas", o.outlier_sigmas, Between(1.0, 100.0), "sightings further off are not believed");
  visit("noise_of_second_look", o.noise_of_second_look, Between(1.0, 100.0), "noise allowed where nothing agrees");
  visit("usual_speed", o.usual_speed, Between(0.001, 1e6), "median depths per second that the camera usually moves");
  visit("min_inliers", o.min_inliers, Between(6, 100000), "with fewer inliers a frame has no pose");
}

/// What is expected of a frame before it is looked at.
struct LandmarkPoseGuess {
  Pose X_WC;                           ///< Landmarks are looked for from here first.
  std::optional<PositionPrior> prior;  ///< Nothing: one place is as likely as another.
  double usual_inliers = 0;            ///< Half of these are needed away from the prior.
  int fewest_inliers = 0;              ///< That will do near the prior, if the options' are too many.
};

struct LandmarkPose {
  Pose X_WC;
  std::vector<LandmarkMatch> inliers;
};

/// A pose at a time.
struct StampedPlace {
  Pose X_WC;
  int64_t stamp_ns = 0;
};

class LandmarkPlacer {
 public:
  /// @param ratio nearest over second nearest descriptor distance
  LandmarkPlacer(double focal_px, double ratio, const LandmarkPoseOptions& options)
      : focal_px_(focal_px), ratio_(ratio), options_(options) {}

  /// A walker's camera is about where it was.
  PositionPrior Expect(const Eigen::Vector3d& place_W, int64_t apart_ns, double median_depth) const {
    return {place_W, options_.usual_speed * median_depth * double(apart_ns) * 1e-9};
  }

  /// Whether a camera that is expected at `prior` can be there.
  static bool IsWithinReach(const PositionPrior& prior, const Pose& X_WC) {
    constexpr double kTooFar = 4;  // standard deviations
    return (X_WC.translation - prior.position_W).norm() < kTooFar * prior.sigma;
  }

  /// Whether no camera that is carried gets from there to here: believed because many landmarks say so, but marked.
  static bool IsJump(const PositionPrior& prior, const Pose& X_WC) {
    constexpr double kNeverCarried = 8;  // standard deviations: 5 median depths a second
    return (X_WC.translation - prior.position_W).norm() >= kNeverCarried * prior.sigma;
  }

  /// @returns nothing where no pose is agreed upon, with more noise neither. Never NaN.
  std::optional<LandmarkPose> Place(const LandmarkMap& map, const FrameView& view, const LandmarkPoseGuess& guess,
                                    RandomStream& random) const;

  /// One look.
  /// @param noise times so much worse than `view.sigma` says the features may be placed
  std::optional<LandmarkPose> PlaceWithNoise(const LandmarkMap& map, const FrameView& view,
                                             const LandmarkPoseGuess& guess, double noise, RandomStream& random) const;

  /// A frame that could not be placed when it came, between two that could: it is expected better now, and may be
  /// searched more closely. It makes no jump.
  std::optional<LandmarkPose> PlaceBetween(const LandmarkMap& map, const FrameView& view, int64_t stamp_ns,
                                           const StampedPlace& before, const StampedPlace& after, double median_depth,
                                           double usual_inliers, RandomStream& random) const;

  /// The landmarks that a frame sees which stands at `view.X_WC`, whoever has said so.
  std::vector<LandmarkMatch> Find(const LandmarkMap& map, const FrameView& view) const;

 private:
  class Look;
  LandmarkSearchOptions SearchOptions(double radius, double ratio) const;
  std::optional<LandmarkPose> PlaceClosely(const LandmarkMap& map, const FrameView& view,
                                           const LandmarkPoseGuess& guess, double noise, RandomStream& random) const;

  double focal_px_, ratio_;
  LandmarkPoseOptions options_;
};

/// A blurred frame places its features worse than a sharp one, by blur that its keypoints do not tell: scales
/// `view.sigma` by what the residuals of `matches` say, in bounds.
void ScaleNoise(const LandmarkMap& map, const std::vector<LandmarkMatch>& matches, FrameView& view);

}  // namespace gaitcam
