#include "sim/walking/kidnap.h"

#include <gtest/gtest.h>

#include "algorithms/core/units.h"
#include "sim/simulation.h"
#include "tests/sim/walking/walk_trial.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

/// A base in the lab that is lifted after a second and set down after two more, with exact wheels.
SimulationOptions CarriedAfterASecond() {
  SimulationOptions options;
  options.camera.width_px = 40;
  options.camera.height_px = 30;
  options.camera.rate_hz = 10;
  options.camera.antialias = 1;
  options.camera.exposure.fixed_subframes = 1;
  options.sensors.odometry.emplace();
  options.sensors.perfect = true;
  options.start = {-1.2, -1.5, 30};
  options.duration_s = 8;
  options.path.kind = PathKind::kStand;
  options.kidnap = KidnapOptions{1, {0.6, -1.2, -170}, 2};
  return options;
}

struct Carried {
  std::vector<PlanarPose> body;
  std::vector<OdometrySample> wheels;
  double turned_rad = 0;  ///< By the gyroscope.
  double driven_m = 0;

  explicit Carried(const SimulationOptions& options, const BodyCommand& command = FollowPath()) {
    Simulation simulation(ReadShippedRobot("omni_base"), ReadScene("lab", TestData() / "models"), options, 1);
    while (const std::optional<SimulatedFrame> frame = simulation.Next({false, false, false})) {
      body.emplace_back(*frame->truth.X_WB);
      const Observation& seen = frame->observation;
      wheels.insert(wheels.end(), seen.odometry.begin(), seen.odometry.end());
      for (const ImuSample& sample : seen.imu) turned_rad += sample.angular_rate.z() / options.sensors.imu_rate_hz;
      simulation.Command(command);
    }
    driven_m = simulation.distance_m();
  }
};

TEST(Kidnap, SetsARobotDownElsewhereUnknownToItsWheels) {
  const Carried carried(CarriedAfterASecond(), Velocity{});
  const PlanarPose& before = carried.body[8];
  EXPECT_LT((before.position - Vector2d(-1.2, -1.5)).norm(), 1e-3);
  const PlanarPose& down = carried.body[34];  // set down at 3 s; the drive's servo has come to rest
  EXPECT_LT((down.position - Vector2d(0.6, -1.2)).norm(), 2e-3);
  EXPECT_LT(std::abs(WrapAngle(down.heading + 170 * kRadPerDeg)), 2e-3);
  // Wheels in the air count nothing; what is left is the servo's swing before and after.
  for (const OdometrySample& sample : carried.wheels) EXPECT_LT(sample.position.norm(), 0.01);
}

TEST(Kidnap, TheGyroscopeFeelsTheTurn) {
  SimulationOptions options = CarriedAfterASecond();
  options.duration_s = 3.6;
  // From 30 to -170 degrees the short way: 160 to the left. Sums of 100 samples a second of a rate that is smooth.
  const Carried carried(options, Velocity{});
  EXPECT_NEAR(std::abs(carried.turned_rad), 160 * kRadPerDeg, 0.02);
}

TEST(Kidnap, SetDownItGoesOnWithItsCommandFromThere) {
  const Carried carried(CarriedAfterASecond(), Velocity{0.1, 0, 0});
  const Vector2d ahead(std::cos(-170 * kRadPerDeg), std::sin(-170 * kRadPerDeg));
  const Vector2d went = carried.body.back().position - Vector2d(0.6, -1.2);
  EXPECT_NEAR(went.dot(ahead), 0.1 * (carried.body.size() * 0.1 - 3), 0.05);
  EXPECT_LT((went - went.dot(ahead) * ahead).norm(), 0.01);
  EXPECT_LT(carried.driven_m, 0.8) << "the way in the air is not driven";
}

TEST(Kidnap, OneThatFollowsAPathComesBackToIt) {
  SimulationOptions options = CarriedAfterASecond();
  options.duration_s = 40;
  options.kidnap->to = {0, -1.2, 0};
  options.path.kind = PathKind::kStraight;
  options.path.length_m = 0.5;
  const Carried carried(options);
  const Path path(options.path, Pose(RotZ(30 * kRadPerDeg), {-1.2, -1.5, 0}));
  EXPECT_LT((carried.body.back().position - path.goal().position).norm(), 0.02);
}

}  // namespace
}  // namespace gaitcam
