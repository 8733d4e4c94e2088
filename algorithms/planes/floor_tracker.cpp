#include "algorithms/planes/floor_tracker.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/planes/alignment_image.h"

namespace gaitcam {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Eigen::Quaterniond TurnBy(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  return angle < 1e-12 ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond(Eigen::AngleAxisd(angle, w / angle));
}

/// The same orientation but for the tilt that makes `up_C` point up, heading kept, `height` above the floor.
Pose Upright(const Pose& X_WC, const Eigen::Vector3d& up_C, double height) {
  const Eigen::Quaterniond fix = Eigen::Quaterniond::FromTwoVectors(X_WC.rotation * up_C, Eigen::Vector3d::UnitZ());
  const Eigen::Vector2d p = X_WC.translation.head<2>();
  return {fix * X_WC.rotation, {p.x(), p.y(), height}};
}

PlaneState PlaneOf(const Pose& X_WC) {
  PlaneState state;
  state.normal_d = X_WC.rotation.conjugate() * -Eigen::Vector3d::UnitZ() / X_WC.translation.z();
  return state;
}

/// Covariance of the planar pose below C, in that frame, from that of x in X_CR exp(x).
Eigen::Matrix3d PlanarCovariance(const Eigen::Matrix<double, 6, 6>& of_x, const Pose& X_WK, const Pose& X_WC) {
  // C moves in K by -(v + w x p): p is C's place in K. Then into W, and into the frame below C.
  const Eigen::Vector3d p = X_WK.Inverse() * X_WC.translation;
  Eigen::Matrix3d cross;
  cross << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  const Eigen::Matrix3d R = RotZ(-BelowCamera(X_WC).heading) * X_WK.R();
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  J.topLeftCorner<2, 3>() = -R.topRows<2>();
  J.topRightCorner<2, 3>() = (R * cross).topRows<2>();
  J.bottomRightCorner<1, 3>() = -R.row(2);
  return J * of_x * J.transpose();
}

CameraModel WithoutDistortion(CameraModel camera) {
  camera.k1 = camera.k2 = camera.k3 = camera.p1 = camera.p2 = 0;
  return camera;
}

/// Of the regions that were judged, the part that lies on the floor, by area.
double FloorRatio(const FloorKeyframe& keyframe) {
  double floor = 0, all = 0;
  for (const FloorRegion& region : keyframe.regions) {
    if (!region.judged || region.plane.kind != PutativePlane::Kind::kTexture) continue;
    all += region.plane.area_px;
    floor += region.is_floor ? region.plane.area_px : 0;
  }
  return all == 0 ? 1 : floor / all;
}

}  // namespace

FloorTracker::FloorTracker(const Calibration& calibration, const FloorTrackerOptions& options)
    : calibration_(calibration),
      options_(options),
      camera_(WithoutDistortion(calibration.camera)),
      aligner_(camera_, options.alignment) {
  CheckFields(options, "floor_tracker.");
  if (!calibration.standing) {
    throw BadInput("the calibration does not say how high the camera stands (standing: height_m, up_C)");
  }
  const CameraModel& lens = calibration.camera;
  if (!lens.IsDistorted()) return;
  map_u_.create(lens.height_px, lens.width_px, CV_32FC1);
  map_v_.create(lens.height_px, lens.width_px, CV_32FC1);
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const Eigen::Vector2d p = *lens.Project(camera_.Unproject({double(u), double(v)}));
      map_u_.at<float>(v, u) = float(p.x());
      map_v_.at<float>(v, u) = float(p.y());
    }
  }
}

cv::Mat FloorTracker::Undistort(const cv::Mat& image) const {
  if (image.cols != camera_.width_px || image.rows != camera_.height_px) {
    throw BadInput("the frame has " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
                   " pixels, but the calibration says " + std::to_string(camera_.width_px) + " x " +
                   std::to_string(camera_.height_px));
  }
  cv::Mat grey = image, straight;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  if (map_u_.empty()) return grey;
  cv::remap(grey, straight, map_u_, map_v_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return straight;
}

/// Of the camera, in its own frame, rad/s.
Eigen::Vector3d FloorTracker::AngularRate(const ImuSample& sample) const {
  return calibration_.imu.X_CI.rotation * sample.angular_rate - gyro_bias_;
}

/// While floor is followed, what the gyroscope says beside it is its bias: a Kalman filter of a constant.
void FloorTracker::LearnBias(const Pose& X_CK) {
  constexpr double kTurnSigma_rad = 0.15 * kDegree;  // of a keyframe's alignment
  if (!keyframe_->turned) return;
  const Eigen::AngleAxisd off(X_CK.rotation * *keyframe_->turned);  // R_CK R_KC'
  const double since_s = std::max(keyframe_->turned_s, 1e-3);
  const double variance = std::pow(kTurnSigma_rad / since_s, 2), before = std::pow(gyro_bias_sigma_, 2);
  const double gain = before / (before + variance);
  gyro_bias_ += gain * off.angle() / since_s * off.axis();
  gyro_bias_sigma_ = std::sqrt((1 - gain) * before);
}

/// Each reading is the mean over one period about its stamp.
FloorTracker::Rotation FloorTracker::Integrate(const Observation& observation) {
  if (!options_.use_imu || calibration_.imu.rate_hz <= 0) return {};
  imu_.insert(imu_.end(), observation.imu.begin(), observation.imu.end());
  const auto turn = [&](double from_ns, double to_ns) -> std::optional<Eigen::Vector3d> {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    const double half_ns = 0.5e9 / calibration_.imu.rate_hz;
    double covered_ns = 0;
    for (const ImuSample& sample : imu_) {
      const double begin = std::max(from_ns, double(sample.stamp_ns) - half_ns);
      const double end = std::min(to_ns, double(sample.stamp_ns) + half_ns);
      if (end <= begin) continue;
      covered_ns += end - begin;
      q = q * TurnBy(AngularRate(sample) * (end - begin) * 1e-9);
    }
    if (covered_ns < 0.7 * (to_ns - from_ns)) return std::nullopt;
    const Eigen::AngleAxisd axis(q.w() < 0 ? Eigen::Quaterniond(-q.coeffs()) : q);
    return axis.angle() * axis.axis() * ((to_ns - from_ns) / covered_ns);  // what is missing turns alike
  };
  const double now = double(observation.stamp_ns), half_exposure = 0.5e6 * observation.exposure_ms;
  Rotation rotation;
  if (last_ns_ > 0) rotation.since_last = turn(double(last_ns_), now);
  if (half_exposure > 0) rotation.during_exposure = turn(now - half_exposure, now + half_exposure);
  constexpr int64_t kKeep_ns = 300'000'000;
  const auto old = [&](const ImuSample& s) { return s.stamp_ns < observation.stamp_ns - kKeep_ns; };
  imu_.erase(imu_.begin(), std::find_if_not(imu_.begin(), imu_.end(), old));
  return rotation;
}

void FloorTracker::FollowGravity(const Observation& observation) {
  if (!options_.use_imu || observation.imu.empty() || calibration_.imu.rate_hz <= 0) return;
  if (!gravity_) gravity_.emplace(calibration_.imu, calibration_.standing->up_C);
  gravity_->Add(observation.imu, gyro_bias_);
}

/// As gravity has it, or as the camera stands where nothing feels it.
const Eigen::Vector3d& FloorTracker::UpC() const { return gravity_ ? gravity_->up_C() : calibration_.standing->up_C; }

/// What lies on the floor, if all in view does, and not too far away.
cv::Mat FloorTracker::FloorMask(const Pose& X_WC) const {
  cv::Mat mask(camera_.height_px, camera_.width_px, CV_8UC1, cv::Scalar(0));
  const Eigen::Vector3d n_d = PlaneOf(X_WC).normal_d;
  for (int v = 0; v < mask.rows; ++v) {
    uchar* row = mask.ptr<uchar>(v);
    for (int u = 0; u < mask.cols; ++u) {
      const Eigen::Vector3d ray((u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1);
      const double distance_heights = ray.norm() * n_d.norm() / std::max(1e-9, n_d.dot(ray));
      row[u] = n_d.dot(ray) > 0 && distance_heights < options_.range_heights ? 255 : 0;
    }
  }
  return mask;
}

void FloorTracker::MakeKeyframe(int64_t stamp_ns, const Pose& X_WC, const ExposureMotion& blur,
                                const cv::Mat& rejected) {
  Keyframe keyframe;
  keyframe.mask = FloorMask(X_WC);
  if (!rejected.empty()) keyframe.mask.setTo(0, rejected);
  keyframe.grey = grey_;
  keyframe.reference = aligner_.MakeReference(AlignmentImage(grey_), keyframe.mask);
  keyframe.reference.blur = blur;
  keyframe.regions = FindPutativePlanes(grey_, options_.regions.putative);
  keyframe.plane = PlaneOf(X_WC);
  keyframe.X_WK = X_WC;
  keyframe.stamp_ns = stamp_ns;
  keyframe.id = keyframes_++;
  keyframe_ = std::move(keyframe);
}

/// @param now where the last keyframe's floor is seen at last; null if it was not seen again.
FloorKeyframe FloorTracker::Retire(const PlaneState* now, const CurrentBlur& blur) const {
  constexpr int kLevels = 3;  // pixels near the camera are finer than a map's cells
  FloorKeyframe retired;
  retired.id = keyframe_->id;
  retired.stamp_ns = keyframe_->stamp_ns;
  retired.image = ImagePyramid::Of(keyframe_->grey, kLevels);
  retired.floor = keyframe_->mask.clone();
  retired.X_WK = keyframe_->X_WK;
  retired.covariance = keyframe_->covariance;
  if (now == nullptr) return retired;
  retired.X_WK = Upright(keyframe_->X_WK, -now->normal_d.normalized(), 1 / now->normal_d.norm());
  retired.regions =
      JudgeRegions(aligner_, camera_, keyframe_->reference, keyframe_->regions, image_, *now, blur, options_.regions);
  for (const FloorRegion& region : retired.regions) {
    if (!region.is_floor) retired.floor(region.plane.at).setTo(0, region.plane.enclosed);
  }
  return retired;
}

/// Where the last keyframe's rejected regions are in this image, roughly: as if they lay on the floor, and some more.
cv::Mat FloorTracker::CarryRejected(const FloorKeyframe& retired, const PlaneState& now) const {
  cv::Mat rejected(camera_.height_px, camera_.width_px, CV_8UC1, cv::Scalar(0)), carried;
  bool any = false;
  for (const FloorRegion& region : retired.regions) {
    if (region.is_floor) continue;
    rejected(region.plane.at).setTo(255, region.plane.enclosed);
    any = true;
  }
  if (!any) return {};
  const Eigen::Matrix3d H = now.X_CR.R() + now.X_CR.translation * now.normal_d.transpose();
  const Eigen::Matrix3d G = camera_.K() * H * camera_.K().inverse();  // Eq. 6.5
  cv::Matx33d warp;
  for (int i = 0; i < 9; ++i) warp(i / 3, i % 3) = G(i / 3, i % 3);
  cv::warpPerspective(rejected, carried, warp, rejected.size(), cv::INTER_NEAREST);
  constexpr int kMargin_px = 6;
  cv::dilate(carried, carried, cv::getStructuringElement(cv::MORPH_RECT, {2 * kMargin_px + 1, 2 * kMargin_px + 1}));
  return carried;
}

/// The camera is carried about as high as it stands, and gravity is down: each keyframe takes a little of it back.
Pose FloorTracker::Corrected(const Pose& X_WC) const {
  const double height = X_WC.translation.z();
  const double better = height + options_.height_gain * (calibration_.standing->height_m - height);
  Eigen::Vector3d up_C = X_WC.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  if (gravity_) up_C = (up_C + options_.tilt_gain * (gravity_->up_C() - up_C)).normalized();
  return Upright(X_WC, up_C, better);
}

void FloorTracker::Start(const Observation& observation) {
  Pose level;  // looking along x: camera z to world x, camera x to world -y
  level.rotation = Eigen::Quaterniond((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  const Eigen::Vector3d up_C = UpC();
  X_WC_ = Upright(level, up_C, calibration_.standing->height_m);
  X_WC_ = BelowCamera(X_WC_).Inverse().Lifted() * X_WC_;
  MakeKeyframe(observation.stamp_ns, X_WC_, ExposureMotion::Zero(), {});
}

/// After a loss: begins anew where the camera is guessed to be. Whether this image shows floor, the next ones tell.
void FloorTracker::Restart(const Observation& observation, const Pose& X_WC, const cv::Mat& rejected) {
  constexpr double kSpeed_m_s = 0.3, kTurn_rad_s = 0.5, kGyroTurn_rad_s = 0.02;
  const double gone_s = double(observation.stamp_ns - tracked_ns_) * 1e-9;
  const double turn_rad_s = imu_.empty() ? kTurn_rad_s : kGyroTurn_rad_s;
  const Pose upright = Upright(X_WC, UpC(), calibration_.standing->height_m);
  MakeKeyframe(observation.stamp_ns, upright, ExposureMotion::Zero(), rejected);
  const Eigen::Vector3d sigma = gone_s * Eigen::Vector3d(kSpeed_m_s, kSpeed_m_s, turn_rad_s);
  keyframe_->covariance = sigma.cwiseAbs2().asDiagonal();
  keyframe_->confirmed = false;
}

/// What an alignment that is believed says of the frame.
FloorTrack FloorTracker::Accept(const PlaneAlignment& found, const CurrentBlur& blur) const {
  FloorTrack track;
  const Eigen::Vector3d n_d = found.state.normal_d;
  const Pose X_WK = Upright(keyframe_->X_WK, -n_d.normalized(), 1 / n_d.norm());
  track.tracked = true;
  track.X_WC = X_WK * found.state.X_CR.Inverse();
  track.covariance = PlanarCovariance(found.motion_covariance, X_WK, track.X_WC);
  const ExposureMotion motion = blur.Motion(found.state.X_CR);
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() / std::max(0.1 * n_d.norm(), (found.state.X_CR.R() * n_d).z());
  track.blur_px = camera_.fx / ahead.z() * (motion.head<3>() + motion.tail<3>().cross(ahead)).head<2>().norm();
  return track;
}

/// Whoever takes something else for the floor soon leans, rises or sinks.
bool FloorTracker::IsPlausible(const FloorTrack& track) const {
  const StandingCamera& standing = *calibration_.standing;
  const Eigen::Vector3d up_C = track.X_WC.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const double lean = std::acos(std::clamp(up_C.dot(UpC()), -1.0, 1.0));
  return lean < options_.max_tilt_deg * kDegree &&
         std::abs(track.X_WC.translation.z() / standing.height_m - 1) < options_.max_height_ratio;
}

/// Whoever takes something upright for the floor turns where the gyroscope feels nothing.
bool FloorTracker::TurnsAsFelt(const Pose& X_CR) const {
  if (!keyframe_->turned) return true;
  const double most = options_.max_turn_deg * kDegree + 3 * gyro_bias_sigma_ * keyframe_->turned_s;
  return RotationAngle(X_CR.rotation.conjugate(), *keyframe_->turned) < most;
}

bool FloorTracker::IsDue(const FloorTrack& track, double inside_ratio) const {
  const double moved_m = (track.X_WC.translation - keyframe_->X_WK.translation).norm();
  return moved_m > options_.keyframe_move_heights * calibration_.standing->height_m ||
         RotationAngle(track.X_WC.rotation, keyframe_->X_WK.rotation) > options_.keyframe_turn_deg * kDegree ||
         inside_ratio < options_.keyframe_inside_ratio;
}

FloorTrack FloorTracker::Follow(const Observation& observation, const Rotation& turned) {
  const double dt = double(observation.stamp_ns - last_ns_) * 1e-9;
  // What the motion since the last frame was goes on, turned as the gyroscope says.
  Pose predicted = X_WC_ * X_last_;
  if (turned.since_last) predicted.rotation = X_WC_.rotation * TurnBy(*turned.since_last);
  PlaneState guess = keyframe_->plane;
  guess.X_CR = predicted.Inverse() * keyframe_->X_WK;
  PlanePrior prior;
  prior.distance_sigma = 0.1 * options_.height_sigma_ratio;
  prior.tilt_sigma_rad = options_.tilt_sigma_deg * kDegree;
  prior.rotation_sigma_rad = (turned.since_last ? 2 : 10) * kDegree;
  prior.translation_sigma_m = 0.3 * calibration_.standing->height_m;
  CurrentBlur blur(observation.exposure_ms * 1e-3 / dt);
  blur.X_RP = keyframe_->X_WK.Inverse() * X_WC_;
  blur.turn = turned.during_exposure;

  const PlaneAlignment found = aligner_.Align(keyframe_->reference, image_, guess, prior, blur);
  FloorTrack track;
  track.points = int(keyframe_->reference.points.front().size());
  track.inliers = found.inliers;
  const FloorTrack candidate = Accept(found, blur);
  if (found.converged && found.correlation >= options_.min_correlation && track.points >= options_.min_points &&
      IsPlausible(candidate) && TurnsAsFelt(found.state.X_CR)) {
    track = candidate;
    track.points = int(keyframe_->reference.points.front().size());
    track.inliers = found.inliers;
    track.keyframe = keyframe_->id;
    track.tentative = !keyframe_->confirmed;
    ++keyframe_->tracked_frames;
    if (IsDue(track, found.inside_ratio)) Succeed(observation, found.state, blur, track);
  } else {
    track.X_WC = predicted;
  }
  return track;
}

/// The frame becomes the next keyframe, if the last one turns out to have shown floor.
void FloorTracker::Succeed(const Observation& observation, const PlaneState& now, const CurrentBlur& blur,
                           FloorTrack& track) {
  FloorKeyframe retired = Retire(&now, blur);
  const cv::Mat rejected = CarryRejected(retired, now);
  if (FloorRatio(retired) < options_.min_floor_ratio) {  // it was something else that was followed
    rejected_ = rejected;
    track.tracked = track.tentative = false;
    lost_frames_ = std::max(lost_frames_, options_.max_lost_frames);
    return;
  }
  LearnBias(now.X_CR);
  track.retired = std::move(retired);
  track.X_WC = Corrected(track.X_WC);
  MakeKeyframe(observation.stamp_ns, track.X_WC, blur.Motion(now.X_CR), rejected);
  keyframe_->covariance = track.covariance;
}

FloorTrack FloorTracker::Track(const Observation& observation) {
  grey_ = Undistort(observation.image.pixels);
  image_ = aligner_.MakePyramid(AlignmentImage(grey_));
  const Rotation turned = Integrate(observation);
  FollowGravity(observation);
  FloorTrack track;
  if (!keyframe_) {
    Start(observation);
    track.X_WC = X_WC_;
    track.keyframe = keyframe_->id;
    track.points = track.inliers = int(keyframe_->reference.points.front().size());
    track.tracked = track.points >= options_.min_points;
    if (!track.tracked) keyframe_.reset();
  } else {
    if (turned.since_last) {
      X_dead_.rotation = X_dead_.rotation * TurnBy(*turned.since_last);
      if (keyframe_->turned) *keyframe_->turned = *keyframe_->turned * TurnBy(*turned.since_last);
      keyframe_->turned_s += double(observation.stamp_ns - last_ns_) * 1e-9;
    } else {
      keyframe_->turned.reset();
    }
    track = Follow(observation, turned);
    if (!track.tracked && ++lost_frames_ > options_.max_lost_frames) {
      if (keyframe_->confirmed && keyframe_->tracked_frames > 0 && rejected_.empty())
        track.retired = Retire(nullptr, {});
      Restart(observation, X_dead_, rejected_);
      track.X_WC = keyframe_->X_WK;
      rejected_.release();
      X_last_ = Pose();
    }
  }
  if (track.tracked) {
    track.restarted = lost_frames_ > options_.max_lost_frames;
    track.tracked = !track.tentative || track.retired.has_value();
    lost_frames_ = 0;
    X_last_ = tracked_ns_ > 0 ? X_WC_.Inverse() * track.X_WC : Pose();
    if (track.tracked) {
      tracked_ns_ = observation.stamp_ns;
      X_dead_ = track.X_WC;
    }
  }
  X_WC_ = track.X_WC;
  last_ns_ = observation.stamp_ns;
  return track;
}

std::optional<FloorKeyframe> FloorTracker::Finish() {
  if (!keyframe_ || !keyframe_->confirmed || (keyframe_->tracked_frames == 0 && keyframe_->stamp_ns != last_ns_)) {
    return std::nullopt;
  }
  return Retire(nullptr, {});
}

}  // namespace gaitcam
