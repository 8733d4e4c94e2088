#include "sim/standing_robot.h"

#include <fmt/format.h>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kRest_s = 0.5;  ///< After it was put down; servos give way under the weight at first.

SimulationOptions Standing(const Robot& robot, SimulationOptions options) {
  options.path.kind = PathKind::kStand;
  options.path.pan_amplitude_rad = 0;
  options.path.duration_s = 2 * kRest_s;
  options.duration_s = 0;
  CheckHeadScan(robot, options);
  return options;
}

}  // namespace

StandingRobot::StandingRobot(const Robot& robot, const Scene& scene, SimulationOptions options, uint64_t seed)
    : simulation_(robot, scene, Standing(robot, std::move(options)), seed) {}

void StandingRobot::Fell(const Eigen::Vector3d& pose) const {
  throw BadInput(fmt::format("the robot cannot stand at x {:.3g} m, y {:.3g} m, yaw {:.3g} deg: it fell after {:.2f} s",
                             pose.x(), pose.y(), pose.z(), simulation_.end_time_s()));
}

std::vector<SimulatedFrame> StandingRobot::Scan(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth) {
  simulation_.Restart(pose, seed);
  simulation_.RequestScan();
  std::vector<SimulatedFrame> frames;
  while (std::optional<SimulatedFrame> frame = simulation_.NextOfScan(truth)) frames.push_back(std::move(*frame));
  if (simulation_.status() == SimulationStatus::kFell) Fell(pose);
  return frames;
}

SimulatedFrame StandingRobot::View(const Eigen::Vector3d& pose, uint64_t seed, const TruthOptions& truth) {
  simulation_.Restart(pose, seed);
  std::optional<SimulatedFrame> frame = simulation_.NextFrom(kRest_s, truth);
  if (!frame) Fell(pose);
  return std::move(*frame);
}

}  // namespace gaitcam
