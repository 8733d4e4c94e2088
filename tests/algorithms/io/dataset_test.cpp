#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/dataset_reader.h"
#include "algorithms/io/dataset_writer.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"
#include "tests/algorithms/io/file_test.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

constexpr int kWidth = 32, kHeight = 24;

CameraModel OddCamera(double offset) {
  CameraModel camera = CameraModel::FromHorizontalFov(kWidth, kHeight, 60 + offset);
  camera.cx += M_PI * offset;
  camera.k1 = -0.1 / 3;
  camera.p2 = 1e-4 / 7;
  camera.k3 = offset / 9;
  return camera;
}

// Every number has all its digits, so that a rounding anywhere shows.
Calibration FullCalibration() {
  Calibration calibration;
  calibration.camera = OddCamera(0);
  calibration.right = OddCamera(1);
  calibration.X_LR = Pose(Eigen::Quaterniond(1, 0.1, -0.2, 0.3), {1.0 / 7, -0.001 / 3, 1e-5});
  calibration.has_depth = true;
  calibration.frame_rate_hz = 30.1 / 3;
  calibration.readout_ms = 25.0 / 7;
  calibration.imu = {200.0 / 3, 1.7e-4 / 3, 2e-5 / 7,
                     2e-3 / 3,  3e-3 / 7,   Pose(Eigen::Quaterniond(0.3, 0.1, -0.2, 1), {0.1 / 3, 0.2 / 7, -0.3})};
  calibration.depth = {0.001 / 3, 0.003 / 7};
  calibration.odometry = {50.0 / 3, Pose(Eigen::Quaterniond(0.2, 0.1, -0.2, 1), {0.1 / 7, 0.2 / 3, 1}), 0.03 / 7,
                          0.01 / 3, 0.1 / 7};
  return calibration;
}

Calibration MonoCalibration() {
  Calibration calibration;
  calibration.camera = OddCamera(0);
  calibration.frame_rate_hz = 30;
  return calibration;
}

cv::Mat RandomImage(RandomStream& random, int type) {
  cv::Mat image(kHeight, kWidth, type);
  for (int i = 0; i < int(image.total() * image.elemSize()); ++i) image.data[i] = uchar(random.Index(256));
  return image;
}

cv::Mat RandomDepth(RandomStream& random, double farthest) {
  cv::Mat depth(kHeight, kWidth, CV_32FC1);
  for (float& z : cv::Mat_<float>(depth)) z = random.Uniform() < 0.1 ? 0.f : float(random.Uniform(0.1, farthest));
  return depth;
}

std::vector<Observation> SomeObservations(const Calibration& calibration, int count, int type = CV_8UC3) {
  RandomStream random(5, "dataset_test");
  std::vector<Observation> observations;
  for (int k = 0; k < count; ++k) {
    Observation o;
    o.stamp_ns = 1'403'636'579'763'555'584 + int64_t(k) * 33'333'333;
    o.exposure_ms = 20.0 / 3 + k;
    o.image = {o.stamp_ns, RandomImage(random, type)};
    if (calibration.right) o.right = Image{o.stamp_ns, RandomImage(random, type)};
    if (calibration.has_depth) o.depth = Image{o.stamp_ns, RandomDepth(random, 20)};
    for (int i = 0; calibration.imu.rate_hz > 0 && i < 3 + k % 2; ++i) {
      // The last sample lies after the shutter's close: only the recorded counts say that it belongs to this frame.
      o.imu.push_back({o.stamp_ns + (i - 1) * 7'000'000,
                       {random.Normal(), random.Normal(), 1e-9 * random.Normal()},
                       {random.Normal(), 9.81, random.Normal()}});
      o.joints.push_back({o.imu.back().stamp_ns + 1, {random.Normal(), random.Normal()}, i == 0, k % 2 == 0});
    }
    for (int i = 0; calibration.odometry.rate_hz > 0 && i < 1 + k % 3; ++i)
      o.odometry.push_back({o.stamp_ns + (i - 1) * 5'000'000, {random.Normal(), random.Normal()}, random.Normal()});
    observations.push_back(o);
  }
  return observations;
}

bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

void ExpectSame(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
}

void ExpectSame(const CameraModel& a, const CameraModel& b) {
  EXPECT_EQ(a.width_px, b.width_px);
  EXPECT_EQ(a.height_px, b.height_px);
  EXPECT_EQ((std::vector{a.fx, a.fy, a.cx, a.cy, a.k1, a.k2, a.p1, a.p2, a.k3}),
            (std::vector{b.fx, b.fy, b.cx, b.cy, b.k1, b.k2, b.p1, b.p2, b.k3}));
}

void ExpectSame(const Calibration& a, const Calibration& b) {
  ExpectSame(a.camera, b.camera);
  ASSERT_EQ(a.right.has_value(), b.right.has_value());
  if (a.right) ExpectSame(*a.right, *b.right);
  ExpectSame(a.X_LR, b.X_LR);
  EXPECT_EQ(a.has_depth, b.has_depth);
  EXPECT_EQ(a.frame_rate_hz, b.frame_rate_hz);
  EXPECT_EQ(a.readout_ms, b.readout_ms);
  EXPECT_EQ(a.imu.rate_hz, b.imu.rate_hz);
  EXPECT_EQ(a.imu.gyro_noise_density, b.imu.gyro_noise_density);
  EXPECT_EQ(a.imu.gyro_random_walk, b.imu.gyro_random_walk);
  EXPECT_EQ(a.imu.accel_noise_density, b.imu.accel_noise_density);
  EXPECT_EQ(a.imu.accel_random_walk, b.imu.accel_random_walk);
  ExpectSame(a.imu.X_CI, b.imu.X_CI);
  EXPECT_EQ(a.depth.sigma_m, b.depth.sigma_m);
  EXPECT_EQ(a.depth.sigma_per_m, b.depth.sigma_per_m);
  EXPECT_EQ(a.odometry.rate_hz, b.odometry.rate_hz);
  ExpectSame(a.odometry.X_BC, b.odometry.X_BC);
  EXPECT_EQ(a.odometry.position_per_sqrt_m, b.odometry.position_per_sqrt_m);
  EXPECT_EQ(a.odometry.heading_per_sqrt_m, b.odometry.heading_per_sqrt_m);
  EXPECT_EQ(a.odometry.heading_per_sqrt_rad, b.odometry.heading_per_sqrt_rad);
  EXPECT_EQ(a.odometry.rocking_m, b.odometry.rocking_m);
  EXPECT_EQ(a.odometry.rocking_rad, b.odometry.rocking_rad);
}

void ExpectSame(const Observation& a, const Observation& b) {
  EXPECT_EQ(a.stamp_ns, b.stamp_ns);
  EXPECT_EQ(a.exposure_ms, b.exposure_ms);
  EXPECT_EQ(a.image.stamp_ns, b.image.stamp_ns);
  EXPECT_TRUE(SameBits(a.image.pixels, b.image.pixels));
  ASSERT_EQ(a.right.has_value(), b.right.has_value());
  if (a.right) {
    EXPECT_TRUE(SameBits(a.right->pixels, b.right->pixels));
  }
  ASSERT_EQ(a.depth.has_value(), b.depth.has_value());
  if (a.depth) {
    EXPECT_TRUE(SameBits(a.depth->pixels, b.depth->pixels));
  }
  ASSERT_EQ(a.imu.size(), b.imu.size());
  for (size_t i = 0; i < a.imu.size(); ++i) {
    EXPECT_EQ(a.imu[i].stamp_ns, b.imu[i].stamp_ns);
    EXPECT_EQ(a.imu[i].angular_rate, b.imu[i].angular_rate);
    EXPECT_EQ(a.imu[i].specific_force, b.imu[i].specific_force);
  }
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].stamp_ns, b.joints[i].stamp_ns);
    EXPECT_EQ(a.joints[i].position, b.joints[i].position);
    EXPECT_EQ(a.joints[i].left_contact, b.joints[i].left_contact);
    EXPECT_EQ(a.joints[i].right_contact, b.joints[i].right_contact);
  }
  ASSERT_EQ(a.odometry.size(), b.odometry.size());
  for (size_t i = 0; i < a.odometry.size(); ++i) {
    EXPECT_EQ(a.odometry[i].stamp_ns, b.odometry[i].stamp_ns);
    EXPECT_EQ(a.odometry[i].position, b.odometry[i].position);
    EXPECT_EQ(a.odometry[i].heading, b.odometry[i].heading);
  }
}

FilmedTruth SomeTruth(const Observation& o) {
  RandomStream random(uint64_t(o.stamp_ns), "truth");
  FilmedTruth truth;
  const auto pose = [&] {
    return Pose(Eigen::Quaterniond(random.Normal(), random.Normal(), random.Normal(), random.Normal()),
                {random.Normal(), random.Normal(), random.Normal()});
  };
  truth.X_WC = pose();
  truth.X_WC_open = pose();
  truth.X_WC_close = pose();
  truth.subframes = {{o.stamp_ns - 1000, 0.25, pose()}, {o.stamp_ns + 1000, 0.75, pose()}};
  truth.sharp = RandomImage(random, CV_8UC3);
  truth.depth = RandomDepth(random, 5);
  truth.blur = cv::Mat(kHeight, kWidth, CV_32FC2, cv::Scalar(3.25, -1.5));
  truth.blur.at<cv::Vec2f>(0, 0) = {NAN, NAN};
  truth.left_contact = true;
  return truth;
}

struct Kind {
  DatasetFormat format;
  bool truth_inside = false;
};

class Datasets : public FileTest {
 protected:
  DatasetFolders Folders() const { return DatasetFolders::In(folder_, "walk"); }

  void Record(const Calibration& calibration, const std::vector<Observation>& observations, const Kind& kind) const {
    DatasetWriterOptions options;
    options.format = kind.format;
    options.truth_inside = kind.truth_inside;
    DatasetWriter writer(Folders(), calibration, options);
    for (const Observation& o : observations) writer.Add(o, SomeTruth(o));
    EXPECT_EQ(writer.frames(), int64_t(observations.size()));
    writer.Finish("finished");
  }

  std::string ReadAllRefused() const {
    return ErrorOf<BadInput>([&] {
      DatasetReader reader(folder_ / "walk");
      while (reader.Next()) {
      }
    });
  }

  // Replaces one text in a file.
  void Spoil(const fs::path& file, const std::string& from, const std::string& to) const {
    std::string text = ReadText(file);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << file << " has no " << from;
    std::ofstream(file, std::ios::binary) << text.replace(at, from.size(), to);
  }
};

class EachFormat : public Datasets, public ::testing::WithParamInterface<DatasetFormat> {};

INSTANTIATE_TEST_SUITE_P(Format, EachFormat,
                         ::testing::Values(DatasetFormat::kTum, DatasetFormat::kEuroc, DatasetFormat::kVslamlab),
                         [](const auto& info) { return ToString(info.param); });

TEST_P(EachFormat, WhatASystemSeesComesBackToTheBit) {
  const Calibration calibration = FullCalibration();
  const std::vector<Observation> written = SomeObservations(calibration, 5);
  for (const bool truth_inside : {false, true}) {
    Record(calibration, written, {GetParam(), truth_inside});
    DatasetReader reader(folder_ / "walk");
    EXPECT_EQ(reader.format(), GetParam());
    EXPECT_EQ(reader.frames(), 5);
    ExpectSame(reader.calibration(), calibration);
    for (const Observation& o : written) {
      const auto read = reader.Next();
      ASSERT_TRUE(read);
      ExpectSame(*read, o);
    }
    EXPECT_FALSE(reader.Next());
    fs::remove_all(folder_ / "walk");
    fs::remove_all(folder_ / "walk-truth");
  }
}

TEST_P(EachFormat, AMonocularGreyRecordingComesBackToTheBit) {
  const Calibration calibration = MonoCalibration();
  const std::vector<Observation> written = SomeObservations(calibration, 3, CV_8UC1);
  Record(calibration, written, {GetParam(), true});
  DatasetReader reader(folder_);  // the folder above holds one dataset and its truth
  ExpectSame(reader.calibration(), calibration);
  for (const Observation& o : written) ExpectSame(*reader.Next(), o);  // true depth inside is no sensor's
}

TEST_P(EachFormat, NoTruthLiesInTheFolderOfTheSensors) {
  const auto written = SomeObservations(FullCalibration(), 2);
  Record(FullCalibration(), written, {GetParam()});
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "walk")) {
    const std::string name = entry.path().filename();
    for (const char* word : {"truth", "sharp", "blur", "subposes", "frames.csv"}) {
      EXPECT_EQ(name.find(word), std::string::npos) << entry.path();
    }
  }
  EXPECT_TRUE(fs::exists(folder_ / "walk-truth" / "groundtruth.txt"));
}

TEST_P(EachFormat, TruthIsWrittenBesideInFull) {
  const auto written = SomeObservations(MonoCalibration(), 3);
  Record(MonoCalibration(), written, {GetParam()});
  const fs::path truth = folder_ / "walk-truth";
  const Trajectory poses = ReadTrajectory(truth / "groundtruth.txt").trajectory;
  ASSERT_EQ(poses.size(), 3u);
  TextTable subposes(truth / "subposes.csv", ','), frames(truth / "frames.csv", ',');
  TextTable sharp(truth / "sharp.txt", ' '), blur(truth / "blur.txt", ' '), depth(truth / "depth.txt", ' ');
  for (size_t k = 0; k < 3; ++k) {
    const FilmedTruth expected = SomeTruth(written[k]);
    EXPECT_EQ(poses[k].stamp_ns, written[k].stamp_ns);
    ExpectSame(poses[k].pose, expected.X_WC);
    for (const auto& sub : expected.subframes) {
      ASSERT_TRUE(subposes.Next());
      EXPECT_EQ(subposes.Integer(0, "stamp"), written[k].stamp_ns);
      EXPECT_EQ(subposes.Integer(1, "stamp"), sub.stamp_ns);
      EXPECT_EQ(subposes.Number(2, "weight"), sub.weight);
      EXPECT_EQ(subposes.Number(3, "x"), sub.X_WC.translation.x());
      EXPECT_EQ(subposes.Number(9, "qw"), sub.X_WC.rotation.w());
    }
    ASSERT_TRUE(frames.Next() && sharp.Next() && blur.Next() && depth.Next());
    EXPECT_EQ(frames.size(), 29u);
    EXPECT_EQ(frames.Number(1, "X_WC_open_x"), expected.X_WC_open.translation.x());
    EXPECT_EQ(frames.Text(28, "X_WB_qw"), "");  // not given
    EXPECT_TRUE(SameBits(ReadImage(truth / sharp.Text(1, "file"), ""), expected.sharp));
    EXPECT_EQ(blur.SecondsAsNs(0, "stamp"), written[k].stamp_ns);
    const cv::Mat vectors = ReadVectorsPng(truth / blur.Text(1, "file"), "");
    EXPECT_EQ(vectors.at<cv::Vec2f>(3, 4), cv::Vec2f(3.25, -1.5));
    EXPECT_TRUE(std::isnan(vectors.at<cv::Vec2f>(0, 0)[0]));
    const cv::Mat read_depth = ReadDepthPng(truth / depth.Text(1, "file"), "");
    EXPECT_LE(cv::norm(read_depth, expected.depth, cv::NORM_INF), 1.001e-4);  // half of 1 / 5000 m, as a float
  }
}

TEST_F(Datasets, TheTumLayoutIsWhatItsToolsRead) {
  const Calibration calibration = FullCalibration();
  Record(calibration, SomeObservations(calibration, 2), {DatasetFormat::kTum, true});
  const fs::path root = folder_ / "walk";
  EXPECT_THAT(ReadText(root / "rgb.txt"), HasSubstr("\n1403636579.763555584 rgb/1403636579.763555584.png\n"));
  EXPECT_THAT(ReadText(root / "depth.txt"), HasSubstr("\n1403636579.763555584 depth/1403636579.763555584.png\n"));
  EXPECT_THAT(ReadText(root / "associations.txt"),
              StartsWith("1403636579.763555584 rgb/1403636579.763555584.png 1403636579.763555584 "
                         "depth/1403636579.763555584.png\n"));
  EXPECT_THAT(ReadText(root / "times.txt"), HasSubstr("\n00001 1403636579.796888917 7.666666666666667\n"));
  EXPECT_THAT(ReadText(root / "accelerometer.txt"), HasSubstr("\n1403636579.756555584 "));
  EXPECT_EQ(ReadTrajectory(root / "groundtruth.txt").trajectory.size(), 2u);
  TextTable rgb(root / "rgb.txt", ' ');
  while (rgb.Next()) EXPECT_TRUE(fs::exists(root / rgb.Text(1, "file")));
}

/// Readers of this layout skip three lines, of associations and of DSO's times none.
TEST_F(Datasets, TumTablesBeginWithThreeLinesOfComment) {
  const Calibration calibration = FullCalibration();
  Record(calibration, SomeObservations(calibration, 2), {DatasetFormat::kTum, true});
  const fs::path root = folder_ / "walk", truth = folder_ / "walk-truth";
  for (const fs::path& file : {root / "rgb.txt", root / "rgb_right.txt", root / "depth.txt", root / "accelerometer.txt",
                               root / "groundtruth.txt", truth / "groundtruth.txt", truth / "sharp.txt",
                               truth / "depth.txt", truth / "blur.txt"}) {
    EXPECT_THAT(ReadText(file), MatchesRegex("(#[^\n]*\n){3}[0-9](.|\n)*")) << file;
  }
  EXPECT_THAT(ReadText(root / "times.txt"), StartsWith("00000 1403636579.763555584 "));
}

TEST_F(Datasets, TheVslamlabLayoutIsWhatItsToolsRead) {
  const Calibration calibration = FullCalibration();
  Record(calibration, SomeObservations(calibration, 2), {DatasetFormat::kVslamlab, true});
  const fs::path root = folder_ / "walk";
  EXPECT_THAT(ReadText(root / "rgb.csv"),
              StartsWith("ts_rgb_0 (ns),path_rgb_0,ts_rgb_1 (ns),path_rgb_1,ts_depth_0 (ns),path_depth_0\n"
                         "1403636579763555584,rgb_0/1403636579763555584.png,"
                         "1403636579763555584,rgb_1/1403636579763555584.png,"
                         "1403636579763555584,depth_0/1403636579763555584.png\n"));
  for (const char* stream : {"rgb_0", "rgb_1", "depth_0"}) {
    EXPECT_TRUE(fs::exists(root / stream / "1403636579763555584.png")) << stream;
  }
  EXPECT_THAT(ReadText(root / "imu_0.csv"), StartsWith("ts (ns),wx (rad s^-1),"));
  const std::string header = "ts (ns),tx (m),ty (m),tz (m),qx,qy,qz,qw\n1403636579763555584,";
  EXPECT_THAT(ReadText(root / "groundtruth.csv"), StartsWith(header));
  EXPECT_THAT(ReadText(folder_ / "walk-truth" / "groundtruth.csv"), StartsWith(header));
}

/// Without our own files, what VSLAM-LAB's calibration.yaml says is the same.
TEST_F(Datasets, AForeignVslamlabFolderCalibratesItself) {
  const Calibration calibration = FullCalibration();
  const auto written = SomeObservations(calibration, 2, CV_8UC1);
  Record(calibration, written, {DatasetFormat::kVslamlab});
  fs::remove(folder_ / "walk" / "calibration_gaitcam.yaml");
  fs::remove(folder_ / "walk" / "exposure.csv");
  DatasetReader reader(folder_ / "walk");
  const Calibration& read = reader.calibration();
  ExpectSame(read.camera, calibration.camera);
  ExpectSame(*read.right, *calibration.right);
  EXPECT_LT((read.X_LR.translation - calibration.X_LR.translation).norm(), 1e-12);
  EXPECT_LT((read.imu.X_CI.translation - calibration.imu.X_CI.translation).norm(), 1e-12);
  EXPECT_LT(RotationAngle(read.imu.X_CI.rotation, calibration.imu.X_CI.rotation), 1e-7);
  EXPECT_EQ(read.imu.gyro_random_walk, calibration.imu.gyro_random_walk);
  EXPECT_TRUE(read.has_depth);
  const auto o = reader.Next();
  ASSERT_TRUE(o && o->right && o->depth);
  EXPECT_TRUE(SameBits(o->image.pixels, written[0].image.pixels));
  Spoil(folder_ / "walk" / "calibration.yaml", "radtan4", "equid4");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("calibration.yaml:10: distortion_type: equid4 is not supported")));
}

TEST_F(Datasets, TheEurocLayoutIsWhatItsToolsRead) {
  const Calibration calibration = FullCalibration();
  Record(calibration, SomeObservations(calibration, 2), {DatasetFormat::kEuroc, true});
  const fs::path mav0 = folder_ / "walk" / "mav0";
  EXPECT_THAT(ReadText(mav0 / "cam0" / "data.csv"),
              HasSubstr("#timestamp [ns],filename\n1403636579763555584,1403636579763555584.png\n"));
  for (const char* camera : {"cam0", "cam1"}) {
    EXPECT_TRUE(fs::exists(mav0 / camera / "data" / "1403636579763555584.png"));
    EXPECT_THAT(ReadText(mav0 / camera / "sensor.yaml"),
                AllOf(HasSubstr("camera_model: pinhole"), HasSubstr("resolution: [32, 24]"), HasSubstr("T_BS:")));
  }
  EXPECT_THAT(ReadText(mav0 / "imu0" / "data.csv"), HasSubstr("\n1403636579756555584,"));
  EXPECT_THAT(ReadText(mav0 / "imu0" / "sensor.yaml"), HasSubstr("gyroscope_noise_density"));
  EXPECT_EQ(ReadTrajectory(mav0 / "state_groundtruth_estimate0" / "data.csv").format, TrajectoryFormat::kEuroc);
  EXPECT_TRUE(fs::exists(folder_ / "walk-truth" / "mav0" / "state_groundtruth_estimate0" / "sensor.yaml"));
}

TEST_F(Datasets, EurocTruthIsThePoseOfTheImu) {
  const Calibration calibration = FullCalibration();
  const auto written = SomeObservations(calibration, 1);
  Record(calibration, written, {DatasetFormat::kEuroc});
  const auto body =
      ReadTrajectory(folder_ / "walk-truth" / "mav0" / "state_groundtruth_estimate0" / "data.csv").trajectory;
  const Pose expected = SomeTruth(written[0]).X_WC * calibration.imu.X_CI;
  // The sensor.yaml of cam0 must lead from there back to the camera.
  EXPECT_LT((body[0].pose.translation - expected.translation).norm(), 1e-12);
  const Calibration read = ReadEurocCalibration(folder_ / "walk" / "mav0");
  EXPECT_LT((read.imu.X_CI.translation - calibration.imu.X_CI.translation).norm(), 1e-12);
  EXPECT_LT(RotationAngle(read.imu.X_CI.rotation, calibration.imu.X_CI.rotation), 1e-7);
  EXPECT_LT((read.X_LR.translation - calibration.X_LR.translation).norm(), 1e-12);
  ExpectSame(read.camera, calibration.camera);
  ExpectSame(*read.right, *calibration.right);
  EXPECT_EQ(read.imu.accel_random_walk, calibration.imu.accel_random_walk);
}

TEST_F(Datasets, AnAbandonedRecordingLeavesNothing) {
  const auto observations = SomeObservations(MonoCalibration(), 2);
  {
    DatasetWriter writer(Folders(), MonoCalibration(), {});
    writer.Add(observations[0], SomeTruth(observations[0]));
    EXPECT_FALSE(fs::exists(folder_ / "walk"));
    EXPECT_FALSE(fs::is_empty(folder_));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Datasets, ThreadsWriteTheBytesThatTheCallerWould) {
  const Calibration calibration = FullCalibration();
  const std::vector<Observation> observations = SomeObservations(calibration, 40);
  for (const int threads : {0, 3}) {
    DatasetWriterOptions options;
    options.threads = threads;
    DatasetWriter writer(DatasetFolders::In(folder_ / std::to_string(threads), "walk"), calibration, options);
    for (const Observation& o : observations) writer.Add(o, SomeTruth(o));
    writer.Finish("finished");
  }
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "0")) {
    if (!entry.is_regular_file()) continue;
    EXPECT_TRUE(ReadText(entry.path()) == ReadText(folder_ / "3" / fs::relative(entry.path(), folder_ / "0")))
        << entry.path();
    ++files;
  }
  EXPECT_GT(files, 40 * 6);  // left, right, depth, sharp, true depth, blur
}

TEST_F(Datasets, AnImageThatCannotBeWrittenEndsTheRecordingAndLeavesNothing) {
  const std::vector<Observation> observations = SomeObservations(FullCalibration(), 40);
  const std::string said = ErrorOf<MissingResource>([&] {
    DatasetWriter writer(Folders(), FullCalibration(), {});
    fs::remove_all(UnfinishedNameFor(folder_ / "walk") / "rgb");
    for (const Observation& o : observations) writer.Add(o, SomeTruth(o));
    writer.Finish("finished");
  });
  EXPECT_THAT(said, AllOf(HasSubstr("rgb/"), HasSubstr("cannot write this file")));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Datasets, ARecordingOverwritesNothing) {
  fs::create_directories(folder_ / "walk");
  EXPECT_THAT(ErrorOf<BadInput>([&] { DatasetWriter(Folders(), MonoCalibration(), {}); }), HasSubstr("exists already"));
  fs::remove(folder_ / "walk");
  fs::create_directories(folder_ / "walk-truth");
  EXPECT_THAT(ErrorOf<BadInput>([&] { DatasetWriter(Folders(), MonoCalibration(), {}); }), HasSubstr("exists already"));
  EXPECT_FALSE(fs::exists(UnfinishedNameFor(folder_ / "walk")));
}

TEST_F(Datasets, WhatContradictsTheCalibrationIsNotRecorded) {
  const auto good = SomeObservations(MonoCalibration(), 2);
  const auto refusal = [&](const Observation& o) {
    return ErrorOf<BadInput>([&] {
      DatasetWriter writer(Folders(), MonoCalibration(), {});
      writer.Add(good[0], {});
      writer.Add(o, {});
    });
  };
  EXPECT_THAT(refusal(good[0]), HasSubstr("stamp does not increase"));
  Observation bad = good[1];
  bad.image.pixels = cv::Mat(10, 10, CV_8UC1);
  EXPECT_THAT(refusal(bad), HasSubstr("10 x 10 pixels, but the calibration says 32 x 24"));
  bad = good[1];
  bad.right = bad.image;
  EXPECT_THAT(refusal(bad), HasSubstr("not just the images"));
  bad = good[1];
  bad.imu.resize(1);
  EXPECT_THAT(refusal(bad), HasSubstr("no IMU"));
}

TEST_F(Datasets, AForeignTumFolderIsReadWithAGivenCalibration) {
  RandomStream random(1, "foreign");
  const fs::path root = folder_ / "freiburg";
  fs::create_directories(root / "rgb");
  fs::create_directories(root / "depth");
  std::vector<cv::Mat> images, depths;
  for (int k = 0; k < 3; ++k) {
    images.push_back(RandomImage(random, CV_8UC3));
    WritePng(root / "rgb" / (std::to_string(k) + ".png"), images.back(), 1);
    depths.push_back(RandomDepth(random, 8));
    WriteDepthPng(root / "depth" / (std::to_string(k) + ".png"), depths.back(), 1);
  }
  Write("freiburg/rgb.txt",
        "# color images\n# file: 'x.bag'\n1305031102.175304 rgb/0.png\n1305031102.211214 rgb/1.png\n"
        "1305031102.911214 rgb/2.png\n");
  Write("freiburg/depth.txt",
        "# depth maps\n1305031102.160407 depth/0.png\n1305031102.212345 depth/1.png\n1305031102.3 depth/2.png\n");
  EXPECT_THAT(ErrorOf<BadInput>([&] { DatasetReader reader(root); }),
              HasSubstr("calibration.yaml: there is no such file"));
  Calibration calibration = MonoCalibration();
  calibration.has_depth = true;
  DatasetReader reader(root, {Write("kinect.yaml", CalibrationText(calibration))});
  EXPECT_EQ(reader.frames(), 3);
  for (size_t k = 0; k < 2; ++k) {
    const auto o = reader.Next();
    ASSERT_TRUE(o && o->depth);
    EXPECT_TRUE(SameBits(o->image.pixels, images[k]));
    EXPECT_LE(cv::norm(o->depth->pixels, depths[k], cv::NORM_INF), 1.001e-4);  // half of 1 / 5000 m, as a float
    EXPECT_EQ(o->exposure_ms, 0);
  }
  EXPECT_FALSE(reader.Next()->depth);  // the nearest is 0.6 s away
}

TEST_F(Datasets, AForeignEurocFolderCalibratesItself) {
  RandomStream random(1, "foreign");
  const cv::Mat image = RandomImage(random, CV_8UC1);
  fs::create_directories(folder_ / "V1_01" / "mav0" / "cam0" / "data");
  WritePng(folder_ / "V1_01" / "mav0" / "cam0" / "data" / "1403715273262142976.png", image, 1);
  Write("V1_01/mav0/cam0/data.csv", "#timestamp [ns],filename\r\n1403715273262142976,1403715273262142976.png\r\n");
  Write(
      "V1_01/mav0/cam0/sensor.yaml",
      "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam0\n"
      "T_BS:\n  cols: 4\n  rows: 4\n  data: [0.0, -1.0, 0.0, -0.02,\n         1.0, 0.0, 0.0, -0.06,\n"
      "         0.0, 0.0, 1.0, 0.01,\n         0.0, 0.0, 0.0, 1.0]\n"
      "rate_hz: 20\nresolution: [32, 24]\ncamera_model: pinhole\nintrinsics: [45.8, 45.7, 15.5, 11.5] #fu, fv, cu, cv\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]\n");
  Write("V1_01/mav0/imu0/sensor.yaml",
        "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nrate_hz: 200\n"
        "gyroscope_noise_density: 1.6968e-04\ngyroscope_random_walk: 1.9393e-05\naccelerometer_noise_density: 2.0e-3\n"
        "accelerometer_random_walk: 3.0e-3\n");
  Write("V1_01/mav0/imu0/data.csv",
        "#timestamp [ns],w\n1403715273262142000,-0.1,0.15,0.02,8.15,-0.37,-2.4\n1403715273267142976,0,0,0,8,0,2\n");
  DatasetReader reader(folder_ / "V1_01");
  EXPECT_EQ(reader.calibration().camera.k2, 0.07);
  EXPECT_EQ(reader.calibration().imu.rate_hz, 200);
  // T_BS maps camera points into the body: x of the camera is y of the IMU.
  EXPECT_LT((reader.calibration().imu.X_CI * Eigen::Vector3d(-0.02, 0.94, 0.01) - Eigen::Vector3d(1, 0, 0)).norm(),
            1e-12);
  const auto o = reader.Next();
  ASSERT_TRUE(o);
  EXPECT_TRUE(SameBits(o->image.pixels, image));
  ASSERT_EQ(o->imu.size(), 1u);  // the second sample lies after the frame
  EXPECT_EQ(o->imu[0].specific_force.x(), 8.15);
}

TEST_F(Datasets, SpoiltFilesAreNamedWithTheirLine) {
  const Calibration calibration = FullCalibration();
  const auto written = SomeObservations(calibration, 3);
  const fs::path root = folder_ / "walk";
  const auto fresh = [&] {
    fs::remove_all(root);
    fs::remove_all(folder_ / "walk-truth");
    Record(calibration, written, {DatasetFormat::kTum});
  };
  const std::string second = "1403636579.796888917";

  fresh();
  fs::remove(root / "rgb" / (second + ".png"));
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr(second + ".png: cannot read"), HasSubstr("rgb.txt:5")));
  std::ofstream(root / "rgb" / (second + ".png")) << "this is no picture";
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("not an image that can be decoded"), HasSubstr("rgb.txt:5")));
  fresh();
  fs::resize_file(root / "rgb" / (second + ".png"), fs::file_size(root / "rgb" / (second + ".png")) / 2);
  EXPECT_THAT(ReadAllRefused(), HasSubstr("not an image that can be decoded"));
  WritePng(root / "rgb" / (second + ".png"), cv::Mat(5, 5, CV_8UC3), 1);
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("5 x 5 pixels"), HasSubstr("rgb.txt:5")));

  fresh();
  Spoil(root / "rgb.txt", second + " ", "yesterday ");
  EXPECT_THAT(ReadAllRefused(), HasSubstr("rgb.txt:5: \"yesterday\" is not a time"));
  fresh();
  Spoil(root / "rgb.txt", second + " ", "1403636579.763555584 ");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("rgb.txt:5:"), HasSubstr("does not come after")));
  fresh();
  Spoil(root / "odometry.csv", "#stamp_ns,x_m,y_m,heading_rad\n", "1,0,0\n");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("odometry.csv:2: has 3 fields"), HasSubstr("heading in rad")));
  fresh();
  Spoil(root / "odometry.csv", "#stamp_ns,x_m,y_m,heading_rad\n", "1,0,east,0\n");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("odometry.csv:2: \"east\""), HasSubstr("y in m")));
  fresh();
  fs::remove(root / "odometry.csv");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("exposure.csv:2:"), HasSubstr("no odometry.csv")));
  fresh();
  Spoil(root / "exposure.csv", "1403636579796888917,", "1403636579796888918,");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("exposure.csv:3:"), HasSubstr("1403636579796888917")));
  fresh();
  Spoil(root / "exposure.csv", ",3,3,", ",1000,3,");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("imu.csv:"), HasSubstr("the table ends")));
  fresh();
  Spoil(root / "imu.csv", ",9.81", ",fast");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("imu.csv:2: \"fast\""), HasSubstr("m/s^2")));
}

TEST_F(Datasets, SpoiltCalibrationsAreNamedWithTheirLine) {
  Record(MonoCalibration(), SomeObservations(MonoCalibration(), 1), {DatasetFormat::kEuroc});
  const fs::path file = folder_ / "walk" / "calibration.yaml";
  const std::string good = ReadText(file);
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::ofstream(file) << good;
    Spoil(file, from, to);
    return ReadAllRefused();
  };
  EXPECT_THAT(refusal("  fx: ", "  fx: wide # "), HasSubstr("calibration.yaml:7: fx: expected a number"));
  EXPECT_THAT(refusal("  fx: ", "  fx: -1 # "), HasSubstr("calibration.yaml:7: fx: expected a number greater than 0"));
  EXPECT_THAT(refusal("  fx: ", "  fxx: "), AllOf(HasSubstr("calibration.yaml:7: fxx: unknown key"), HasSubstr("fx?")));
  EXPECT_THAT(refusal("  cy: ", "  # "), HasSubstr("the key cy is missing"));
  EXPECT_THAT(refusal("rotation_xyzw: [0, 0, 0, 1]", "rotation_xyzw: [0, 0, 0, 3]"), HasSubstr("has length 3"));
  EXPECT_THAT(refusal("camera:", "camera: ]"), HasSubstr("calibration.yaml:4: not valid YAML"));
  fs::remove(file);
  const fs::path sensor = folder_ / "walk" / "mav0" / "cam0" / "sensor.yaml";
  Spoil(sensor, "pinhole", "fisheye");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("sensor.yaml:"), HasSubstr("fisheye is not supported")));
  Spoil(sensor, "fisheye", "pinhole");
  Spoil(sensor, "resolution: [32, 24]", "resolution: [4.6e11, 24]");
  EXPECT_THAT(ReadAllRefused(), AllOf(HasSubstr("sensor.yaml:"), HasSubstr("resolution: ")));
  Spoil(sensor, "resolution: [4.6e11, 24]", "resolution: [32, 24]");
  Spoil(sensor, "data: [1", "data: [2");
  EXPECT_THAT(ReadAllRefused(), HasSubstr("not a rotation matrix"));
}

TEST_F(Datasets, ACalibrationThatDoesNotSayTheReadoutMeansAGlobalShutter) {
  Calibration rolling = MonoCalibration();
  rolling.readout_ms = 12;
  Record(rolling, SomeObservations(rolling, 1), {DatasetFormat::kTum});
  const fs::path file = folder_ / "walk" / "calibration.yaml";
  EXPECT_EQ(ReadCalibration(file).readout_ms, 12);
  Spoil(file, "readout_ms: 12", "readout_ms: -1");
  EXPECT_THAT(ErrorOf<BadInput>([&] { ReadCalibration(file); }),
              HasSubstr("readout_ms: expected a time of at least 0"));
  Spoil(file, "readout_ms: -1", "");
  EXPECT_EQ(ReadCalibration(file).readout_ms, 0);
}

TEST_F(Datasets, AFolderThatIsNoneIsSaid) {
  const auto refusal = [&](const fs::path& folder) { return ErrorOf<BadInput>([&] { DatasetReader reader(folder); }); };
  EXPECT_THAT(refusal(folder_ / "absent"), HasSubstr("there is no such folder"));
  EXPECT_THAT(refusal(folder_),
              HasSubstr("expected rgb.txt (TUM RGB-D), mav0/cam0/data.csv (EuRoC ASL) or rgb.csv (VSLAM-LAB)"));
  Write("a/rgb.txt", "");
  Write("b/rgb.txt", "");
  EXPECT_THAT(refusal(folder_), HasSubstr("several datasets"));
  Write("a/calibration.yaml", CalibrationText(MonoCalibration()));
  EXPECT_THAT(refusal(folder_ / "a"), HasSubstr("lists no image"));
  EXPECT_THROW(DatasetFormatFromText("bag"), BadInput);
}

TEST(DepthFiles, WhatSixteenBitsHoldIsExact) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "depth.png";
  cv::Mat depth(1, 65536, CV_32FC1);
  for (int i = 0; i < 65536; ++i) depth.at<float>(0, i) = float(i / kDepthUnitsPerMetre);
  EXPECT_TRUE(WriteDepthPng(file, depth, 1));
  EXPECT_TRUE(SameBits(ReadDepthPng(file, ""), depth));
  depth.at<float>(0, 7) = 1.00001f;
  EXPECT_FALSE(WriteDepthPng(file, depth, 1));
  depth.at<float>(0, 7) = 20.0f;
  EXPECT_FALSE(WriteDepthPng(file, depth, 1));
  EXPECT_EQ(ReadDepthPng(file, "").at<float>(0, 7), 0.0f);
}

}  // namespace
}  // namespace gaitcam
