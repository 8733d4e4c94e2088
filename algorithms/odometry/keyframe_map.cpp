#include "algorithms/odometry/keyframe_map.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "algorithms/core/median.h"
#include "algorithms/geometry/bundle_adjustment.h"

namespace gaitcam {

double KeyframeMap::MedianDepth(const Pose& X_WC, double otherwise) const {
  std::vector<double> depths;
  for (const Landmark& landmark : landmarks_) {
    if (!landmark.HasDepth()) continue;
    const double depth = (X_WC.rotation.conjugate() * (Position(landmark) - X_WC.translation)).z();
    if (depth > 0) depths.push_back(depth);
  }
  constexpr size_t kMinLandmarks = 10;
  return depths.size() < kMinLandmarks ? otherwise : UpperMedian(depths);
}

double KeyframeMap::MedianParallax(const std::vector<LandmarkMatch>& matches, const Eigen::Vector3d& from_W,
                                   const Eigen::Vector3d& to_W) const {
  if (matches.empty()) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d baseline = to_W - from_W;
  std::vector<double> angles;
  for (const LandmarkMatch& match : matches) {
    const Landmark& landmark = landmarks_[size_t(match.landmark)];
    const Eigen::Vector3d ray = keyframes_[size_t(landmark.anchor)].rotation * landmark.ray.homogeneous();
    angles.push_back(landmark.rho * ray.normalized().cross(baseline).norm() / landmark.ray.homogeneous().norm());
  }
  return UpperMedian(angles);
}

int KeyframeMap::AddKeyframe(FrameView& view, const std::vector<LandmarkMatch>& matches, double unit_depth,
                             const DepthPriorOf& prior) {
  const int keyframe = int(keyframes_.size());
  keyframes_.push_back(view.X_WC);
  Observe(keyframe, view, matches);
  if (keyframe > first_keyframe_) {
    Adjust();
    RemoveOutliers();
    view.X_WC = keyframes_.back();
  }
  AddLandmarks(keyframe, view, matches, unit_depth, prior);
  RemoveOld();
  return keyframe;
}

void KeyframeMap::Refresh(const FrameView& view, const std::vector<LandmarkMatch>& matches) {
  for (const LandmarkMatch& match : matches) {
    view.features.descriptors.row(match.feature).copyTo(landmarks_[size_t(match.landmark)].latest);
  }
}

void KeyframeMap::Observe(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches) {
  for (const LandmarkMatch& match : matches) {
    Landmark& landmark = landmarks_[size_t(match.landmark)];
    const size_t i = size_t(match.feature);
    landmark.observations.push_back({keyframe, view.xy[i], view.sigma[i]});
    landmark.last_keyframe = keyframe;
    if (landmark.observations.size() == 1) Triangulate(landmark);
    view.features.descriptors.row(match.feature).copyTo(landmark.descriptor);
    landmark.latest.release();
  }
}

/// Inverse depth by Gauss-Newton from the anchor and the first observation: the initial value for bundle adjustment.
void KeyframeMap::Triangulate(Landmark& landmark) const {
  const LandmarkObservation& o = landmark.observations.front();
  constexpr int kIterations = 6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const auto projection = LinearizeInverseDepth(keyframes_[size_t(landmark.anchor)], landmark.ray, landmark.rho,
                                                  keyframes_[size_t(o.keyframe)]);
    if (!projection) return;
    const double information = projection->d_rho.squaredNorm() / (o.sigma * o.sigma), vague = 10 * landmark.prior_rho,
                 prior = 1 / (vague * vague);
    const double slope = projection->d_rho.dot(projection->xy - o.xy) / (o.sigma * o.sigma) +
                         prior * (landmark.rho - landmark.prior_rho);
    landmark.rho = std::max(0.0, landmark.rho - slope / (information + prior));
    landmark.rho_sigma = 1 / std::sqrt(information + prior);
  }
}

void KeyframeMap::AddLandmarks(int keyframe, const FrameView& view, const std::vector<LandmarkMatch>& matches,
                               double unit_depth, const DepthPriorOf& prior) {
  std::vector<bool> taken(view.xy.size(), false);
  for (const LandmarkMatch& match : matches) taken[size_t(match.feature)] = true;
  const double rho = 1 / MedianDepth(view.X_WC, unit_depth);
  constexpr double kPriorSpread = 0.29;  // relative standard deviation for the search; HasDepth() asks for 0.3
  for (size_t i = 0; i < view.xy.size(); ++i) {
    if (taken[i]) continue;
    Landmark landmark;
    landmark.anchor = landmark.last_keyframe = keyframe;
    landmark.xy = landmark.ray = view.xy[i];
    landmark.sigma = view.sigma[i];
    landmark.rho = landmark.prior_rho = rho;
    landmark.rho_sigma = rho;
    landmark.prior_sigma = 10 * rho;
    if (const auto known = prior(view.X_WC, view.xy[i])) {
      landmark.has_depth_prior = true;
      landmark.rho = landmark.prior_rho = known->rho;
      landmark.prior_sigma = known->sigma;
      landmark.rho_sigma = kPriorSpread * known->rho;
    }
    landmark.descriptor = view.features.descriptors.row(int(i)).clone();
    landmarks_.push_back(std::move(landmark));
  }
}

/// Bundle adjustment over the window; older keyframes that saw the same landmarks are held fixed, and so is the first
/// of the map.
void KeyframeMap::Adjust() {
  const int newest = int(keyframes_.size()) - 1,
            oldest_free = std::max(first_keyframe_ + 1, newest + 1 - options_.window);
  BundleProblem problem;
  std::vector<int> camera_of(keyframes_.size(), -1);
  const auto camera = [&](int keyframe) {
    int& index = camera_of[size_t(keyframe)];
    if (index < 0) {
      index = int(problem.cameras.size());
      problem.cameras.push_back({keyframes_[size_t(keyframe)], keyframe < oldest_free});
    }
    return index;
  };
  std::vector<int> landmark_of;
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const Landmark& landmark = landmarks_[i];
    if (landmark.observations.empty() || landmark.last_keyframe < oldest_free) continue;
    BundlePoint point;
    point.anchor = camera(landmark.anchor);
    point.xy = landmark.xy;
    point.sigma = landmark.sigma;
    point.ray = landmark.ray;
    point.rho = landmark.rho;
    point.prior_rho = landmark.prior_rho;
    point.prior_sigma = landmark.prior_sigma;
    for (const LandmarkObservation& o : landmark.observations) {
      problem.observations.push_back({camera(o.keyframe), int(problem.points.size()), o.xy, o.sigma});
    }
    problem.points.push_back(point);
    landmark_of.push_back(int(i));
  }
  if (problem.points.empty()) return;
  BundleOptions options;
  options.max_iterations = options_.adjust_iterations;
  AdjustBundle(problem, options);
  for (size_t k = 0; k < keyframes_.size(); ++k) {
    if (camera_of[k] >= 0) keyframes_[k] = problem.cameras[size_t(camera_of[k])].X_WC;
  }
  for (size_t k = 0; k < landmark_of.size(); ++k) {
    Landmark& landmark = landmarks_[size_t(landmark_of[k])];
    landmark.ray = problem.points[k].ray;
    landmark.rho = std::max(0.0, problem.points[k].rho);  // noise may put far points beyond infinity
    landmark.rho_sigma = problem.points[k].rho_sigma;
  }
}

/// Removes observations that the refined map contradicts.
void KeyframeMap::RemoveOutliers() {
  const double limit2 = options_.outlier_sigmas * options_.outlier_sigmas;
  for (Landmark& landmark : landmarks_) {
    const InverseDepthPoint point = {keyframes_[size_t(landmark.anchor)], landmark.ray, 0, landmark.rho, 0};
    std::erase_if(landmark.observations, [&](const LandmarkObservation& o) {
      return Mahalanobis2({point, o.xy, o.sigma}, keyframes_[size_t(o.keyframe)]) > limit2;
    });
  }
}

void KeyframeMap::RemoveOld() {
  constexpr int kProbation = 3;  // keyframes within which a new landmark must be observed again
  const int newest = int(keyframes_.size()) - 1;
  std::erase_if(landmarks_, [&](const Landmark& landmark) {
    const int age = newest - landmark.last_keyframe;
    return age > (landmark.observations.empty() ? kProbation : options_.memory);
  });
}

}  // namespace gaitcam
