#include "algorithms/io/program_settings.h"

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Dense>
#include <cstdio>
#include <opencv2/core.hpp>

#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Stereo with depth and an IMU, all parts turned against each other; a lens that every program knows.
Calibration Rig() {
  Calibration calibration;
  calibration.camera = CameraModel::FromHorizontalFov(320, 240, 60);
  calibration.camera.cx += 1.25;
  calibration.camera.k1 = -0.1 / 3;
  calibration.camera.k2 = 0.01 / 3;
  calibration.camera.p1 = 1e-4 / 7;
  calibration.camera.p2 = -2e-4 / 7;
  calibration.right = calibration.camera;
  calibration.right->fx += 1.5;
  calibration.X_LR = Pose(Eigen::Quaterniond(1, 0.01, -0.02, 0.003), {0.07, 0.001 / 3, 1e-5});
  calibration.has_depth = true;
  calibration.frame_rate_hz = 20;
  calibration.imu = {200.0 / 3, 1.7e-4 / 3, 2e-5 / 7,
                     2e-3 / 3,  3e-3 / 7,   Pose(Eigen::Quaterniond(0.3, 0.1, -0.2, 1), {0.1 / 3, 0.2 / 7, -0.3})};
  return calibration;
}

const ProgramSettings* Find(const std::vector<ProgramSettings>& all, const std::string& file) {
  for (const ProgramSettings& settings : all) {
    if (settings.file == file) return &settings;
  }
  return nullptr;
}

std::string TextOf(const Calibration& calibration, const std::string& file) {
  static std::vector<ProgramSettings> all;
  all = SettingsOf(calibration, DatasetFormat::kEuroc);
  const ProgramSettings* found = Find(all, file);
  EXPECT_TRUE(found) << file;
  return found ? found->text : "";
}

cv::FileStorage Opencv(const std::string& text) {
  return cv::FileStorage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
}

Eigen::Matrix4d Matrix(const cv::Mat& read) {
  cv::Mat_<double> M;
  read.convertTo(M, CV_64F);
  return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(M.ptr<double>());
}

/// A list of four rows.
Eigen::Matrix4d Rows(const cv::FileNode& node) {
  Eigen::Matrix4d M;
  for (int i = 0; i < 16; ++i) M(i / 4, i % 4) = double(node[i / 4][i % 4]);
  return M;
}

Eigen::Matrix4d Rows(const YAML::Node& node) {
  Eigen::Matrix4d M;
  for (int i = 0; i < 16; ++i) M(i / 4, i % 4) = node[i / 4][i % 4].as<double>();
  return M;
}

constexpr double kFloat = 1e-7;  // of matrices that ORB-SLAM wants in single precision

TEST(ProgramSettingsTest, OpencvReadsWhatOrbSlam3Requires) {
  const Calibration rig = Rig();
  const cv::FileStorage file = Opencv(TextOf(rig, "settings/orbslam3.yaml"));
  ASSERT_TRUE(file.isOpened());
  EXPECT_EQ(file["File.version"].string(), "1.0");
  EXPECT_EQ(file["Camera.type"].string(), "PinHole");
  EXPECT_EQ(double(file["Camera1.fx"]), rig.camera.fx);
  EXPECT_EQ(double(file["Camera1.cx"]), rig.camera.cx);
  EXPECT_EQ(double(file["Camera1.k1"]), rig.camera.k1);
  EXPECT_EQ(double(file["Camera1.p2"]), rig.camera.p2);
  EXPECT_EQ(double(file["Camera2.fx"]), rig.right->fx);
  EXPECT_TRUE(file["Camera1.k3"].empty());
  for (const char* key : {"Camera.width", "Camera.height", "Camera.fps", "Camera.RGB", "ORBextractor.nFeatures"})
    EXPECT_TRUE(file[key].isInt()) << key;
  EXPECT_LT((Matrix(file["Stereo.T_c1_c2"].mat()) - rig.X_LR.Matrix()).norm(), kFloat);
  EXPECT_LT((Matrix(file["IMU.T_b_c1"].mat()) - rig.imu.X_CI.Inverse().Matrix()).norm(), kFloat);
  EXPECT_EQ(file["IMU.T_b_c1"].mat().type(), CV_32FC1);
  EXPECT_EQ(double(file["RGBD.DepthMapFactor"]), 5000);
  EXPECT_EQ(double(file["IMU.NoiseGyro"]), rig.imu.gyro_noise_density);
  EXPECT_EQ(double(file["IMU.AccWalk"]), rig.imu.accel_random_walk);
}

/// A point of space lies on one row of both rectified images, at the disparity that bf says.
TEST(ProgramSettingsTest, OrbSlam2RectifiesAStereoRig) {
  const Calibration rig = Rig();
  const cv::FileStorage file = Opencv(TextOf(rig, "settings/orbslam2_stereo.yaml"));
  const Eigen::Vector3d in_left(0.3, -0.2, 2.5), in_right = rig.X_LR.Inverse() * in_left;
  const auto project = [&](const std::string& side, const Eigen::Vector3d& p) {
    const cv::Mat_<double> R = file[side + ".R"].mat(), P = file[side + ".P"].mat();
    const cv::Mat_<double> q = R * (cv::Mat_<double>(3, 1) << p.x(), p.y(), p.z());
    const cv::Mat_<double> uv = P(cv::Range::all(), cv::Range(0, 3)) * q;
    return Eigen::Vector3d(uv(0) / uv(2), uv(1) / uv(2), uv(2));
  };
  const Eigen::Vector3d left = project("LEFT", in_left), right = project("RIGHT", in_right);
  EXPECT_NEAR(left.y(), right.y(), 1e-9);
  EXPECT_NEAR(left.x() - right.x(), double(file["Camera.bf"]) / left.z(), 1e-9);
  EXPECT_NEAR(double(file["Camera.bf"]), double(file["Camera.fx"]) * rig.X_LR.translation.norm(), 1e-9);
  EXPECT_EQ(file["LEFT.D"].mat().total(), 5u);
}

TEST(ProgramSettingsTest, DsoHasFourLinesOfNumbers) {
  Calibration rig = Rig();
  double n[8];
  int width = 0, height = 0;
  const std::string text = TextOf(rig, "settings/dso_camera.txt");
  ASSERT_EQ(std::sscanf(text.c_str(), "RadTan %lf %lf %lf %lf %lf %lf %lf %lf\n%d %d\ncrop\n", &n[0], &n[1], &n[2],
                        &n[3], &n[4], &n[5], &n[6], &n[7], &width, &height),
            10)
      << text;
  const CameraModel& c = rig.camera;
  EXPECT_EQ(std::vector<double>(n, n + 8), (std::vector{c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2}));
  EXPECT_EQ(width, 320);
  rig.camera.k1 = rig.camera.k2 = rig.camera.p1 = rig.camera.p2 = 0;
  EXPECT_THAT(TextOf(rig, "settings/dso_camera.txt"), StartsWith("Pinhole "));
  EXPECT_THAT(TextOf(rig, "settings/dso_camera.txt"), HasSubstr(" 0\n320 240\nnone\n320 240\n"));
}

TEST(ProgramSettingsTest, OpenvinsAndKalibrHaveEveryCamerasPlace) {
  const Calibration rig = Rig();
  const Eigen::Matrix4d X_IR = (rig.imu.X_CI.Inverse() * rig.X_LR).Matrix();
  const cv::FileStorage chain = Opencv(TextOf(rig, "settings/openvins/kalibr_imucam_chain.yaml"));
  EXPECT_LT((Rows(chain["cam0"]["T_imu_cam"]) - rig.imu.X_CI.Inverse().Matrix()).norm(), 1e-12);
  EXPECT_LT((Rows(chain["cam1"]["T_imu_cam"]) - X_IR).norm(), 1e-12);
  EXPECT_EQ(chain["cam0"]["distortion_model"].string(), "radtan");
  EXPECT_EQ(int(chain["cam1"]["cam_overlaps"][0]), 0);
  const cv::FileStorage imu = Opencv(TextOf(rig, "settings/openvins/kalibr_imu_chain.yaml"));
  EXPECT_EQ(double(imu["imu0"]["gyroscope_noise_density"]), rig.imu.gyro_noise_density);
  EXPECT_EQ(double(imu["imu0"]["Tw"][1][1]), 1);
  const cv::FileStorage estimator = Opencv(TextOf(rig, "settings/openvins/estimator_config.yaml"));
  EXPECT_EQ(estimator["use_stereo"].string(), "true");
  EXPECT_EQ(estimator["relative_config_imucam"].string(), "kalibr_imucam_chain.yaml");
  const YAML::Node cameras = YAML::Load(TextOf(rig, "settings/kalibr/camchain.yaml"));
  EXPECT_LT((Rows(cameras["cam1"]["T_cn_cnm1"]) - rig.X_LR.Inverse().Matrix()).norm(), 1e-12);
  EXPECT_LT((Rows(cameras["cam1"]["T_cam_imu"]) * X_IR - Eigen::Matrix4d::Identity()).norm(), 1e-12);
  EXPECT_EQ(cameras["cam0"]["intrinsics"][2].as<double>(), rig.camera.cx);
  EXPECT_EQ(YAML::Load(TextOf(rig, "settings/kalibr/imu.yaml"))["update_rate"].as<double>(), rig.imu.rate_hz);
}

/// No file rather than one that leaves a part of the lens out.
TEST(ProgramSettingsTest, ProgramsThatCannotBeToldTheLensGetNoFile) {
  Calibration rig = Rig();
  rig.camera.k3 = 1e-3;
  const auto all = SettingsOf(rig, DatasetFormat::kTum);
  EXPECT_FALSE(Find(all, "settings/dso_camera.txt"));
  EXPECT_FALSE(Find(all, "settings/openvins/estimator_config.yaml"));
  EXPECT_FALSE(Find(all, "settings/kalibr/camchain.yaml"));
  EXPECT_THAT(TextOf(rig, "settings/orbslam3.yaml"), HasSubstr("Camera1.k3: 0.001\n"));
  EXPECT_THAT(SettingsGuide(rig, DatasetFormat::kTum), HasSubstr("none for DSO, OpenVINS and Kalibr"));
  rig = Rig();
  rig.imu.rate_hz = 0;
  EXPECT_FALSE(Find(SettingsOf(rig, DatasetFormat::kTum), "settings/openvins/estimator_config.yaml"));
  EXPECT_THAT(TextOf(rig, "settings/kalibr/camchain.yaml"), Not(HasSubstr("T_cam_imu:")));
  EXPECT_THAT(TextOf(rig, "settings/orbslam3.yaml"), Not(HasSubstr("IMU.")));
}

TEST(ProgramSettingsTest, TheGuideNamesEveryFileWithItsCommand) {
  for (const DatasetFormat format : {DatasetFormat::kTum, DatasetFormat::kEuroc, DatasetFormat::kVslamlab}) {
    const std::string guide = SettingsGuide(Rig(), format);
    for (const ProgramSettings& settings : SettingsOf(Rig(), format)) {
      EXPECT_THAT(guide, HasSubstr(settings.file + " (" + settings.program + ")"));
      for (const std::string& command : settings.commands) EXPECT_THAT(guide, HasSubstr(command));
    }
  }
  EXPECT_THAT(SettingsGuide(Rig(), DatasetFormat::kEuroc),
              HasSubstr("stereo_inertial_euroc ORBvoc.txt DATASET/settings/orbslam3.yaml DATASET "
                        "DATASET/settings/euroc_times.txt"));
}

}  // namespace
}  // namespace gaitcam
