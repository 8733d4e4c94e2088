/// The map of a keyframe odometry: keyframes, and the points that they saw as inverse depths. It knows nothing of
/// images: descriptors are rows to compare, features are normalised coordinates.

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

/// What is thought of an inverse depth beforehand.
struct DepthGuess {
  double rho = 0;
  double sigma = 0;
};

struct LandmarkObservation {
  int keyframe = 0;
  Eigen::Vector2d xy;
  double sigma = 0;
};

/// One thing in the world, on the ray of the keyframe that first saw it.
struct Landmark {
  int anchor = 0;       ///< Keyframe.
  Eigen::Vector2d xy;   ///< Where the anchor saw it ...
  double sigma = 0;     ///< ... and how exactly.
  Eigen::Vector2d ray;  ///< Where all who saw it would have the anchor see it.
  double rho = 0, rho_sigma = 0;
  double prior_rho = 0, prior_sigma = 0;
  std::vector<LandmarkObservation> observations;  ///< By later keyframes, in order.
  cv::Mat descriptor;                             ///< One row: as it looked in the last keyframe that saw it ...
  cv::Mat latest;                                 ///< ... and in the last frame, which may be blurred.
  int last_keyframe = 0;                          ///< The last that saw it.

  bool guessed = false;  ///< Its depth was guessed well before it was seen twice.

  bool Known() const { return (guessed || !observations.empty()) && rho > 0 && rho_sigma < 0.3 * rho; }
};

struct LandmarkMapOptions {
  int window = 10;  ///< Keyframes refined together; 0: none, every point by itself from where it was seen.
  int memory = 20;
  int adjust_iterations = 8;
  double outlier_sigmas = 3.5;
};

/// Which landmark is which feature of a view.
struct LandmarkMatch {
  int landmark = -1;
  int feature = -1;
};

class LandmarkMap {
 public:
  explicit LandmarkMap(const LandmarkMapOptions& options) : options_(options) {}

  /// A guess of a feature's inverse depth, if there is one.
  using Guess = std::function<std::optional<DepthGuess>(const Pose& X_WC, const Eigen::Vector2d& xy)>;

  /// Adds a keyframe: `matches` become observations, every other feature a new landmark whose inverse depth is what
  /// `guess` says, or that of the known ones, give or take all of it. Then refines the window and forgets what is old.
  /// @returns the keyframe's number; `view.X_WC` is refined.
  int AddKeyframe(FrameView& view, const std::vector<LandmarkMatch>& matches, double unit_depth, const Guess& guess);

  /// Remembers how landmarks look in a frame that will be no keyframe.
  void Refresh(const FrameView& view, const std::vector<LandmarkMatch>& matches);

  /// Sets an inverse depth found otherwise (the start of a map).
  void SetDepth(int landmark, double rho) { landmarks_[size_t(landmark)].rho = rho; }

  /// Forgets all landmarks; keyframes' poses stay. The next keyframe begins a map of its own.
  void Clear() {
    landmarks_.clear();
    first_keyframe_ = int(keyframes_.size());
  }

  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  const std::vector<Pose>& keyframes() const { return keyframes_; }
  InverseDepthPoint Point(const Landmark& landmark) const {
    const double ray_sigma = landmark.sigma / std::sqrt(1.0 + double(landmark.observations.size()));
    return {keyframes_[size_t(landmark.anchor)], landmark.ray, ray_sigma, landmark.rho, landmark.rho_sigma};
  }
  /// Where a known landmark is, in the world.
  Eigen::Vector3d Place(const Landmark& landmark) const {
    return keyframes_[size_t(landmark.anchor)] * (landmark.ray.homogeneous() / landmark.rho);
  }
  /// Median depth of the known landmarks in front of a camera; `otherwise` when there are none.
  double MedianDepth(const Pose& X_WC, double otherwise) const;
  /// Median angle at the matched landmarks between the rays from `from_W` and `to_W`; infinity when there are none.
  double MedianParallax(const std::vector<LandmarkMatch>& matches, const Eigen::Vector3d& from_W,
                        const Eigen::Vector3d& to_W) const;

 private:
  void Observe(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches);
  void Triangulate(Landmark& landmark) const;
  void RefinePoint(Landmark& landmark) const;
  void AddLandmarks(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches, double unit_depth,
                    const Guess& guess);
  void Adjust();
  void DropOutliers();
  void Forget();

  LandmarkMapOptions options_;
  std::vector<Pose> keyframes_;
  int first_keyframe_ = 0;  ///< Of the present map.
  std::vector<Landmark> landmarks_;
};

}  // namespace gaitcam
