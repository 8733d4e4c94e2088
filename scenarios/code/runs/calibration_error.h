/// What a bench calibration has wrong, drawn by seed: what a system is told and given instead of the truth.
///
/// Two kinds of errors. The calibration says something wrong: lens, direction of the IMU, the standing camera. Or what
/// the sensors hand over is wrong, because nobody has corrected it: scale of the IMU, stamps, encoders, foot switches.
/// Walk, frames, truth and scores know of neither; the body's own control reads its sensors as they are. Odometry of
/// legs is reckoned from the wrong readings; errors of wheels are their sensor's own (sensors.odometry).

#pragma once

#include <Eigen/Core>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/observation.h"
#include "algorithms/core/random.h"
#include "algorithms/slam/system.h"
#include "scenarios/code/files/scenario.h"
#include "sim/walking/head_scan.h"
#include "sim/walking/leg_odometry.h"

namespace gaitcam {

/// One draw of every error; the defaults change nothing.
struct CalibrationError {
  using DescribedTag = void;
  LensUncertainty lens;  ///< What the bench says of its own errors, here and in the two below.
  double height_sigma = 0, pitch_sigma = 0;
  double focal_pct = 0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double distortion_px = 0;
  Eigen::Vector3d imu_deg = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_scale_pct = Eigen::Vector3d::Zero(), accel_scale_pct = Eigen::Vector3d::Zero();
  double time_offset_ms = 0;
  double height_pct = 0;
  double pitch_deg = 0;
  Eigen::Vector2d switch_delay_ms = Eigen::Vector2d::Zero(), switch_bounce_ms = Eigen::Vector2d::Zero();
  Eigen::Vector3d stereo_deg = Eigen::Vector3d::Zero();
  double right_focal_pct = 0;
  Eigen::Vector2d right_centre_px = Eigen::Vector2d::Zero();
  std::vector<double> encoder_deg;  ///< Order of Robot::joints; empty: none is off.
};

template <class Visitor>
void VisitFields(Visitor& visit, CalibrationError& o) {
  visit("focal_pct", o.focal_pct, AnyNumber(), "told focal length against the true one");
  visit("centre_px", o.centre_px, Nested(), "told principal point minus the true one");
  visit("distortion_px", o.distortion_px, AnyNumber(), "outwards, of what the told k1 puts at the image's corner");
  visit("imu_deg", o.imu_deg, Nested(), "from the true to the told IMU, a rotation vector in the true one");
  visit("gyro_scale_pct", o.gyro_scale_pct, Nested(), "readings against the true rates");
  visit("accel_scale_pct", o.accel_scale_pct, Nested(), "readings against the true forces");
  visit("time_offset_ms", o.time_offset_ms, AnyNumber(), "stamps of IMU, encoders and foot switches, late");
  visit("height_pct", o.height_pct, AnyNumber(), "told height of the standing camera against the true one");
  visit("pitch_deg", o.pitch_deg, AnyNumber(), "told tilt of the standing camera minus the true one, looking down");
  visit("switch_delay_ms", o.switch_delay_ms, Nested(), "left and right foot switch");
  visit("switch_bounce_ms", o.switch_bounce_ms, Nested(), "left and right foot switch");
  visit("stereo_deg", o.stereo_deg, Nested(),
        "from the true to the told right camera, a rotation vector in the true one");
  visit("right_focal_pct", o.right_focal_pct, AnyNumber(), "of the right lens, beside focal_pct");
  visit("right_centre_px", o.right_centre_px, Nested(), "of the right lens, beside centre_px");
  visit("encoder_deg", o.encoder_deg, Nested(), "readings minus the true angles, in the order of the robot's joints");
}

/// The errors of a scenario's seed: sigma times a standard normal number each. All numbers are drawn whichever sigmas
/// are zero, so that one error is the same whether or not there are others.
CalibrationError DrawCalibrationError(const CalibrationErrorOptions& options, const Robot& robot, uint64_t seed);

/// What the system is told instead of the true calibration.
Calibration Miscalibrated(Calibration calibration, const CalibrationError& error);

/// What the sensors hand over instead of true readings. Observations must come in the order of time.
class MiscalibratedSensors {
 public:
  /// @param leg_odometry_hz its rate, of a humanoid; 0: it has none. It is reckoned anew from what these sensors show.
  MiscalibratedSensors(const CalibrationError& error, const Robot& robot, uint64_t seed, double leg_odometry_hz = 0);
  void Apply(Observation& observation);

 private:
  /// One foot's switch: late, and bouncing.
  class Switch {
   public:
    Switch(double delay_ms, double bounce_ms, RandomStream random);
    bool Read(int64_t stamp_ns, bool closed);

   private:
    int64_t delay_ns_, bounce_ns_;
    RandomStream random_;
    std::deque<std::pair<int64_t, bool>> changes_;  ///< Not shown yet: when, and to what.
    bool true_state_ = false, shown_ = false, began_ = false;
    int64_t bounces_until_ns_ = 0;
  };

  CalibrationError error_;
  double pan_zero_rad_ = 0;
  Switch left_, right_;
  std::optional<LegOdometry> legs_;
};

/// A system behind such sensors.
class MiscalibratedSystem : public System {
 public:
  MiscalibratedSystem(std::unique_ptr<System> system, MiscalibratedSensors sensors)
      : system_(std::move(system)), sensors_(std::move(sensors)) {}

  FrameEstimate Track(const Observation& observation) override;
  FinalEstimate Finish() override { return system_->Finish(); }
  BodyCommand Command() const override { return system_->Command(); }

 private:
  std::unique_ptr<System> system_;
  MiscalibratedSensors sensors_;
};

/// Names and values of what a scenario's seed drew, for people and files beside the truth: "focal_pct" and "0.21",
/// "centre_px" and "[0.4, -1.2]". Nothing if the scenario asks for no error.
std::vector<std::pair<std::string, std::string>> CalibrationErrorFacts(const ResolvedScenario& resolved);

/// Writes what the seed drew under "variation" and "calibration_error". @param json an object of nlohmann's.
template <class Json>
void WriteDrawn(const ResolvedScenario& resolved, Json& json) {
  for (const auto& [name, value] : VariationFacts(resolved)) json["variation"][name] = Json::parse(value);
  for (const auto& [name, value] : CalibrationErrorFacts(resolved))
    json["calibration_error"][name] = Json::parse(value);
}

}  // namespace gaitcam
