/// The map of a keyframe odometry: keyframe poses, and landmarks as inverse depths along the rays of the keyframes that
/// first saw them (algorithms/geometry/inverse_depth.h), refined by bundle adjustment over the latest keyframes.
///
/// It knows nothing of images: descriptors are rows to compare, features are normalised image coordinates.

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/geometry/inverse_depth.h"
#include "algorithms/odometry/frame_view.h"

namespace gaitcam {

/// Prior of an inverse depth, in 1 over the map's unit.
struct DepthPrior {
  double rho = 0;
  double sigma = 0;
};

struct LandmarkObservation {
  int keyframe = 0;
  Eigen::Vector2d xy;  ///< Normalised image coordinates.
  double sigma = 0;    ///< Standard deviation of each of them.
};

/// A point of the world, on the ray of its anchor, the keyframe that first saw it.
struct Landmark {
  int anchor = 0;       ///< Index of the keyframe.
  Eigen::Vector2d xy;   ///< Measured in the anchor, normalised image coordinates.
  double sigma = 0;     ///< Standard deviation of that measurement.
  Eigen::Vector2d ray;  ///< Estimated from all observations, in the anchor.
  double rho = 0, rho_sigma = 0;
  double prior_rho = 0, prior_sigma = 0;
  std::vector<LandmarkObservation> observations;  ///< By later keyframes, in order.
  cv::Mat descriptor;                             ///< One row: of the last keyframe that saw it.
  /// One row: of the last frame that saw it, which may be blurred; empty if that is the last keyframe.
  cv::Mat latest;
  int last_keyframe = 0;         ///< The last that saw it.
  bool has_depth_prior = false;  ///< A DepthPrior was given when it was added.

  /// Its depth is known to 30 % or better.
  bool HasDepth() const { return (has_depth_prior || !observations.empty()) && rho > 0 && rho_sigma < 0.3 * rho; }
};

struct KeyframeMapOptions {
  int window = 10;            ///< Keyframes refined together, >= 1.
  int memory = 20;            ///< Keyframes after which a landmark that was not seen again is removed.
  int adjust_iterations = 8;  ///< Largest number of iterations of one bundle adjustment.
  double outlier_sigmas = 3.5;
};

/// Which landmark is which feature of a view.
struct LandmarkMatch {
  int landmark = -1;
  int feature = -1;
};

class KeyframeMap {
 public:
  explicit KeyframeMap(const KeyframeMapOptions& options) : options_(options) {}

  /// The prior of a feature's inverse depth seen from X_WC, if there is one.
  using DepthPriorOf = std::function<std::optional<DepthPrior>(const Pose& X_WC, const Eigen::Vector2d& xy)>;

  /// Adds a keyframe: `matches` become observations, every other feature a new landmark. Its inverse depth is that of
  /// `prior`, or else that of the median depth with a standard deviation of 100 %. Then the window is refined and old
  /// landmarks are removed.
  /// @param unit_depth median depth to assume while the map has none
  /// @returns the keyframe's index; `view.X_WC` is refined.
  int AddKeyframe(FrameView& view, const std::vector<LandmarkMatch>& matches, double unit_depth,
                  const DepthPriorOf& prior);

  /// Updates the landmarks' latest descriptors from a frame that is no keyframe.
  void Refresh(const FrameView& view, const std::vector<LandmarkMatch>& matches);

  /// Sets an inverse depth known otherwise, as when a map is initialised.
  void SetDepth(int landmark, double rho) { landmarks_[size_t(landmark)].rho = rho; }

  /// Removes all landmarks; keyframe poses stay. The next keyframe is the first of a new map.
  void Clear() {
    landmarks_.clear();
    first_keyframe_ = int(keyframes_.size());
  }

  /// Index of the present map's latest keyframe; -1 while it has none.
  int LatestKeyframe() const {
    const int latest = int(keyframes_.size()) - 1;
    return latest >= first_keyframe_ ? latest : -1;
  }

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  const std::vector<Pose>& keyframes() const { return keyframes_; }  ///< X_WC, of all maps.
  InverseDepthPoint Point(const Landmark& landmark) const {
    const double ray_sigma = landmark.sigma / std::sqrt(1.0 + double(landmark.observations.size()));
    return {keyframes_[size_t(landmark.anchor)], landmark.ray, ray_sigma, landmark.rho, landmark.rho_sigma};
  }
  /// Position in W of a landmark with rho > 0.
  Eigen::Vector3d Position(const Landmark& landmark) const {
    return keyframes_[size_t(landmark.anchor)] * (landmark.ray.homogeneous() / landmark.rho);
  }
  /// Median depth of the landmarks that have one and lie in front of a camera; `otherwise` if they are fewer than 10.
  double MedianDepth(const Pose& X_WC, double otherwise) const;
  /// Median angle at the matched landmarks between the rays from `from_W` and `to_W`, rad; infinity if there are none.
  double MedianParallax(const std::vector<LandmarkMatch>& matches, const Eigen::Vector3d& from_W,
                        const Eigen::Vector3d& to_W) const;

 private:
  void Observe(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches);
  void Triangulate(Landmark& landmark) const;
  void AddLandmarks(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches, double unit_depth,
                    const DepthPriorOf& prior);
  void Adjust();
  void RemoveOutliers();
  void RemoveOld();

  KeyframeMapOptions options_;
  std::vector<Pose> keyframes_;
  int first_keyframe_ = 0;  ///< Of the present map.
  std::vector<Landmark> landmarks_;
};

}  // namespace gaitcam
