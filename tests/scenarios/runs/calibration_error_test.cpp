// What a calibration has wrong reaches the system and nothing else.

#include "scenarios/code/runs/calibration_error.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/dataset_reader.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/runs/recorded_walk.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const Robot& Khr() {
  static const Robot robot = ReadRobot("khr1hv", ModelsFolder());
  return robot;
}

Calibration SomeCalibration() {
  Calibration calibration;
  calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  calibration.right = calibration.camera;
  calibration.imu.rate_hz = 250;
  calibration.standing = StandingCamera{0.4, {0, -1, 0}};
  calibration.odometry.rate_hz = 50;  // of a body with a level camera 0.4 m over the floor
  calibration.odometry.X_BC = {RotZ(-kPi / 2) * RotX(-kPi / 2), Eigen::Vector3d(0.05, 0, 0.4)};
  return calibration;
}

Observation SomeReadings(int64_t stamp_ns, bool left, size_t joints) {
  Observation o;
  o.stamp_ns = stamp_ns;
  o.imu.resize(1);
  o.imu[0].stamp_ns = stamp_ns;
  o.imu[0].angular_rate = {1, 2, 3};
  o.imu[0].specific_force = {4, 5, 6};
  o.joints.resize(1);
  o.joints[0].stamp_ns = stamp_ns;
  o.joints[0].position.assign(joints, 0.1);
  o.joints[0].left_contact = left;
  return o;
}

std::string Text(const Observation& o) {
  std::string text = std::to_string(o.stamp_ns);
  for (const ImuSample& s : o.imu) {
    text += fmt::format("\n{} {} {} {}", s.stamp_ns, s.angular_rate.x(), s.angular_rate.y(), s.angular_rate.z());
    text += fmt::format(" {} {} {}", s.specific_force.x(), s.specific_force.y(), s.specific_force.z());
  }
  for (const JointSample& s : o.joints) {
    text += fmt::format("\n{} {} {}", s.stamp_ns, s.left_contact, s.right_contact);
    for (const double q : s.position) text += fmt::format(" {}", q);
  }
  for (const OdometrySample& s : o.odometry) {
    const Eigen::Vector2d& p = s.position;
    text += fmt::format("\n{} {} {} {}", s.stamp_ns, p.x(), p.y(), s.heading);
  }
  return text;
}

class CalibrationErrorTest : public testing::Test {
 protected:
  ResolvedScenario Read(const std::string& block, const std::vector<std::string>& changes = {}) const {
    std::ofstream(temporary_.path() / "s.yaml") << kTinyWalk << block;
    return ReadScenario(temporary_.path() / "s.yaml", changes);
  }
  std::string Refusal(const std::string& block) const {
    try {
      Read(block);
    } catch (const BadInput& e) {
      return e.what();
    }
    return "";
  }
  const TemporaryFolder temporary_;
};

TEST_F(CalibrationErrorTest, WithoutOneNothingChangesToTheBit) {
  const Calibration right = SomeCalibration();
  const CalibrationError none = DrawCalibrationError({}, Khr(), 5);
  EXPECT_EQ(CalibrationText(Miscalibrated(right, none)), CalibrationText(right));
  MiscalibratedSensors sensors(none, Khr(), 5);
  const Observation readings = SomeReadings(7, true, Khr().joints.size());
  Observation seen = readings;
  sensors.Apply(seen);
  EXPECT_EQ(Text(seen), Text(readings));
  const ResolvedScenario plain = Read("");
  EXPECT_THAT(plain.ToYaml(), Not(HasSubstr("calibration_error")));
  for (const char* block : {"calibration_error: none\n", "calibration_error: {focal_pct: 0}\n"}) {
    EXPECT_EQ(Read(block).ToYaml(), plain.ToYaml());
    EXPECT_EQ(HashOf(Read(block)), HashOf(plain));
  }
}

TEST_F(CalibrationErrorTest, AWordIsAPresetAndKeysDifferFromIt) {
  const CalibrationErrorOptions bench = Read("calibration_error: bench\n").scenario.calibration_error;
  EXPECT_EQ(bench.focal_pct, 0.3);
  EXPECT_EQ(bench.centre_px, 1);
  EXPECT_EQ(bench.imu_deg, 0.5);
  EXPECT_EQ(bench.time_offset_ms, 2);
  EXPECT_EQ(bench.height_pct, 2);
  EXPECT_EQ(bench.pitch_deg, 0.5);
  EXPECT_EQ(bench.encoder_deg, 0.3);
  const ResolvedScenario mixed = Read("calibration_error: {height_pct: 5, preset: bench}\n");
  EXPECT_EQ(mixed.scenario.calibration_error.height_pct, 5);
  EXPECT_EQ(mixed.scenario.calibration_error.focal_pct, 0.3);
  const ResolvedScenario set = Read("calibration_error: bench\n", {"calibration_error.height_pct=5"});
  EXPECT_EQ(set.ToYaml(), mixed.ToYaml());
  std::ofstream(temporary_.path() / "again.yaml") << mixed.ToYaml();
  EXPECT_EQ(ReadScenario(temporary_.path() / "again.yaml", {}).ToYaml(), mixed.ToYaml());
}

TEST_F(CalibrationErrorTest, WhatIsNotPermittedIsRefusedWithItsPlace) {
  EXPECT_THAT(Refusal("calibration_error: benhc\n"), testing::AllOf(HasSubstr("s.yaml:6"), HasSubstr("bench")));
  EXPECT_THAT(Refusal("calibration_error: {focal_pct: -1}\n"),
              testing::AllOf(HasSubstr("s.yaml:6"), HasSubstr("calibration_error.focal_pct")));
  EXPECT_THAT(Refusal("calibration_error: {focal: 1}\n"), HasSubstr("focal_pct"));
}

TEST_F(CalibrationErrorTest, ALocalisationKnowsNone) {
  try {
    ReadScenario(DataFolder() / "scenarios/robocup_localisation.yaml", {"calibration_error=bench"});
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("--set calibration_error=bench: a localisation knows none"));
  }
}

TEST_F(CalibrationErrorTest, FramesAreTheSameAndRunsAreNot) {
  const ResolvedScenario plain = Read(""), bench = Read("calibration_error: bench\n");
  EXPECT_EQ(FramesHashOf(bench), FramesHashOf(plain));
  EXPECT_NE(HashOf(bench), HashOf(plain));
}

TEST_F(CalibrationErrorTest, DrawsHaveTheStatedSigmaAndDifferBetweenSeeds) {
  CalibrationErrorOptions o = CalibrationErrorOptions::Of(CalibrationErrorPreset::kBench);
  o.distortion_px = 0.7;
  o.imu_scale_pct = 0.4;
  o.switch_delay_ms = 8;
  constexpr int kSeeds = 4000;
  std::map<std::string, double> squares;
  std::set<double> focal;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const CalibrationError e = DrawCalibrationError(o, Khr(), seed);
    const auto add = [&](const char* name, double value, double sigma) {
      squares[name] += value * value / sigma / sigma / kSeeds;
    };
    focal.insert(e.focal_pct);
    add("focal", e.focal_pct, 0.3);
    add("cx", e.centre_px.x(), 1);
    add("cy", e.centre_px.y(), 1);
    add("distortion", e.distortion_px, 0.7);
    add("imu", e.imu_deg.z(), 0.5);
    add("gyro", e.gyro_scale_pct.x(), 0.4);
    add("accel", e.accel_scale_pct.y(), 0.4);
    add("time", e.time_offset_ms, 2);
    add("height", e.height_pct, 2);
    add("pitch", e.pitch_deg, 0.5);
    add("delay", e.switch_delay_ms.x(), 8);
    ASSERT_EQ(e.encoder_deg.size(), Khr().joints.size());
    for (size_t i = 0; i < e.encoder_deg.size(); ++i) {
      if (Khr().joints[i].kind == RobotJoint::Kind::kFixed) {
        EXPECT_EQ(e.encoder_deg[i], 0);
      } else {
        add(("encoder" + std::to_string(i)).c_str(), e.encoder_deg[i], 0.3);
      }
    }
    EXPECT_GE(e.switch_delay_ms.minCoeff(), 0);
  }
  EXPECT_EQ(focal.size(), size_t(kSeeds));
  // A variance of n draws is known to sqrt(2 / n), 2.2 %; five times that is allowed, for some thirty numbers.
  for (const auto& [name, square] : squares) EXPECT_NEAR(square, 1, 0.11) << name;
}

TEST_F(CalibrationErrorTest, OneErrorIsTheSameWhetherOrNotThereAreOthers) {
  const CalibrationError all =
      DrawCalibrationError(CalibrationErrorOptions::Of(CalibrationErrorPreset::kBench), Khr(), 9);
  CalibrationErrorOptions pitch;
  pitch.pitch_deg = 0.5;
  EXPECT_EQ(DrawCalibrationError(pitch, Khr(), 9).pitch_deg, all.pitch_deg);
}

TEST_F(CalibrationErrorTest, TheBenchSaysHowWrongItMayBeAndFilesKeepIt) {
  const CalibrationErrorOptions bench = CalibrationErrorOptions::Of(CalibrationErrorPreset::kBench);
  const Calibration told = Miscalibrated(SomeCalibration(), DrawCalibrationError(bench, Khr(), 3));
  EXPECT_DOUBLE_EQ(told.lens.focal, 0.003);
  EXPECT_DOUBLE_EQ(told.lens.centre_px, 1);
  EXPECT_DOUBLE_EQ(told.lens.right_focal, 0.0005);
  EXPECT_DOUBLE_EQ(told.standing->height_sigma, 0.02);
  EXPECT_DOUBLE_EQ(told.standing->pitch_sigma, 0.5 * kRadPerDeg);
  EXPECT_TRUE(SomeCalibration().lens.IsExact());
  std::ofstream(temporary_.path() / "calibration.yaml") << CalibrationText(told);
  EXPECT_EQ(CalibrationText(ReadCalibration(temporary_.path() / "calibration.yaml")), CalibrationText(told));
  std::string negative = CalibrationText(told);
  negative.insert(negative.find("pitch_sigma: ") + std::string("pitch_sigma: ").size(), "-");
  std::ofstream(temporary_.path() / "bad.yaml") << negative;
  EXPECT_THROW(ReadCalibration(temporary_.path() / "bad.yaml"), BadInput);
}

TEST_F(CalibrationErrorTest, EachErrorOfTheCalibrationIsTold) {
  const Calibration right = SomeCalibration();
  CalibrationError e;
  e.focal_pct = 2;
  e.centre_px = {1.5, -0.5};
  e.distortion_px = 3;
  e.imu_deg = {0, 0, 90};
  e.height_pct = -10;
  e.pitch_deg = 30;
  const Calibration told = Miscalibrated(right, e);
  for (const CameraModel& camera : {told.camera, *told.right}) {
    EXPECT_DOUBLE_EQ(camera.fx, 1.02 * right.camera.fx);
    EXPECT_DOUBLE_EQ(camera.fy, 1.02 * right.camera.fy);
    EXPECT_DOUBLE_EQ(camera.cx, right.camera.cx + 1.5);
    EXPECT_DOUBLE_EQ(camera.cy, right.camera.cy - 0.5);
    // The corner of the image, seen from the principal point, moves outwards by three pixels.
    const Eigen::Vector2d corner(160 / camera.fx, 120 / camera.fy);
    EXPECT_NEAR((camera.Distort(corner) - corner).norm() * camera.fx, 3, 1e-9);
  }
  EXPECT_NEAR((told.imu.X_CI.R() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-12);
  EXPECT_DOUBLE_EQ(told.standing->height_m, 0.36);
  // A level camera that is believed to look down by 30 degrees has the vertical behind it.
  EXPECT_NEAR((told.standing->up_C - Eigen::Vector3d(0, -std::cos(kPi / 6), -0.5)).norm(), 0, 1e-12);
  // The odometry's body is told of the same camera.
  const Pose& X_BC = told.odometry.X_BC;
  EXPECT_NEAR((X_BC.R().transpose() * Eigen::Vector3d::UnitZ() - told.standing->up_C).norm(), 0, 1e-12);
  EXPECT_NEAR((X_BC.translation - Eigen::Vector3d(0.05, 0, 0.36)).norm(), 0, 1e-12);
}

TEST_F(CalibrationErrorTest, EachErrorOfTheSensorsIsHandedOver) {
  CalibrationError e;
  e.gyro_scale_pct = {1, 0, -1};
  e.accel_scale_pct = {0, 10, 0};
  e.time_offset_ms = -2.5;
  e.encoder_deg.assign(Khr().joints.size(), 0);
  e.encoder_deg[2] = 1;
  MiscalibratedSensors sensors(e, Khr(), 1);
  Observation o = SomeReadings(10'000'000, true, Khr().joints.size());
  o.scan = ScanState{0.3, 0.4};
  sensors.Apply(o);
  EXPECT_EQ(o.stamp_ns, 10'000'000);  // the camera's own clock is the one that counts
  EXPECT_EQ(o.imu[0].stamp_ns, 7'500'000);
  EXPECT_EQ(o.joints[0].stamp_ns, 7'500'000);
  EXPECT_NEAR((o.imu[0].angular_rate - Eigen::Vector3d(1.01, 2, 2.97)).norm(), 0, 1e-12);
  EXPECT_NEAR((o.imu[0].specific_force - Eigen::Vector3d(4, 5.5, 6)).norm(), 0, 1e-12);
  EXPECT_DOUBLE_EQ(o.joints[0].position[2], 0.1 + kRadPerDeg);
  EXPECT_EQ(o.joints[0].position[1], 0.1);
}

TEST_F(CalibrationErrorTest, TheNecksZeroTurnsWhatAScanBelieves) {
  const Robot robot = ReadRobot("khr1hv_pan", ModelsFolder());
  CalibrationError e;
  e.encoder_deg.assign(robot.joints.size(), 2);
  const double pan_rad = HeadPan(robot).Of(std::vector<double>(robot.joints.size(), 2 * kRadPerDeg));
  ASSERT_GT(std::abs(pan_rad), 0.01);
  MiscalibratedSensors sensors(e, robot, 1);
  Observation o = SomeReadings(0, true, robot.joints.size());
  o.scan = ScanState{0.3, 0.4};
  sensors.Apply(o);
  EXPECT_NEAR(o.scan->pan_rad, 0.3 + pan_rad, 1e-12);
  EXPECT_EQ(o.scan->body_turn_rad, 0.4);
}

TEST_F(CalibrationErrorTest, AFootSwitchIsLateAndThenBounces) {
  CalibrationError e;
  e.switch_delay_ms = {10, 0};
  MiscalibratedSensors late(e, Khr(), 1);
  e.switch_bounce_ms = {40, 0};
  MiscalibratedSensors bouncing(e, Khr(), 1);
  int open_while_bouncing = 0;
  for (int i = 0; i < 60; ++i) {  // every 4 ms; the foot comes down at 80 ms
    const int64_t ms = 4 * i;
    Observation a = SomeReadings(ms * 1'000'000, ms >= 80, 0), b = a;
    late.Apply(a);
    bouncing.Apply(b);
    EXPECT_EQ(a.joints[0].left_contact, ms >= 90) << ms;
    if (ms < 90 || ms >= 130) {
      EXPECT_EQ(b.joints[0].left_contact, ms >= 90) << ms;
    } else {
      open_while_bouncing += b.joints[0].left_contact ? 0 : 1;
    }
  }
  EXPECT_GT(open_while_bouncing, 0);  // of ten readings at random; the seed is fixed
  EXPECT_LT(open_while_bouncing, 10);
}

// The sensors' folder holds what a live system would be told; the truth's is that of the walk without any error.
TEST_F(CalibrationErrorTest, ARecordingIsWrongAsALiveRunIsAndItsTruthIsRight) {
  const std::string odometry = "sensors.odometry={}";
  const std::vector<std::string> wrong{
      odometry,
      "calibration_error={preset: bench, distortion_px: 1, imu_scale_pct: 1, switch_delay_ms: 10, switch_bounce_ms: "
      "20}"};
  const DatasetFolders right_walk = RecordTinyWalk(temporary_.path() / "right", "euroc", {odometry});
  const DatasetFolders wrong_walk = RecordTinyWalk(temporary_.path() / "wrong", "euroc", wrong);
  const ResolvedScenario resolved = ReadScenario(temporary_.path() / "wrong" / "walk.yaml", wrong);
  const CalibrationError error =
      DrawCalibrationError(resolved.scenario.calibration_error, resolved.robot, resolved.scenario.seed);
  DatasetReader right(right_walk.sensors), told(wrong_walk.sensors);
  EXPECT_EQ(CalibrationText(told.calibration()), CalibrationText(Miscalibrated(right.calibration(), error)));
  EXPECT_NE(CalibrationText(told.calibration()), CalibrationText(right.calibration()));
  MiscalibratedSensors sensors(error, resolved.robot, resolved.scenario.seed, 50);
  size_t frames = 0;
  while (std::optional<Observation> a = right.Next()) {
    const std::optional<Observation> b = told.Next();
    ASSERT_TRUE(b.has_value());
    const std::string before = Text(*a);
    sensors.Apply(*a);
    EXPECT_NE(before, Text(*a));
    EXPECT_FALSE(a->odometry.empty());
    EXPECT_EQ(Text(*a), Text(*b));
    EXPECT_EQ(cv::norm(a->image.pixels, b->image.pixels, cv::NORM_INF), 0);
    ++frames;
  }
  EXPECT_EQ(frames, 20U);
  for (const char* name : {"groundtruth.txt", "frames.csv", "subposes.csv"}) {
    EXPECT_EQ(ReadText(wrong_walk.truth / name), ReadText(right_walk.truth / name)) << name;
  }
  EXPECT_EQ(CalibrationText(ReadRecordedWalk(wrong_walk).calibration), CalibrationText(right.calibration()));
  EXPECT_THAT(ReadText(wrong_walk.truth / "calibration_error.yaml"),
              HasSubstr("focal_pct: " + internal::NumberText(error.focal_pct)));
  EXPECT_FALSE(fs::exists(right_walk.truth / "calibration.yaml"));
  const ProgramResult valid = RunProgram("validate wrong", temporary_.path());
  EXPECT_EQ(valid.exit_code, 0) << valid.out << valid.err;
}

// One recorded walk serves runs of different errors, and each is what a live run would be, to the byte.
TEST_F(CalibrationErrorTest, ARunFromACachedWalkEqualsALiveOneAndTheTruthStaysRight) {
  std::ofstream(temporary_.path() / "s.yaml")
      << "duration_s: 2\ngait: {preset: brisk}\npath: {kind: circle, diameter_m: 4, settle_s: 0.3}\n"
         "camera: {width_px: 240, height_px: 180, rate_hz: 10, exposure_ms: 10, fixed_subframes: 2}\n"
         "score: {min_coverage_ratio: 0, min_pairs: 3}\nvideo: {enabled: false}\nsystem: mobif_vo_plus\n";
  std::ofstream(temporary_.path() / "study.yaml")
      << "base: s.yaml\naxes: {calibration_error: [none, bench, {focal_pct: 3}]}\nmetrics: [coverage_ratio]\n";
  const ProgramResult study = RunProgram("study study.yaml --out study --cache cache -q", temporary_.path());
  ASSERT_EQ(study.exit_code, 0) << study.err;
  int cached = 0;
  for (const auto& entry : fs::directory_iterator(temporary_.path() / "cache")) cached += entry.is_directory() ? 1 : 0;
  EXPECT_EQ(cached, 1);
  std::set<std::string> estimates, truths;
  for (const auto& entry : fs::recursive_directory_iterator(temporary_.path() / "study")) {
    if (entry.path().filename() != "job.json") continue;
    const fs::path job = entry.path().parent_path();
    estimates.insert(ReadText(job / "estimate.txt"));
    truths.insert(ReadText(job / "truth.txt"));
    if (ReadText(job / "scenario.yaml").find("preset: bench") == std::string::npos) continue;
    EXPECT_THAT(ReadText(job / "job.json"), HasSubstr("\"time_offset_ms\""));
    const ProgramResult live = RunProgram("run s.yaml --set calibration_error=bench --out live -q", temporary_.path());
    ASSERT_THAT(live.exit_code, testing::AnyOf(0, 3)) << live.err;
    EXPECT_EQ(ReadText(job / "estimate.txt"), ReadText(temporary_.path() / "live/estimate.txt"));
    EXPECT_EQ(ReadText(job / "truth.txt"), ReadText(temporary_.path() / "live/truth.txt"));
    EXPECT_THAT(ReadText(temporary_.path() / "live/scores.json"), HasSubstr("\"calibration_error\""));
    EXPECT_THAT(ReadText(temporary_.path() / "live/report.html"), HasSubstr("calibration error drawn: focal_pct"));
  }
  EXPECT_EQ(estimates.size(), 3U);
  EXPECT_EQ(truths.size(), 1U);
}

}  // namespace
}  // namespace gaitcam
