#include "algorithms/features/psf_inertial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/se3.h"
#include "algorithms/features/blur_path.h"
#include "algorithms/features/psf_oracle.h"

namespace gaitcam {
namespace {

/// Rate as a step function of time: constant between the middles of neighbouring stamps.
class RateSteps {
 public:
  RateSteps(const std::vector<ImuSample>& imu, const Pose& X_CI) : imu_(imu), R_CI_(X_CI.rotation) {}

  /// Turns `X` (maps camera at an earlier instant into the camera now) on from `from_ns` to `to_ns`.
  void Advance(int64_t from_ns, int64_t to_ns, Eigen::Quaterniond& R_now_earlier) const {
    for (size_t i = 0; i < imu_.size(); ++i) {
      const int64_t begin = std::max(from_ns, i == 0 ? from_ns : Middle(i - 1));
      const int64_t end = std::min(to_ns, i + 1 == imu_.size() ? to_ns : Middle(i));
      if (end <= begin) continue;
      const Eigen::Vector3d rate_C = R_CI_ * imu_[i].angular_rate;
      // Still points turn the other way in the camera's eyes.
      R_now_earlier = (ExpSo3(-rate_C * (double(end - begin) * 1e-9)) * R_now_earlier).normalized();
    }
  }

 private:
  int64_t Middle(size_t i) const { return imu_[i].stamp_ns + (imu_[i + 1].stamp_ns - imu_[i].stamp_ns) / 2; }

  const std::vector<ImuSample>& imu_;
  Eigen::Quaterniond R_CI_;
};

}  // namespace

std::vector<ExposureRotation> IntegrateRotation(const std::vector<ImuSample>& imu, const ImuCalibration& calibration,
                                                int64_t open_ns, int64_t close_ns, int steps) {
  GAITCAM_ASSERT(steps >= 2);
  if (imu.empty()) throw BadInput("inertial blur: there is no IMU reading");
  if (close_ns < open_ns) {
    throw BadInput("inertial blur: the shutter closes at " + std::to_string(close_ns) + " ns, before it opens at " +
                   std::to_string(open_ns) + " ns");
  }
  const RateSteps rates(imu, calibration.X_CI);
  std::vector<ExposureRotation> rotations(static_cast<size_t>(steps));
  Eigen::Quaterniond R_now_open = Eigen::Quaterniond::Identity(), R_middle_open = R_now_open;
  const int64_t middle_ns = open_ns + (close_ns - open_ns) / 2;
  rates.Advance(open_ns, middle_ns, R_middle_open);
  for (int i = 0; i < steps; ++i) {
    rotations[size_t(i)].stamp_ns = open_ns + (close_ns - open_ns) * i / (steps - 1);
    if (i > 0) rates.Advance(rotations[size_t(i) - 1].stamp_ns, rotations[size_t(i)].stamp_ns, R_now_open);
    rotations[size_t(i)].rotation = R_now_open * R_middle_open.conjugate();
  }
  return rotations;
}

InertialPsf::InertialPsf(const std::vector<ImuSample>& imu, const ImuCalibration& calibration,
                         const CameraModel& camera, int64_t open_ns, int64_t close_ns, const Eigen::Vector3d& gyro_bias,
                         double verdict_px)
    : camera_(camera), verdict_px_(verdict_px) {
  camera_.Check();
  std::vector<ImuSample> unbiased = imu;
  for (ImuSample& sample : unbiased) sample.angular_rate -= gyro_bias;
  rotations_ = IntegrateRotation(unbiased, calibration, open_ns, close_ns);
}

std::vector<Eigen::Vector2d> InertialPsf::Path(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector3d ray = camera_.Unproject(pixel);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector2d> path;
  for (const ExposureRotation& r : rotations_) {
    path.push_back(camera_.Project(r.rotation * ray).value_or(Eigen::Vector2d(nan, nan)));
  }
  return path;
}

Eigen::Vector2d InertialPsf::BlurVector(const Eigen::Vector2d& pixel) const {
  const std::vector<Eigen::Vector2d> path = Path(pixel);
  return path.back() - path.front();
}

std::vector<BlurRegion> InertialPsf::Regions() const {
  const auto path_at = [this](const Eigen::Vector2d& pixel) {
    BlurPath path{Path(pixel)};
    for (Eigen::Vector2d& p : path.points) p -= pixel;
    return std::all_of(path.points.begin(), path.points.end(), [](const auto& p) { return p.allFinite(); })
               ? path
               : BlurPath{};
  };
  std::vector<BlurRegion> regions = DivideByPath(path_at, {camera_.width_px, camera_.height_px});
  for (BlurRegion& region : regions) region.estimate.blurred = region.path.Length() >= verdict_px_;
  return regions;
}

BlurEstimate InertialPsf::Estimate(const cv::Mat& grey, const cv::Rect& region) const {
  constexpr int kGrid = 5;
  GAITCAM_ASSERT(grey.cols == camera_.width_px && grey.rows == camera_.height_px);
  const cv::Rect seen = region & cv::Rect({0, 0}, grey.size());
  if (seen.area() == 0) return {};
  cv::Mat vectors(kGrid, kGrid, CV_32FC2);
  double net = 0, length = 0;
  for (int j = 0; j < kGrid; ++j) {
    for (int i = 0; i < kGrid; ++i) {
      const std::vector<Eigen::Vector2d> path =
          Path({seen.x + (i + 0.5) * seen.width / kGrid - 0.5, seen.y + (j + 0.5) * seen.height / kGrid - 0.5});
      const Eigen::Vector2d vector = path.back() - path.front();
      vectors.at<cv::Vec2f>(j, i) = {float(vector.x()), float(vector.y())};
      if (!vector.allFinite()) continue;
      net += vector.norm();
      for (size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
    }
  }
  BlurEstimate estimate;
  estimate.blur = MeanBlur(vectors);
  estimate.confidence = length > 0 ? std::min(1.0, net / length) : 1;
  estimate.blurred = estimate.blur.extent_px >= verdict_px_;
  return estimate;
}

}  // namespace gaitcam
