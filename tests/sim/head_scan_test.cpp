// A robot that stops when asked, looks all around and goes on: in physics, with servos, sensors and a camera.

#include "sim/head_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "algorithms/core/errors.h"
#include "sim/simulation.h"
#include "tests/sim/walk_trial.h"

namespace gaitcam {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

constexpr double kRadPerDeg = pi / 180;

/// A small picture often enough: 25 Hz as the real robots had, one instant per image.
SimulationOptions Options(const Robot& robot, const std::string& preset = "normal") {
  SimulationOptions options;
  options.gait = robot.kind == Robot::Kind::kHumanoid ? robot.gaits.at(preset) : GaitOptions();
  options.path.length_m = 1.2;
  options.camera.width_px = 40;
  options.camera.height_px = 30;
  options.camera.hfov_deg = 56.9;
  options.camera.rate_hz = 25;
  options.camera.pitch_deg = 0;
  options.camera.antialias = 1;
  options.camera.exposure.exposure_ms = 5;
  options.camera.exposure.fixed_subframes = 1;
  return options;
}

/// What frames with a scan state say, and what was true of them.
struct ScanLog {
  std::vector<double> pan_error_deg;  ///< Of pan and body's turn together, against the camera's true yaw.
  std::set<int> seen_deg;             ///< Directions that some column of some frame looked in, from the scan's begin.
  std::vector<double> blur_px;
  double begin_s = 0, end_s = 0;
  double way_m = 0;  ///< Of the root while it swept.
  double body_turn_rad = 0;
};

struct Walked {
  std::vector<ScanLog> scans;
  std::vector<double> path_error_m;  ///< Of the root, per frame.
  std::vector<double> stop_s;        ///< From being asked to walking again.
  SimulationStatus status = SimulationStatus::kWalking;
  PlanarPose end;
  Eigen::Quaterniond last_rotation;
  int64_t expected_frames = 0, frames = 0;
};

void AddFrame(const SimulatedFrame& frame, double half_view_rad, double yaw_begin, ScanLog& log) {
  const ScanState& scan = *frame.observation.scan;
  const Eigen::Vector3d view = frame.truth.camera.X_WC.R().col(2);
  const double yaw = std::remainder(std::atan2(view.y(), view.x()) - yaw_begin, 2 * pi);
  const double said = scan.pan_rad + scan.body_turn_rad;
  log.pan_error_deg.push_back(std::abs(std::remainder(said - yaw, 2 * pi)) / kRadPerDeg);
  log.blur_px.push_back(frame.truth.camera.blur_median_px);
  for (double a = -half_view_rad; a <= half_view_rad; a += 0.25 * kRadPerDeg) {
    log.seen_deg.insert((int(std::floor((yaw + a) / kRadPerDeg)) + 720) % 360);
  }
  log.body_turn_rad = scan.body_turn_rad;
  log.end_s = 1e-9 * double(frame.truth.stamp_ns);
  if (log.begin_s == 0) log.begin_s = log.end_s;
}

/// Walks to the end; at each of these frames a scan is asked for.
Walked Walk(const Robot& robot, const SimulationOptions& options, const std::set<int64_t>& ask_at, uint64_t seed = 1) {
  Place place;
  place.floor_min = {-20, -20};
  place.floor_max = {20, 20};
  Simulation simulation(robot, place, options, seed);
  const double half_view = options.camera.hfov_deg / 2 * kRadPerDeg;
  const Path path(options.path, {});
  Walked walked;
  double yaw_begin = 0, asked_s = 0;
  bool scanned = false;
  while (const auto frame = simulation.Next({false, false, true})) {
    const double time_s = 1e-9 * double(frame->truth.stamp_ns);
    const Pose& X_WB = frame->truth.X_WB;
    if (frame->observation.scan && !scanned) {
      walked.scans.emplace_back();
      yaw_begin = X_WB.Yaw();
    }
    if (frame->observation.scan) AddFrame(*frame, half_view, yaw_begin, walked.scans.back());
    scanned = simulation.scans() && (scanned || frame->observation.scan);
    if (asked_s > 0 && !simulation.scans()) {
      walked.stop_s.push_back(time_s - asked_s);
      asked_s = 0;
    }
    if (ask_at.count(walked.frames++)) {
      simulation.RequestScan();
      asked_s = time_s;
    }
    walked.path_error_m.push_back(path.DistanceTo(X_WB.translation.head<2>()));
    walked.end = PlanarPose(X_WB);
    walked.last_rotation = X_WB.rotation;
  }
  walked.status = simulation.status();
  walked.expected_frames = simulation.ExpectedFrames();
  return walked;
}

double Worst(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

void Print(const char* name, const Walked& w) {
  for (size_t i = 0; i < w.scans.size(); ++i) {
    std::vector<double> errors = w.scans[i].pan_error_deg;
    std::sort(errors.begin(), errors.end());
    printf(
        "%s scan %zu: %zu frames, %zu deg seen, pan error median %.2f p95 %.2f max %.2f deg, blur median %.2f max "
        "%.2f, "
        "sweeps %.1f s, stop %.1f s\n",
        name, i, errors.size(), w.scans[i].seen_deg.size(), errors[errors.size() / 2], errors[errors.size() * 95 / 100],
        errors.back(), Median(w.scans[i].blur_px), Worst(w.scans[i].blur_px), w.scans[i].end_s - w.scans[i].begin_s,
        i < w.stop_s.size() ? w.stop_s[i] : -1);
  }
  printf("%s: end %.3f %.3f %.3f, worst path error %.3f, frames %ld expected %ld\n", name, w.end.position.x(),
         w.end.position.y(), w.end.heading, Worst(w.path_error_m), long(w.frames), long(w.expected_frames));
}

TEST(HeadScan, WalkerStopsTwiceSeesAllAroundAndEndsOnItsPath) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  const Walked walked = Walk(robot, Options(robot), {60, 600});
  Print("khr1hv_pan", walked);
}

TEST(HeadScan, Turning) {
  const Robot robot = ReadShippedRobot("khr1hv");
  const Walked walked = Walk(robot, Options(robot), {60});
  Print("khr1hv", walked);
}

TEST(HeadScan, AtOnce) {
  const Robot robot = ReadShippedRobot("khr1hv_pan");
  Print("pan at once", Walk(robot, Options(robot), {0}));
  Print("khr1hv at once", Walk(ReadShippedRobot("khr1hv"), Options(robot), {0}));
  const Robot base = ReadShippedRobot("omni_base");
  Print("base", Walk(base, Options(base), {60}));
}

}  // namespace
}  // namespace gaitcam
