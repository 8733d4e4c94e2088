#include "scenarios/code/runs/calibration_error.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/se3.h"
#include "algorithms/core/units.h"
#include "models/code/yaml/yaml_writer.h"

namespace gaitcam {
namespace {

int64_t Nanoseconds(double ms) { return std::llround(ms * kNsPerMs); }

/// Adds to k1 what moves the image's corner outwards by `px`: r' = r (1 + k1 r^2), in focal lengths.
void Distort(CameraModel& camera, double px) {
  const Eigen::Vector2d corner(0.5 * camera.width_px / camera.fx, 0.5 * camera.height_px / camera.fy);
  camera.k1 += px / (camera.fx * std::pow(corner.norm(), 3));
}

/// Each field as one line of text.
struct FactWriter {
  std::vector<std::pair<std::string, std::string>> facts;
  template <class T, class Limits>
  void operator()(std::string_view key, T& member, const Limits&, std::string_view) {
    YAML::Emitter out;
    WriteYaml(out, static_cast<const T&>(member));
    facts.emplace_back(key, out.c_str());
  }
};

}  // namespace

CalibrationError DrawCalibrationError(const CalibrationErrorOptions& o, const Robot& robot, uint64_t seed) {
  RandomStream random(seed, "calibration_error");
  const auto draw = [&](double sigma) { return random.Normal(0, sigma); };
  const auto draw2 = [&](double sigma) {
    const double x = draw(sigma);
    return Eigen::Vector2d(x, draw(sigma));
  };
  const auto draw3 = [&](double sigma) {
    const Eigen::Vector2d xy = draw2(sigma);
    return Eigen::Vector3d(xy.x(), xy.y(), draw(sigma));
  };
  CalibrationError error;
  error.lens = {0.01 * o.focal_pct, o.centre_px, 0.01 * o.right_focal_pct};
  error.height_sigma = 0.01 * o.height_pct;
  error.pitch_sigma = kRadPerDeg * o.pitch_deg;
  error.focal_pct = draw(o.focal_pct);
  error.centre_px = draw2(o.centre_px);
  error.distortion_px = draw(o.distortion_px);
  error.imu_deg = draw3(o.imu_deg);
  error.gyro_scale_pct = draw3(o.imu_scale_pct);
  error.accel_scale_pct = draw3(o.imu_scale_pct);
  error.time_offset_ms = draw(o.time_offset_ms);
  error.height_pct = draw(o.height_pct);
  error.pitch_deg = draw(o.pitch_deg);
  error.switch_delay_ms = draw2(o.switch_delay_ms).cwiseAbs();
  error.switch_bounce_ms = draw2(o.switch_bounce_ms).cwiseAbs();
  RandomStream of_rig(seed, "calibration_error.stereo");  // its own: it shifts nothing
  for (double& angle : error.stereo_deg) angle = of_rig.Normal(0, o.stereo_deg);
  error.right_focal_pct = of_rig.Normal(0, o.right_focal_pct);
  for (double& offset : error.right_centre_px) offset = of_rig.Normal(0, o.right_centre_px);
  if (o.encoder_deg == 0) return error;  // drawn last: it shifts nothing
  for (const RobotJoint& joint : robot.joints) {
    error.encoder_deg.push_back(joint.kind == RobotJoint::Kind::kRevolute ? draw(o.encoder_deg) : 0);
  }
  return error;
}

Calibration Miscalibrated(Calibration calibration, const CalibrationError& error) {
  const auto tell = [&](CameraModel& camera) {
    camera.fx *= 1 + 0.01 * error.focal_pct;
    camera.fy *= 1 + 0.01 * error.focal_pct;
    camera.cx += error.centre_px.x();
    camera.cy += error.centre_px.y();
    if (error.distortion_px != 0) Distort(camera, error.distortion_px);
  };
  calibration.lens = error.lens;
  tell(calibration.camera);
  if (calibration.right) {
    tell(*calibration.right);  // the lenses of a rig are calibrated together: alike, and a little apart
    calibration.right->fx *= 1 + 0.01 * error.right_focal_pct;
    calibration.right->fy *= 1 + 0.01 * error.right_focal_pct;
    calibration.right->cx += error.right_centre_px.x();
    calibration.right->cy += error.right_centre_px.y();
    if (!error.stereo_deg.isZero(0)) {
      Eigen::Quaterniond& R_LR = calibration.X_LR.rotation;
      R_LR = (R_LR * ExpSo3(kRadPerDeg * error.stereo_deg)).normalized();
    }
  }
  if (!error.imu_deg.isZero(0)) {
    Eigen::Quaterniond& R_CI = calibration.imu.X_CI.rotation;
    R_CI = (R_CI * ExpSo3(kRadPerDeg * error.imu_deg)).normalized();
  }
  if (calibration.standing) {
    calibration.standing->height_sigma = error.height_sigma;
    calibration.standing->pitch_sigma = error.pitch_sigma;
    calibration.standing->height_m *= 1 + 0.01 * error.height_pct;
    // A camera that looks further down sees "up" turned towards its own backward axis, -z.
    if (error.pitch_deg != 0) {
      calibration.standing->up_C = RotX(kRadPerDeg * error.pitch_deg) * calibration.standing->up_C;
    }
  }
  // How the camera stands over the body is known from the same measurement.
  if (calibration.odometry.rate_hz <= 0) return calibration;
  Pose& X_BC = calibration.odometry.X_BC;
  X_BC.translation.z() *= 1 + 0.01 * error.height_pct;
  if (error.pitch_deg != 0) X_BC.rotation = X_BC.rotation * Eigen::Quaterniond(RotX(-kRadPerDeg * error.pitch_deg));
  return calibration;
}

MiscalibratedSensors::Switch::Switch(double delay_ms, double bounce_ms, RandomStream random)
    : delay_ns_(Nanoseconds(delay_ms)), bounce_ns_(Nanoseconds(bounce_ms)), random_(random) {}

bool MiscalibratedSensors::Switch::Read(int64_t stamp_ns, bool closed) {
  if (!began_) {
    true_state_ = shown_ = closed;
    bounces_until_ns_ = stamp_ns;
    began_ = true;
  }
  if (closed != true_state_) changes_.emplace_back(stamp_ns, closed);
  true_state_ = closed;
  for (; !changes_.empty() && changes_.front().first + delay_ns_ <= stamp_ns; changes_.pop_front()) {
    shown_ = changes_.front().second;
    bounces_until_ns_ = changes_.front().first + delay_ns_ + bounce_ns_;
  }
  return stamp_ns < bounces_until_ns_ ? random_.Index(2) == 1 : shown_;
}

MiscalibratedSensors::MiscalibratedSensors(const CalibrationError& error, const Robot& robot, uint64_t seed)
    : error_(error),
      left_(error.switch_delay_ms.x(), error.switch_bounce_ms.x(), RandomStream(seed, "calibration_error.left_switch")),
      right_(error.switch_delay_ms.y(), error.switch_bounce_ms.y(),
             RandomStream(seed, "calibration_error.right_switch")) {
  for (double& zero : error_.encoder_deg) zero *= kRadPerDeg;
  if (!error_.encoder_deg.empty()) pan_zero_rad_ = HeadPan(robot).Of(error_.encoder_deg);
}

void MiscalibratedSensors::Apply(Observation& observation) {
  const int64_t offset_ns = Nanoseconds(error_.time_offset_ms);
  for (ImuSample& sample : observation.imu) {
    sample.stamp_ns += offset_ns;
    sample.angular_rate += 0.01 * error_.gyro_scale_pct.cwiseProduct(sample.angular_rate);
    sample.specific_force += 0.01 * error_.accel_scale_pct.cwiseProduct(sample.specific_force);
  }
  for (JointSample& sample : observation.joints) {
    sample.left_contact = left_.Read(sample.stamp_ns, sample.left_contact);
    sample.right_contact = right_.Read(sample.stamp_ns, sample.right_contact);
    sample.stamp_ns += offset_ns;
    const size_t joints = std::min(sample.position.size(), error_.encoder_deg.size());
    for (size_t i = 0; i < joints; ++i) sample.position[i] += error_.encoder_deg[i];
  }
  for (OdometrySample& sample : observation.odometry) sample.stamp_ns += offset_ns;
  if (observation.scan) observation.scan->pan_rad += pan_zero_rad_;
}

FrameEstimate MiscalibratedSystem::Track(const Observation& observation) {
  Observation seen = observation;
  sensors_.Apply(seen);
  return system_->Track(seen);
}

std::vector<std::pair<std::string, std::string>> CalibrationErrorFacts(const ResolvedScenario& resolved) {
  const Scenario& scenario = resolved.scenario;
  if (SaysNothing(scenario.calibration_error)) return {};
  CalibrationError error = DrawCalibrationError(scenario.calibration_error, resolved.robot, scenario.seed);
  FactWriter writer;
  VisitFields(writer, error);
  return std::move(writer.facts);
}

}  // namespace gaitcam
