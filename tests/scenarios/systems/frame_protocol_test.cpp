#include "scenarios/code/systems/frame_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

Calibration Rig() {
  Calibration c;
  c.camera = CameraModel::FromHorizontalFov(8, 6, 61.3);
  c.camera.k1 = -0.1 / 3;
  c.right = c.camera;
  c.X_LR = Pose(Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.06, 1.0 / 3, 0});
  c.has_depth = true;
  c.frame_rate_hz = 29.97;
  c.imu.rate_hz = 250;
  c.imu.gyro_noise_density = 1.7e-4;
  c.imu.X_CI.translation = {1e-12, -0.1, 2};
  c.depth = {0.001 / 3, 0.003 / 7};
  c.odometry = {50, Pose(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 1.0 / 3, 1}), 0.03, 0.01 / 3, 0.1};
  c.standing = StandingCamera{0.31243588873125338, Eigen::Vector3d(0.1, -0.9, -0.3).normalized()};
  return c;
}

Observation Frame() {
  Observation o;
  o.stamp_ns = 1700000000033333333;
  o.exposure_ms = 20.0 / 3;
  const auto image = [&](int type) {
    cv::Mat pixels(6, 8, type);
    cv::randu(pixels, 0, 200);
    return Image{o.stamp_ns, pixels};
  };
  o.image = image(CV_8UC3);
  o.right = image(CV_8UC3);
  o.depth = image(CV_32FC1);
  o.imu = {{o.stamp_ns - 4, {0.1, -1.0 / 3, 1e-9}, {0, 9.81, 0.5}}, {o.stamp_ns, {0, 0, 0}, {1, 2, 3}}};
  o.joints = {{o.stamp_ns - 1, {0.25, -1.0 / 7}, true, false}};
  o.odometry = {{o.stamp_ns - 2, {0.5, -1.0 / 3}, 1e-9}, {o.stamp_ns + 5, {0.5, 1.0 / 3}, 7}};
  o.scan = ScanState{0.5, -0.25};
  return o;
}

bool SamePixels(const Image& a, const Image& b) {
  return a.pixels.type() == b.pixels.type() && a.pixels.size() == b.pixels.size() &&
         std::memcmp(a.pixels.data, b.pixels.data, a.pixels.total() * a.pixels.elemSize()) == 0;
}

TEST(FrameProtocol, AFrameArrivesToTheBit) {
  const TemporaryFolder folder;
  SharedFrames ours(folder.path() / "frames", Rig());
  const SharedFrames theirs(folder.path() / "frames");
  const Observation sent = Frame();
  const std::string line = FrameMessage(sent, ours);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  EXPECT_EQ(EventOf(line), FrameEvent::kFrame);
  const Observation read = ReadFrame(line, theirs);
  EXPECT_EQ(read.stamp_ns, sent.stamp_ns);
  EXPECT_EQ(read.exposure_ms, sent.exposure_ms);
  EXPECT_TRUE(SamePixels(read.image, sent.image));
  EXPECT_TRUE(SamePixels(*read.right, *sent.right));
  EXPECT_TRUE(SamePixels(*read.depth, *sent.depth));
  ASSERT_EQ(read.imu.size(), 2u);
  EXPECT_EQ(read.imu[0].stamp_ns, sent.imu[0].stamp_ns);
  EXPECT_EQ(read.imu[0].angular_rate, sent.imu[0].angular_rate);
  EXPECT_EQ(read.imu[1].specific_force, sent.imu[1].specific_force);
  ASSERT_EQ(read.joints.size(), 1u);
  EXPECT_EQ(read.joints[0].position, sent.joints[0].position);
  EXPECT_TRUE(read.joints[0].left_contact);
  ASSERT_EQ(read.odometry.size(), 2u);
  EXPECT_EQ(read.odometry[0].position, sent.odometry[0].position);
  EXPECT_EQ(read.odometry[1].stamp_ns, sent.odometry[1].stamp_ns);
  EXPECT_EQ(read.odometry[1].heading, sent.odometry[1].heading);
  EXPECT_EQ(read.scan->body_turn_rad, -0.25);
}

TEST(FrameProtocol, AGreyFrameAloneArrivesToo) {
  const TemporaryFolder folder;
  Calibration rig;
  rig.camera = Rig().camera;
  SharedFrames frames(folder.path() / "frames", rig);
  Observation sent;
  sent.image.pixels = cv::Mat(6, 8, CV_8UC1, cv::Scalar(7));
  const Observation read = ReadFrame(FrameMessage(sent, frames), frames);
  EXPECT_TRUE(SamePixels(read.image, sent.image));
  EXPECT_FALSE(read.right || read.depth || read.scan);
  EXPECT_TRUE(read.imu.empty());
}

TEST(FrameProtocol, TheStartTellsCalibrationSeedAndSettings) {
  const SystemSetup sent{Rig(), 18446744073709551615ULL, {{"ratio", 0.8}, {"feature", "orb"}}};
  std::filesystem::path file;
  const SystemSetup read = ReadStart(StartMessage(sent, "/dev/shm/x/frames"), file);
  EXPECT_EQ(file, "/dev/shm/x/frames");
  EXPECT_EQ(read.seed, sent.seed);
  EXPECT_EQ(read.settings.at("ratio").AsNumber(), 0.8);
  EXPECT_EQ(read.settings.at("feature").text(), "orb");
  EXPECT_EQ(read.calibration.camera.fx, sent.calibration.camera.fx);
  EXPECT_EQ(read.calibration.lens.focal, sent.calibration.lens.focal);
  EXPECT_EQ(read.calibration.lens.centre_px, sent.calibration.lens.centre_px);
  EXPECT_EQ(read.calibration.lens.right_focal, sent.calibration.lens.right_focal);
  EXPECT_EQ(read.calibration.right->k1, sent.calibration.right->k1);
  EXPECT_EQ(read.calibration.X_LR.translation, sent.calibration.X_LR.translation);
  EXPECT_EQ(read.calibration.X_LR.rotation.coeffs(), sent.calibration.X_LR.rotation.coeffs());
  EXPECT_EQ(read.calibration.imu.X_CI.translation, sent.calibration.imu.X_CI.translation);
  EXPECT_EQ(read.calibration.depth.sigma_m, sent.calibration.depth.sigma_m);
  EXPECT_EQ(read.calibration.depth.sigma_per_m, sent.calibration.depth.sigma_per_m);
  const OdometryCalibration &odometry = read.calibration.odometry, &expected = sent.calibration.odometry;
  EXPECT_EQ(odometry.rate_hz, expected.rate_hz);
  EXPECT_EQ(odometry.X_BC.translation, expected.X_BC.translation);
  EXPECT_EQ(odometry.X_BC.rotation.coeffs(), expected.X_BC.rotation.coeffs());
  EXPECT_EQ(odometry.position_per_sqrt_m, expected.position_per_sqrt_m);
  EXPECT_EQ(odometry.heading_per_sqrt_m, expected.heading_per_sqrt_m);
  EXPECT_EQ(odometry.heading_per_sqrt_rad, expected.heading_per_sqrt_rad);
  EXPECT_EQ(odometry.rocking_m, expected.rocking_m);
  EXPECT_EQ(odometry.rocking_rad, expected.rocking_rad);
  EXPECT_EQ(read.calibration.standing->up_C, sent.calibration.standing->up_C);
  EXPECT_EQ(read.calibration.standing->height_sigma, sent.calibration.standing->height_sigma);
  EXPECT_EQ(read.calibration.standing->pitch_sigma, sent.calibration.standing->pitch_sigma);
}

TEST(FrameProtocol, AnAnswerArrivesToTheBit) {
  FrameAnswer sent;
  sent.frame.stamp_ns = 5;
  sent.frame.status = TrackingStatus::kTracking;
  sent.frame.pose = Pose(Eigen::Quaterniond(0.1, 0.7, -0.3, 0.2).normalized(), {1.0 / 3, -2, 1e-17});
  sent.frame.covariance = Matrix6d::Random();
  sent.frame.own_covariance = Matrix6d::Random();
  sent.frame.common_errors = CommonErrors::Random(6, 3);
  sent.frame.restarted = true;
  sent.frame.features = 12;
  sent.frame.inliers = 7;
  sent.frame.matches = 9;
  for (const BodyCommand& command :
       {BodyCommand(FollowPath()), BodyCommand(Scan()), BodyCommand(Velocity{0.1, -0.2, 1.0 / 3}),
        BodyCommand(GoTo{1, 2, -3}), BodyCommand(EndWalk())}) {
    sent.command = command;
    const FrameAnswer read = ReadAnswer(AnswerMessage(sent), 5);
    EXPECT_EQ(read.frame.pose->translation, sent.frame.pose->translation);
    EXPECT_EQ(read.frame.pose->rotation.coeffs(), sent.frame.pose->rotation.coeffs());
    EXPECT_EQ(*read.frame.covariance, *sent.frame.covariance);
    ASSERT_TRUE(read.frame.own_covariance);
    EXPECT_EQ(*read.frame.own_covariance, *sent.frame.own_covariance);
    EXPECT_EQ(read.frame.common_errors, sent.frame.common_errors);
    EXPECT_TRUE(read.frame.restarted);
    EXPECT_EQ(read.frame.inliers, 7);
    EXPECT_EQ(read.frame.matches, 9);
    EXPECT_EQ(read.command, command);
  }
}

TEST(FrameProtocol, APredictionArrivesWhereThereIsNoPose) {
  FrameAnswer sent;
  sent.frame.status = TrackingStatus::kLost;
  sent.frame.predicted = Pose(Eigen::Quaterniond::Identity(), {1.0 / 3, 2, 3});
  const FrameAnswer read = ReadAnswer(AnswerMessage(sent), 5);
  EXPECT_FALSE(read.frame.pose);
  ASSERT_TRUE(read.frame.predicted);
  EXPECT_EQ(read.frame.predicted->translation, sent.frame.predicted->translation);
}

TEST(FrameProtocol, TheEndHandsOverFramesAndMaps) {
  FinalEstimate sent;
  sent.frames.resize(2);
  sent.frames[1].stamp_ns = 9;
  sent.frames[1].status = TrackingStatus::kLost;
  sent.maps.emplace_back(LandmarkMap{{{0, {1, 2, 1.0 / 3}, {}, {}}, {1, {4, 5, 6}, {}, {}}}});
  sent.maps.emplace_back(OccupancyGrid{(cv::Mat_<float>(2, 3) << 0, 1, -2, 0.1f, 4, 5), 0.05, {-1, 2}});
  sent.failure = "tired";
  const FinalEstimate read = ReadFinal(FinalMessage(sent));
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[1].stamp_ns, 9);
  EXPECT_EQ(read.frames[1].status, TrackingStatus::kLost);
  EXPECT_EQ(FindMap<LandmarkMap>(read.maps)->points[0].p_W, Eigen::Vector3d(1, 2, 1.0 / 3));
  const OccupancyGrid* grid = FindMap<OccupancyGrid>(read.maps);
  EXPECT_EQ(grid->cell_m, 0.05);
  EXPECT_EQ(cv::norm(grid->log_odds, std::get<OccupancyGrid>(sent.maps[1]).log_odds, cv::NORM_INF), 0);
  EXPECT_EQ(read.failure, "tired");
}

template <class Act>
std::string WhatIsSaid(Act act) {
  try {
    act();
  } catch (const BadInput& e) {
    return e.what();
  }
  return "nothing";
}

TEST(FrameProtocol, MalformedAnswersAreNamedInAFewWords) {
  const auto said = [](const std::string& line) { return WhatIsSaid([&] { ReadAnswer(line, 1); }); };
  EXPECT_EQ(said("hello"), "no JSON: hello");
  EXPECT_THAT(said("[]"), HasSubstr("expected an object with the key status"));
  EXPECT_THAT(said(R"({"status": "happy"})"), HasSubstr("status: expected initializing, tracking or lost"));
  EXPECT_THAT(said(R"({"status": "tracking"})"), HasSubstr("there is no pose"));
  EXPECT_THAT(said(R"({"status": "tracking", "pose": [1, 2, 3]})"), HasSubstr("pose: expected 7 finite numbers"));
  EXPECT_THAT(said(R"({"status": "tracking", "pose": [1, 2, 3, 0, 0, 0, 2]})"), HasSubstr("a unit quaternion"));
  EXPECT_THAT(said(R"({"status": "tracking", "pose": [1, 2, 3, 0, 0, 0, null]})"), HasSubstr("finite numbers"));
  EXPECT_THAT(said(R"({"status": "lost", "command": "jump"})"), HasSubstr("command: expected follow_path"));
  EXPECT_THAT(WhatIsSaid([] { ReadReady("{}"); }), HasSubstr("ready"));
  EXPECT_THAT(WhatIsSaid([] { ReadFinal(R"({"maps": [{"mesh": []}]})"); }), HasSubstr("landmarks or occupancy"));
  EXPECT_EQ(ReadReady(R"({"error": "no such ratio"})"), "no such ratio");
  EXPECT_EQ(ReadReady(R"({"ready": true})"), "");
}

TEST(FrameProtocol, AnAlmostUnitQuaternionIsMadeOne) {
  const FrameAnswer answer = ReadAnswer(R"({"status": "tracking", "pose": [0, 0, 0, 0, 0, 0, 1.0001]})", 1);
  EXPECT_DOUBLE_EQ(answer.frame.pose->rotation.norm(), 1);
}

}  // namespace
}  // namespace gaitcam
