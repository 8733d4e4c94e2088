#include "algorithms/odometry/stereo_vo.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/odometry/exposure_motion.h"
#include "algorithms/odometry/keypoint_noise.h"
#include "algorithms/odometry/stereo_pair_vo.h"
#include "tests/algorithms/odometry/odometry_trials.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

// A rig as a bench would describe it: 10 cm, the right camera turned, both lenses distorted.
Calibration Rig() {
  Calibration calibration = OneCamera();
  calibration.camera.k1 = -0.1;
  calibration.right = calibration.camera;
  calibration.X_LR = Pose(Eigen::Matrix3d(RotZ(0.01) * RotY(-0.01) * RotX(0.02)), {0.1, 0, 0});
  return calibration;
}

template <class PoseOfTime>
Film FilmStereo(int frames, PoseOfTime pose) {
  const Calibration rig = Rig();
  Film film = FilmPath(Room(), rig.camera, frames, pose, 5, 2);
  const Film right = FilmPath(
      Room(), *rig.right, frames, [&](double t) { return pose(t) * rig.X_LR; }, 5, 2);
  for (size_t i = 0; i < film.frames.size(); ++i) film.frames[i].right = right.frames[i].image;
  return film;
}

const Film& Sideways() {
  static const Film film = FilmStereo(30, SidewaysPose);
  return film;
}

// Small pictures have few points.
StereoVoOptions Small() {
  StereoVoOptions options;
  options.sensitivity = 4;
  return options;
}

struct TrackedTwice {
  Estimate live;
  std::vector<FrameEstimate> last_word;
};
const TrackedTwice& TrackedSideways() {
  static const TrackedTwice tracked = [] {
    StereoVo vo(Rig(), Small(), 1);
    TrackedTwice both{TrackAll(vo, Sideways().frames), {}};
    both.last_word = vo.Finish();
    return both;
  }();
  return tracked;
}

Pose TrueMotion(const Film& film, size_t from, size_t to) {
  return film.truth[from].pose.Inverse() * film.truth[to].pose;
}
Pose MotionOf(const std::vector<FrameEstimate>& frames, size_t from, size_t to) {
  return frames[from].pose->Inverse() * *frames[to].pose;
}

TEST(StereoVo, FollowsAMotionInMetres) {
  const Estimate& live = TrackedSideways().live;
  ExpectSane(live);
  const std::vector<FrameEstimate>& final_frames = TrackedSideways().last_word;
  ASSERT_EQ(final_frames.size(), Sideways().frames.size());
  EXPECT_EQ(Count(live, TrackingStatus::kTracking), 30);
  const size_t last = 29;  // 24 cm away; a pixel is 14 mm on the wall
  for (const auto& frames : {live.frames, final_frames}) {
    const Vector6d error = Minus(MotionOf(frames, 0, last), TrueMotion(Sideways(), 0, last));
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT(error.tail<3>().norm(), 0.004);
  }
}

TEST(StereoVo, EveryPoseHasACovarianceOfWhichItsOwnIsAPart) {
  for (const auto& frames : {TrackedSideways().live.frames, TrackedSideways().last_word}) {
    for (const FrameEstimate& frame : frames) {
      ASSERT_TRUE(frame.covariance && frame.own_covariance);
      EXPECT_LT(frame.covariance->norm(), 0.01) << "10 cm in a room of 4 m";
      for (const Matrix6d& part : {*frame.own_covariance, Matrix6d(*frame.covariance - *frame.own_covariance)}) {
        const double size = frame.covariance->norm();
        EXPECT_GE((part + 1e-9 * size * Matrix6d::Identity()).ldlt().vectorD().minCoeff(), 0);
      }
    }
  }
}

Matrix6d SharedOf(const FrameEstimate& frame) { return *frame.covariance - *frame.own_covariance; }

// With one keyframe alone all landmarks are as wrong as two images left them.
TEST(StereoVo, WhatFramesShareGrowsFromTheKeyframeOnAndNeverShrinks) {
  StereoVoOptions options = Small();
  options.policy.keyframe_displacement_px = 1000;
  options.policy.keyframe_turn_deg = 180;
  options.policy.keyframe_overlap = 0.05;
  StereoVo vo(Rig(), options, 1);
  const Estimate live = TrackAll(vo, Sideways().frames);
  ASSERT_EQ(vo.map().keyframes().size(), 1U);
  for (const auto& frames : {live.frames, vo.Finish()}) {
    for (size_t i = 1; i < frames.size(); ++i) {
      const Matrix6d now = SharedOf(frames[i]);
      const Matrix6d step = now - CarryCovariance(SharedOf(frames[i - 1]), MotionOf(frames, i - 1, i));
      EXPECT_GE((step + 1e-9 * now.norm() * Matrix6d::Identity()).ldlt().vectorD().minCoeff(), 0);
    }
    EXPECT_GT(SharedOf(frames[29]).norm(), 4 * SharedOf(frames[5]).norm()) << "after 20 and 4 cm";
    const Matrix6d whole = SharedOf(frames[29]) + *frames[0].own_covariance + *frames[29].own_covariance;
    const Vector6d error = Minus(TrueMotion(Sideways(), 0, 29), MotionOf(frames, 0, 29));
    EXPECT_LT(error.dot(whole.llt().solve(error)) / 6, 3) << "the 99.9 % point of chi square with 6 is 22.5: 3.7";
    EXPECT_GT(error.dot((*frames[29].own_covariance).llt().solve(error)) / 6, 3) << "without it, it would be too sure";
  }
}

/// Of the motions between neighbouring frames, per dimension, mean.
double NeesFrameToFrame(const std::vector<FrameEstimate>& frames, const Film& film) {
  double nees = 0;
  for (size_t i = 1; i < frames.size(); ++i) {
    const Pose motion = MotionOf(frames, i - 1, i);
    const Matrix6d earlier = *frames[i - 1].covariance - 2 * *frames[i - 1].own_covariance;
    const Matrix6d covariance = *frames[i].covariance - CarryCovariance(earlier, motion);
    const Vector6d error = Minus(TrueMotion(film, i - 1, i), motion);
    nees += error.dot(covariance.llt().solve(error)) / 6 / double(frames.size() - 1);
  }
  return nees;
}

// Errors of neighbouring frames hang together, so that 29 motions are no 174 numbers: within a factor of four.
TEST(StereoVo, TheMotionFromFrameToFrameIsAsWrongAsItSays) {
  const double nees = NeesFrameToFrame(TrackedSideways().last_word, Sideways());
  EXPECT_GT(nees, 0.25);
  EXPECT_LT(nees, 4);
}

TEST(StereoVo, DoesNotDriftWhereTheRobotStands) {
  const Film film = FilmStereo(25, [](double) { return SidewaysPose(0); });
  StereoVo vo(Rig(), Small(), 1);
  const Estimate estimate = TrackAll(vo, film.frames);
  ASSERT_EQ(Count(estimate, TrackingStatus::kTracking), 25);
  const std::vector<FrameEstimate> frames = vo.Finish();
  EXPECT_LT(Minus(*frames.back().pose, *frames[1].pose).norm(), 0.003);
  EXPECT_EQ(vo.map().keyframes().size(), 1U);
  constexpr double kLittle_m = 0.001;  // frames use other ones of the landmarks each
  EXPECT_LT(std::sqrt(SharedOf(frames.back()).topLeftCorner<3, 3>().trace()), kLittle_m);
}

TEST(StereoVo, TheSameSeedGivesTheSameBits) {
  StereoVo a(Rig(), Small(), 5), b(Rig(), Small(), 5);
  const std::vector<Observation> frames(Sideways().frames.begin(), Sideways().frames.begin() + 8);
  ExpectSameBits(TrackAll(a, frames), TrackAll(b, frames));
}

// Told 0.1 degrees wrong, of which a bench has half: a third of a pixel here.
TEST(StereoVo, LearnsHowTheRightCameraStands) {
  Calibration told = Rig();
  told.X_LR.rotation = told.X_LR.rotation * ExpSo3(kRadPerDeg * Eigen::Vector3d(0.1, 0, 0.05));
  StereoVoOptions options = Small();
  options.rig_rotation_deg = 0.1;
  StereoVo vo(told, options, 1);
  TrackAll(vo, Sideways().frames);
  const double before = RotationAngle(told.X_LR.rotation, Rig().X_LR.rotation);
  EXPECT_LT(RotationAngle(vo.X_LR().rotation, Rig().X_LR.rotation), 0.3 * before);
}

TEST(StereoVo, AFrameWithoutItsPairIsLostAndTheNextOneIsNot) {
  std::vector<Observation> frames(Sideways().frames.begin(), Sideways().frames.begin() + 8);
  frames[3].right.reset();
  frames[5].right->stamp_ns += 5'000'000;
  StereoVo vo(Rig(), Small(), 1);
  const Estimate estimate = TrackAll(vo, frames);
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool is_pair = i != 3 && i != 5;
    EXPECT_EQ(estimate.frames[i].status, is_pair ? TrackingStatus::kTracking : TrackingStatus::kLost) << i;
  }
  EXPECT_TRUE(estimate.frames[3].predicted);
}

TEST(StereoVo, BlackFramesAreLostAndTheMapBeginsAnewAfterMany) {
  StereoVoOptions options = Small();
  options.max_lost_frames = 3;
  StereoVo vo(Rig(), options, 1);
  std::vector<Observation> frames(Sideways().frames.begin(), Sideways().frames.begin() + 12);
  for (size_t i = 4; i < 9; ++i) {
    frames[i] = Filled(frames[i], 0);
    frames[i].right->pixels = frames[i].image.pixels;
  }
  const Estimate estimate = TrackAll(vo, frames);
  for (size_t i = 4; i < 9; ++i) EXPECT_EQ(estimate.frames[i].status, TrackingStatus::kLost) << i;
  EXPECT_TRUE(estimate.frames[9].restarted);
  EXPECT_EQ(estimate.frames[11].status, TrackingStatus::kTracking);
}

// Around where an IMU predicts them, landmarks find features of any picture: without a ratio test nearly all do, and of
// a detector that errs by 1.5 px a quarter of these fit.
TEST(StereoVo, APictureOfSomethingElseGivesNoPoseWhereAnImuPredictsOne) {
  Calibration rig = Rig();
  rig.imu.rate_hz = 100;
  std::vector<Observation> frames = FilmStereo(10, [](double) { return SidewaysPose(0); }).frames;
  for (Observation& frame : frames) {
    for (int i = -5; i <= 5; ++i) {
      frame.imu.push_back({frame.stamp_ns + 10'000'000 * i, Eigen::Vector3d::Zero(), {0, -9.81, 0}});
    }
  }
  for (const size_t i : {5, 6}) {
    for (cv::Mat* image : {&frames[i].image.pixels, &frames[i].right->pixels}) cv::flip(image->clone(), *image, 0);
  }
  StereoVoOptions options = Small();
  options.ratio = 1;
  options.noise.sigma_px = 1.5;
  StereoVo vo(rig, options, 1);
  const Estimate estimate = TrackAll(vo, frames);
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool is_strange = i == 5 || i == 6;
    EXPECT_EQ(estimate.frames[i].status, is_strange ? TrackingStatus::kLost : TrackingStatus::kTracking) << i;
  }
}

TEST(StereoVo, WhatCannotBeAPairIsRefusedInOneLine) {
  const Observation& good = Sideways().frames[0];
  const auto first = [&](const Observation& frame) {
    return ErrorOf<BadInput>([&] { StereoVo(Rig(), Small(), 1).Track(frame); });
  };
  Observation bad = good;
  bad.right.reset();
  EXPECT_EQ(first(bad), "the first frame: there is no right image");
  bad = good;
  bad.right->stamp_ns += 2'000'000;
  EXPECT_THAT(first(bad), testing::HasSubstr("the right image's stamp is 2000000 ns after the left one's"));
  bad = good;
  bad.right->pixels = cv::Mat(90, 120, CV_8UC1, cv::Scalar(0));
  EXPECT_EQ(first(bad), "the right image has 120 x 90 pixels, but the calibration says 240 x 180");
  bad = good;
  std::swap(bad.image.pixels, bad.right->pixels);
  EXPECT_THAT(first(bad), testing::HasSubstr("left and right images are swapped"));
}

TEST(StereoVo, ARigThatSeesNothingInCommonIsRefused) {
  Calibration rig = Rig();
  rig.X_LR.rotation = Eigen::Quaterniond(RotY(2));
  EXPECT_THROW(StereoVo(rig, Small(), 1), BadInput);
  rig.right.reset();
  EXPECT_THROW(StereoVo(rig, Small(), 1), BadInput);
}

TEST(StereoPairVo, FollowsAMotionInMetresAndItsCovarianceGrows) {
  StereoPairVoOptions options;
  options.sensitivity = 4;
  options.threshold_m = 0.1;  // pixels are 14 mm on the wall, and depths ten times as uncertain
  StereoPairVo vo(Rig(), options, 1);
  const std::vector<Observation> frames(Sideways().frames.begin(), Sideways().frames.begin() + 10);
  const Estimate estimate = TrackAll(vo, frames);
  EXPECT_EQ(Count(estimate, TrackingStatus::kTracking), 10);
  const Vector6d error = Minus(MotionOf(estimate.frames, 0, 9), TrueMotion(Sideways(), 0, 9));
  EXPECT_LT(error.head<3>().norm(), 0.15);
  for (size_t i = 1; i < frames.size(); ++i) {
    EXPECT_GT(estimate.frames[i].covariance->trace(), estimate.frames[i - 1].covariance->trace());
  }
}

std::vector<Pose> Turn(const std::vector<double>& yaws) {
  std::vector<Pose> path;
  for (const double yaw : yaws) path.push_back(Pose(Eigen::Matrix3d(RotY(yaw)), {0, 0, 0}));
  return path;
}

TEST(KeypointNoise, BlurOffsetIsTheMeanForCoarsePointsAndWhereTheImageLingeredForFineOnes) {
  const Eigen::Vector2d centre(119.5, 89.5);
  const double f = kCamera.fx;
  const auto steady = Turn({-0.04, -0.02, 0, 0.02, 0.04});
  EXPECT_LT(BlurOffset(kCamera, steady, centre, 0, 100).norm(), 1e-3) << "a steady turn has its mean in the middle";
  const auto lingering = Turn({0.04, 0.04, 0.04, 0, -0.04});
  EXPECT_NEAR(BlurOffset(kCamera, lingering, centre, 0, 1000).x(), f * 0.016, 0.02);  // tan(x) is x to 1e-4 rad here
  EXPECT_NEAR(BlurOffset(kCamera, lingering, centre, 0, 0.5).x(), f * 0.04, 0.02);
  EXPECT_EQ(BlurOffset(kCamera, {}, centre, 0, 1), Eigen::Vector2d(0, 0));
}

TEST(KeypointNoise, ACameraThatMovesSmearsWhatIsNear) {
  const Eigen::Vector2d centre(119.5, 89.5);
  std::vector<Pose> path(3);
  path[0].translation.x() = -0.01;
  path[1].translation.x() = path[2].translation.x() = 0.02;
  EXPECT_EQ(BlurSpread(kCamera, path, centre, 0), Eigen::Matrix2d(Eigen::Matrix2d::Zero())) << "infinitely far";
  const double a = kCamera.fx * 0.01 / 0.5;  // of 10 mm at half a metre
  EXPECT_NEAR(BlurOffset(kCamera, path, centre, 1 / 0.5, 1000).x(), a, 0.01);
  EXPECT_NEAR(BlurSpread(kCamera, path, centre, 1 / 0.5)(0, 0), (4 + 1 + 1) * a * a / 3, 0.01);
}

TEST(KeypointNoise, PointsOfASharpImageRepeatTheirErrorsAndThoseOfABlurredOneDoNot) {
  const KeypointNoiseOptions options;
  const std::vector<cv::KeyPoint> points(5, cv::KeyPoint({50, 50}, 3));
  const auto count = [&](const std::vector<Pose>& path) {
    const Eigen::Matrix2d spread = BlurSpread(kCamera, path, {50, 50}, 0);
    const Eigen::Matrix2d covariance = KeypointCovariance(points[0], spread, Eigen::Matrix2d::Zero(), options);
    return PointsPerError(points, std::vector<Eigen::Matrix2d>(5, covariance), options);
  };
  EXPECT_NEAR(count({}), options.points_per_error, 1e-9);
  const double blurred = count(Turn({-0.04, -0.02, 0, 0.02, 0.04}));
  EXPECT_GE(blurred, options.points_per_blur_error);
  EXPECT_LT(blurred, 0.25 * options.points_per_error);
}

TEST(RowOffset, APointIsPutWhereItWasAtTheStamp) {
  const CameraModel camera = *Rig().right;
  const auto motion = [](double t_s) {  // X_TM, M at the stamp
    return Pose(ExpSo3(t_s * Eigen::Vector3d(1.0, -2.0, 0.5)), t_s * Eigen::Vector3d(0.2, -0.3, 0.1));
  };
  std::vector<Pose> readout;
  for (int i = 0; i <= 16; ++i) readout.push_back(motion(1e-3 * kRollsFor_ms * (i / 16.0 - 0.5)));
  for (const double depth_m : {0.5, 2.0, 50.0}) {
    for (const Eigen::Vector2d& at_stamp : {Eigen::Vector2d(30, 20), {120, 90}, {200, 165}}) {
      const Eigen::Vector3d p = depth_m * camera.Unproject(at_stamp);
      Eigen::Vector2d seen = at_stamp;
      for (int k = 0; k < 10; ++k) {  // the row that sees it
        seen = *camera.Project(motion(1e-3 * kRollsFor_ms * (seen.y() / (camera.height_px - 1) - 0.5)) * p);
      }
      const Eigen::Vector2d found = seen - RowOffset(camera, readout, seen, 1 / depth_m);
      EXPECT_LT((found - at_stamp).norm(), 0.02) << "it moved by " << (seen - at_stamp).norm();
    }
  }
  EXPECT_EQ(RowOffset(camera, {}, {30, 20}, 1), Eigen::Vector2d(0, 0)) << "nothing rolls";
}

/// Of both cameras.
Film RollingStereoFilm(int frames) {
  const Calibration rig = Rig();
  Film film = RollingFilm(rig.camera, frames);
  const Film right = RollingFilm(*rig.right, frames, rig.X_LR);
  for (size_t i = 0; i < film.frames.size(); ++i) film.frames[i].right = right.frames[i].image;
  return film;
}

TEST(StereoVo, TheImuUndoesARollingShutter) {
  const Film film = RollingStereoFilm(40);
  double rmse_m[2];
  for (const bool by_imu : {false, true}) {
    StereoVoOptions options = Small();
    options.shutter_by_imu = by_imu;
    StereoVo vo(Rolling(Rig()), options, 1);
    TrackAll(vo, film.frames);
    Estimate final_estimate;
    final_estimate.frames = vo.Finish();
    EXPECT_EQ(Count(final_estimate, TrackingStatus::kTracking), 40);
    rmse_m[by_imu] = AlignedError(final_estimate, film.truth).rmse_m;
  }
  EXPECT_LT(rmse_m[true], 0.5 * rmse_m[false]) << rmse_m[true] << " and " << rmse_m[false];
}

// A bench knows a gyroscope's clock to 2 ms, one standard deviation; this one is 4 ms late.
TEST(StereoVo, KnowsHowWrongAShutterIsUndone) {
  Film film = RollingStereoFilm(30);
  for (Observation& frame : film.frames) {
    for (ImuSample& sample : frame.imu) sample.stamp_ns += 4'000'000;
  }
  StereoVo vo(Rolling(Rig()), Small(), 1);
  TrackAll(vo, film.frames);
  const double nees = NeesFrameToFrame(vo.Finish(), film);
  EXPECT_GT(nees, 0.25);
  EXPECT_LT(nees, 4);
}

CameraFeatures TwoFeatures(const CameraModel& camera) {
  CameraFeatures features;
  for (const float y : {0.f, float(camera.height_px - 1)}) features.features.keypoints.emplace_back(120.f, y, 4.f);
  features.pixel.resize(2);
  features.xy.resize(2);
  features.noise_px.assign(2, Eigen::Matrix2d::Zero());
  return features;
}

TEST(UndoMotion, APointIsSmearedAsTheCameraMovedWhileItsOwnRowWasOpen) {
  const CameraModel camera = Rig().camera;
  const std::vector<Pose> still(5), turning = Turn({-0.04, -0.04, 0, 0.01, 0.01});
  CameraFeatures first = TwoFeatures(camera), last = first, all = first;
  UndoMotion(camera, {{turning, still}, {}}, {}, {}, first);
  UndoMotion(camera, {{still, turning}, {}}, {}, {}, last);
  UndoMotion(camera, {{turning}, {}}, {}, {}, all);
  EXPECT_EQ(first.pixel[1], Eigen::Vector2d(120, camera.height_px - 1));
  EXPECT_GT(std::abs(first.pixel[0].x() - 120), 1);
  EXPECT_EQ(first.pixel[0], all.pixel[0]);
  EXPECT_EQ(last.pixel[1], all.pixel[1]);
  EXPECT_GT(first.covariance_px[0](0, 0), 2 * first.covariance_px[1](0, 0));
}

TEST(StereoView, AFeatureWithoutAPartnerIsAsFarAsTheNearestThatHasOne) {
  const StereoRig rig = StereoRig::Of(Rig());
  const auto detector = MakeFeature2d("sift", 4);
  StereoView view = DetectInBoth(Sideways().frames[0], rig, *detector, 500);
  UndoMotion(rig.left, {}, {}, {}, view.left);
  UndoMotion(rig.right, {}, {}, {}, view.right);
  view.partner.assign(view.left.size(), -1);
  EXPECT_TRUE(InverseDepths(rig, view).empty());
  view.partner = MatchStereo(rig, view.left, view.right, {});
  const std::vector<double> inverse_depths = InverseDepths(rig, view);
  ASSERT_EQ(inverse_depths.size(), view.left.size());
  int alone = 0;
  for (size_t i = 0; i < view.left.size(); ++i) {
    if (view.partner[i] >= 0) {
      EXPECT_NEAR(inverse_depths[i], 1 / ReconstructPoint(rig, view.Sighting(i)).p_L.z(), 1e-12);
      continue;
    }
    ++alone;
    const auto like = [&](size_t k) { return view.partner[k] >= 0 && inverse_depths[k] == inverse_depths[i]; };
    double nearest = 1e9, taken = 1e9;
    for (size_t k = 0; k < view.left.size(); ++k) {
      const double distance = (view.left.pixel[k] - view.left.pixel[i]).norm();
      if (view.partner[k] >= 0) nearest = std::min(nearest, distance);
      if (like(k)) taken = std::min(taken, distance);
    }
    EXPECT_EQ(taken, nearest) << i;
  }
  EXPECT_GT(alone, 10);
}

TEST(KeypointNoise, GrowsAlongTheBlurAndWithTheScale) {
  const KeypointNoiseOptions options;
  const Eigen::Matrix2d kNone = Eigen::Matrix2d::Zero();
  cv::KeyPoint small({50, 50}, 2), large({50, 50}, 20);
  const Eigen::Matrix2d sharp = KeypointCovariance(small, kNone, kNone, options);
  EXPECT_EQ(sharp(0, 0), sharp(1, 1));
  EXPECT_GT(KeypointCovariance(large, kNone, kNone, options)(0, 0), sharp(0, 0));
  const auto turn = Turn({-0.04, -0.02, 0, 0.02, 0.04});
  const Eigen::Matrix2d spread = BlurSpread(kCamera, turn, {119.5, 89.5}, 0);
  EXPECT_NEAR(spread(0, 0), std::pow(kCamera.fx, 2) * 8e-4, 0.2) << "the mean square of the turn";
  const Eigen::Matrix2d blurred = KeypointCovariance(small, spread, kNone, options);
  EXPECT_GT(blurred(0, 0), 2 * blurred(1, 1));
}

/// Told of a pose at 0 s and of a frame at 0.1 s, while the gyroscope read `rate` about y, and of that much more at the
/// end than at the start.
ExposureMotion TurnedBy(double rate, double more, bool use_imu) {
  ExposureMotion motion({100, 0, 0, 0, 0, Pose()}, use_imu);
  Observation first, frame;
  frame.stamp_ns = 100'000'000;
  for (int i = -2; i <= 12; ++i) {
    frame.imu.push_back({10'000'000 * i, {0, rate + more * i / 10.0, 0}, Eigen::Vector3d::Zero()});
  }
  motion.Add(first);
  motion.AddPose(0, Pose());
  motion.Add(frame);
  return motion;
}

TEST(ExposureMotion, TheGyroscopesTurnIsAsExactAsABenchCalibratesIt) {
  const double standing = TurnedBy(0, 0, true).TurnSigma();
  EXPECT_NEAR(standing, 0.01 * 0.1, 1e-9) << "the bias of 0.1 s";
  EXPECT_NEAR(TurnedBy(1, 0, true).TurnSigma(), std::hypot(standing, 0.1 * 0.5 * kRadPerDeg), 1e-9) << "misaligned";
  const double jerked = TurnedBy(-0.5, 1, true).TurnSigma();  // no turn in all
  EXPECT_NEAR(jerked, std::hypot(standing, 1 * 2e-3), 0.05 * jerked) << "2 ms late";
  EXPECT_NEAR(TurnedBy(0, 0, false).TurnSigma(), 2 * 0.1, 1e-9) << "no gyroscope: as fast as a head turns";
}

TEST(ExposureMotion, TheRateWhileAShutterRollsIsAsExactAsABenchCalibratesIt) {
  const double misaligned = std::pow(0.5 * kRadPerDeg, 2), late = std::pow(2e-3 * 3 / 0.1, 2);
  const Eigen::Matrix3d across = Eigen::Vector3d(1, 0, 1).asDiagonal(), along = Eigen::Vector3d(0, 1, 0).asDiagonal();
  const auto off = [](const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) { return (a - b).norm() / b.norm(); };
  EXPECT_LT(off(TurnedBy(1, 0, true).RateCovariance(20), misaligned * across), 1e-9);
  const double rate = 3;  // at the stamp
  EXPECT_LT(off(TurnedBy(0, 3, true).RateCovariance(20), misaligned * rate * rate * across + late * along), 1e-9);
  EXPECT_TRUE(TurnedBy(1, 0, true).RateCovariance(0).isZero(0)) << "nothing rolls";
  EXPECT_TRUE(TurnedBy(1, 0, false).RateCovariance(20).isZero(0)) << "nothing was undone";
}

/// A head that starts from rest, sways, nods and advances; the IMU is a trunk below it.
class SwayingHead {
 public:
  SwayingHead() {
    imu_ = {250, 0, 0, 0, 0, Pose(Eigen::Matrix3d(RotX(0.3) * RotZ(0.2)), {0.01, 0.13, -0.02})};
    for (int64_t t = 0; t < 2'500'000'000; t += 4'000'000) readings_.push_back(Reading(t));
  }

  const ImuCalibration& imu() const { return imu_; }
  Pose At(int64_t ns) const {
    const double t = 1e-9 * double(ns) - 0.3, w = 2 * M_PI / 0.6;
    const double a = t > 0 ? 1 - std::exp(-std::pow(t / 0.3, 4)) : 0;  // begins smoothly
    const Eigen::Vector3d turn(0.1 * std::sin(w * t), 0.04 * std::cos(2 * w * t), 0.05 * std::sin(w * t + 1));
    return Pose(ExpSo3(a * turn), a * Eigen::Vector3d(0.03 * std::sin(w * t), 0.01 * std::cos(2 * w * t), 0.1 * t));
  }
  /// A frame of 30 ms, with the readings since the frame before.
  Observation Frame(int64_t stamp_ns, bool has_imu) {
    Observation frame;
    frame.stamp_ns = stamp_ns;
    frame.exposure_ms = 30;
    while (has_imu && next_ < readings_.size() && readings_[next_].stamp_ns < stamp_ns + 20'000'000) {
      frame.imu.push_back(readings_[next_++]);
    }
    return frame;
  }

 private:
  ImuSample Reading(int64_t ns) const {
    constexpr int64_t kStep_ns = 500'000;
    constexpr double kStep_s = 5e-4;
    const auto at = [&](int64_t t) { return At(t) * imu_.X_CI; };
    const Pose before = at(ns - kStep_ns), now = at(ns), after = at(ns + kStep_ns);
    const Eigen::Vector3d acceleration =
        (before.translation - 2 * now.translation + after.translation) / (kStep_s * kStep_s);
    const Eigen::Vector3d up(0, -9.81, 0);  // y is down
    return {ns, LogSo3(before.rotation.conjugate() * after.rotation) / (2 * kStep_s),
            now.rotation.conjugate() * (acceleration + up)};
  }

  ImuCalibration imu_;
  std::vector<ImuSample> readings_;
  size_t next_ = 0;
};

struct PathErrors {
  double path_m = 0, path_rad = 0, prediction_m = 0;  ///< The largest.
  double moved_m = 0;                                 ///< The most, over half an exposure.
  double path2 = 0, moved2 = 0;                       ///< Sums of squares.
};
PathErrors FollowSwayingHead(bool has_imu) {
  SwayingHead head;
  ExposureMotion motion(has_imu ? head.imu() : ImuCalibration{}, true);
  PathErrors errors;
  for (int64_t t = 100'000'000; t < 2'400'000'000; t += 33'333'333) {
    motion.Add(head.Frame(t, has_imu));
    const std::vector<Pose> path = motion.Path();
    if (t > 200'000'000) {
      const Pose X_TM = head.At(t + 15'000'000).Inverse() * head.At(t);
      const Vector6d error = Minus(path.back(), X_TM);
      errors.path_m = std::max(errors.path_m, error.head<3>().norm());
      errors.path_rad = std::max(errors.path_rad, error.tail<3>().norm());
      errors.moved_m = std::max(errors.moved_m, X_TM.translation.norm());
      errors.path2 += error.head<3>().squaredNorm();
      errors.moved2 += X_TM.translation.squaredNorm();
      errors.prediction_m =
          std::max(errors.prediction_m, (motion.PredictPose().translation - head.At(t).translation).norm());
    }
    motion.AddPose(t, head.At(t));
  }
  return errors;
}

// The mean force is gravity's but for what the head gained in speed over the time, 0.3 m/s in 1 s: as a steady error,
// 4 frames of it at a gain of a quarter, 0.04 m/s or 0.6 mm in half an exposure.
TEST(ExposureMotion, TheCamerasPathIsThatOfAnImuBelowIt) {
  const PathErrors errors = FollowSwayingHead(true);
  EXPECT_GT(errors.moved_m, 0.005);
  EXPECT_LT(errors.path_m, 0.001);
  EXPECT_LT(errors.path_rad, 0.001);
  EXPECT_LT(errors.prediction_m, 0.002) << "a frame further";
}

// Exposures of 30 ms, from the first row's to the last row's 20 ms. A gyroscope's samples are 4 ms apart.
TEST(ExposureMotion, EveryRowHasTheExposureOfItsOwnTime) {
  SwayingHead head;
  ExposureMotion motion(head.imu(), true);
  double error_rad = 0, as_the_middle_rad = 0;
  for (int64_t t = 100'000'000; t < 1'400'000'000; t += 33'333'333) {
    motion.Add(head.Frame(t, true));
    const std::vector<std::vector<Pose>> paths = motion.PathsOfRows(20);
    ASSERT_EQ(paths.size(), 17u);
    for (const size_t row : {0u, 4u, 8u, 12u, 16u}) {
      const int64_t middle_ns = t + int64_t(20'000'000 * (double(row) / 16 - 0.5));
      const Pose X_TM = head.At(middle_ns - 15'000'000).Inverse() * head.At(middle_ns);
      error_rad = std::max(error_rad, RotationAngle(paths[row].front().rotation, X_TM.rotation));
      as_the_middle_rad = std::max(as_the_middle_rad, RotationAngle(paths[8].front().rotation, X_TM.rotation));
    }
    motion.AddPose(t, head.At(t));
  }
  EXPECT_LT(error_rad, 0.2 * as_the_middle_rad) << "of " << as_the_middle_rad;
  EXPECT_GT(as_the_middle_rad, 0.003);
}

TEST(ExposureMotion, WithoutImuTheCameraGoesOnAsItWent) {
  const PathErrors errors = FollowSwayingHead(false), with_imu = FollowSwayingHead(true);
  EXPECT_LT(errors.path2, 0.7 * errors.moved2) << "better than to stand still";
  EXPECT_GT(errors.path2, 9 * with_imu.path2) << "it is late by a frame and a half";
}

/// A vertical edge of `contrast` grey levels, 4 px wide, with noise.
cv::Mat NoisyEdge(double contrast, double noise) {
  RandomStream random(1, "edge");
  cv::Mat image(180, 240, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double edge = std::clamp((x - 118) / 4.0, 0.0, 1.0);
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(120 + contrast * (edge - 0.5) + random.Normal(0, noise));
    }
  }
  return image;
}

TEST(KeypointNoise, TheNoiseOfAnImageIsMeasured) {
  for (const double noise : {2.0, 5.0, 12.0}) {
    EXPECT_NEAR(ImageNoise(NoisyEdge(0, noise)), noise, 0.03 * noise);  // 43,200 pixels; rounding adds 0.08 at most
  }
  EXPECT_EQ(ImageNoise(cv::Mat(2, 2, CV_8UC1, cv::Scalar(7))), 0);
}

TEST(KeypointNoise, TheBoundIsThatOfAnEdge) {
  const cv::KeyPoint on_edge({120, 90}, 12), in_nothing({40, 90}, 12);  // 13 x 13 pixels
  const Eigen::Matrix2d bound = NoiseBound(NoisyEdge(80, 2), on_edge, 2);
  const double information = 13 * 3.5 * 20 * 20;  // 13 rows, 20 levels a pixel at 3 of them, half that at both ends
  EXPECT_NEAR(bound(0, 0), 4 / information, 0.1 * 4 / information);
  EXPECT_GT(bound(1, 1), 100 * bound(0, 0)) << "along the edge";
  const Eigen::Matrix2d nothing = NoiseBound(NoisyEdge(80, 2), in_nothing, 2);
  EXPECT_NEAR(nothing(0, 0), 1 / (0.05 * 169), 0.5 / (0.05 * 169)) << "bounded";
  EXPECT_GT(nothing(0, 0), 100 * bound(0, 0));
  EXPECT_EQ(NoiseBound(NoisyEdge(80, 2), on_edge, 0), Eigen::Matrix2d(Eigen::Matrix2d::Zero()));
}

}  // namespace
}  // namespace gaitcam
