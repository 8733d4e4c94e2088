// Dead reckoning as a shared library: turns as the gyroscope says and walks on at a constant speed. The same as
// gyro_process.py, as a class of gaitcam's own kind.
//
//   system: {plugin: ./libgyro_plugin.so, speed_m_s: 0.1}

#include "algorithms/slam/plugin.h"
#include "algorithms/slam/settings.h"

namespace {

struct GyroOptions {
  using DescribedTag = void;
  double speed_m_s = 0.1;
};

template <class Visitor>
void VisitFields(Visitor& visit, GyroOptions& o) {
  visit("speed_m_s", o.speed_m_s, gaitcam::Between(0, 10), "along the optical axis");
}

class GyroSlam : public gaitcam::System {
 public:
  explicit GyroSlam(const gaitcam::SystemSetup& setup)
      : options_(gaitcam::OptionsFrom<GyroOptions>(setup.settings, "gyro")),
        R_CI_(setup.calibration.imu.X_CI.rotation) {}

  gaitcam::FrameEstimate Track(const gaitcam::Observation& observation) override {
    for (const gaitcam::ImuSample& sample : observation.imu) {
      const double dt = last_ns_ < 0 ? 0 : double(sample.stamp_ns - last_ns_) * 1e-9;
      last_ns_ = sample.stamp_ns;
      pose_.rotation = pose_.rotation * gaitcam::ExpSo3(R_CI_ * sample.angular_rate * dt);
      pose_.translation += options_.speed_m_s * dt * (pose_.rotation * Eigen::Vector3d::UnitZ());
    }
    gaitcam::FrameEstimate answer;
    answer.stamp_ns = observation.stamp_ns;
    answer.status = gaitcam::TrackingStatus::kTracking;
    answer.pose = pose_;
    return answer;
  }

 private:
  GyroOptions options_;
  Eigen::Quaterniond R_CI_;
  gaitcam::Pose pose_;
  int64_t last_ns_ = -1;
};

}  // namespace

GAITCAM_SYSTEM_PLUGIN(GyroSlam, gaitcam::SystemInfo{"gyro",
                                                    "gyroscope and a constant speed",
                                                    gaitcam::ListFields(GyroOptions()),
                                                    {gaitcam::SensorNeed::kImu}})
