#include "algorithms/geometry/absolute_pose.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "algorithms/core/se3.h"
#include "algorithms/core/small_solvers.h"

namespace gaitcam {
namespace {

constexpr size_t kMinInliers = 4;  // three determine up to four poses, a fourth decides between them

/// One Gauss-Newton step: X_WC Exp(rho, phi) moves p_C by -rho - phi x p_C. @returns the step's size.
double RefineOnce(const std::vector<PointSighting>& sightings, const std::vector<int>& use, double huber, Pose& X_WC) {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  const Pose X_CW = X_WC.Inverse();
  for (const int i : use) {
    const Eigen::Vector3d p = X_CW * sightings[size_t(i)].p_W;
    if (!(p.z() > 0)) continue;
    const Eigen::Vector2d e = p.hnormalized() - sightings[size_t(i)].xy;
    const double weight = e.norm() > huber ? huber / e.norm() : 1.0;
    const double x = p.x() / p.z(), y = p.y() / p.z(), inverse = 1 / p.z();
    Eigen::Matrix<double, 2, 6> J;                          // d e / d (rho, phi)
    J << -inverse, 0, x * inverse, x * y, -(1 + x * x), y,  //
        0, -inverse, y * inverse, 1 + y * y, -x * y, -x;
    H += weight * J.transpose() * J;
    g += weight * J.transpose() * e;
  }
  const Vector6d step = -SolveSymmetric<6>(H, g);
  constexpr double kMaxTurn = 0.5;  // rad; the linearisation holds no further
  if (!step.allFinite() || step.tail<3>().norm() > kMaxTurn) return 0;
  X_WC = Plus(X_WC, step);
  return step.norm();
}

}  // namespace

std::vector<Pose> SolveThreePoint(const std::vector<PointSighting>& three) {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> images;
  for (const PointSighting& s : three) {
    points.emplace_back(s.p_W.x(), s.p_W.y(), s.p_W.z());
    images.emplace_back(s.xy.x(), s.xy.y());
  }
  std::vector<cv::Mat> rotations, translations;
  cv::solveP3P(points, images, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations, translations, cv::SOLVEPNP_AP3P);
  std::vector<Pose> poses;
  for (size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Vector3d w(rotations[i].ptr<double>()), t(translations[i].ptr<double>());
    if (!w.allFinite() || !t.allFinite()) continue;
    poses.push_back(Pose(ExpSo3(w), t).Inverse());
  }
  return poses;
}

double ReprojectionError2(const Pose& X_WC, const PointSighting& sighting) {
  const Eigen::Vector3d p = X_WC.rotation.conjugate() * (sighting.p_W - X_WC.translation);
  if (!(p.z() > 0)) return std::numeric_limits<double>::infinity();
  return (p.hnormalized() - sighting.xy).squaredNorm();
}

Pose RefineAbsolutePose(const std::vector<PointSighting>& sightings, const std::vector<int>& use, const Pose& X_WC,
                        double huber) {
  Pose refined = X_WC;
  constexpr int kMaxSteps = 10;
  constexpr double kConverged = 1e-10;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (RefineOnce(sightings, use, huber, refined) < kConverged) break;
  }
  return refined;
}

RansacResult<Pose> EstimateAbsolutePose(const std::vector<PointSighting>& sightings, const RansacOptions& options,
                                        RandomStream& random, const std::optional<Pose>& guess) {
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<PointSighting> three;
    for (const int i : sample) three.push_back(sightings[size_t(i)]);
    return SolveThreePoint(three);
  };
  const auto residual2 = [&](const Pose& X_WC, int i) { return ReprojectionError2(X_WC, sightings[size_t(i)]); };
  std::vector<Pose> first;
  if (guess) first.push_back(*guess);
  RansacResult<Pose> found = Ransac<Pose>(int(sightings.size()), 3, options, random, solve, residual2, first);
  constexpr int kRounds = 2;  // refining gains inliers, which refine further
  for (int round = 0; round < kRounds && found.inliers.size() >= kMinInliers; ++round) {
    found.model = RefineAbsolutePose(sightings, found.inliers, found.model, options.threshold / 2);
    found.inliers.clear();
    found.score = 0;
    for (int i = 0; i < int(sightings.size()); ++i) {
      const double error2 = residual2(found.model, i), limit2 = options.threshold * options.threshold;
      if (error2 < limit2) found.inliers.push_back(i);
      found.score += std::min(error2, limit2);
    }
  }
  if (found.inliers.size() < kMinInliers) found.inliers.clear();
  return found;
}

}  // namespace gaitcam
