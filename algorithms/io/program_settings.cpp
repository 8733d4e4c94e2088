#include "algorithms/io/program_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "algorithms/io/calibration_file.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDataset = "DATASET";
constexpr double kGravity_m_s2 = 9.81;

bool HasImu(const Calibration& calibration) { return calibration.imu.rate_hz > 0; }

bool HasK3(const Calibration& calibration) {
  return calibration.camera.k3 != 0 || (calibration.right && calibration.right->k3 != 0);
}

int WholeRate(const Calibration& calibration) { return std::max(1, int(std::lround(calibration.frame_rate_hz))); }

std::string Entry(const std::string& key, double value) { return key + ": " + ExactText(value) + "\n"; }

/// "  - [a, b, c, d]", four of them.
std::string RowsText(const Pose& X) {
  const Eigen::Matrix4d M = X.Matrix();
  std::string text;
  for (int i = 0; i < 4; ++i) text += "    - " + ExactList({M(i, 0), M(i, 1), M(i, 2), M(i, 3)}) + "\n";
  return text;
}

/// A matrix as OpenCV's FileStorage reads it.
/// @param type 'd' or 'f', as the program's code asks for.
std::string OpencvMatrix(const std::string& key, const cv::Mat_<double>& M, char type) {
  return fmt::format("{}: !!opencv-matrix\n  rows: {}\n  cols: {}\n  dt: {}\n  data: {}\n", key, M.rows, M.cols, type,
                     ExactList(std::vector<double>(M.begin(), M.end())));
}

cv::Mat_<double> Matrix(const Pose& X) {
  cv::Mat_<double> M(4, 4);
  for (int i = 0; i < 16; ++i) M(i / 4, i % 4) = X.Matrix()(i / 4, i % 4);
  return M;
}

cv::Mat_<double> K(const CameraModel& c) { return (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1); }
cv::Mat_<double> Distortion(const CameraModel& c) { return (cv::Mat_<double>(1, 5) << c.k1, c.k2, c.p1, c.p2, c.k3); }

/// Where lines are all that there is, and none may be a comment: model, size, how to rectify, size of the result.
std::string DsoText(const CameraModel& c) {
  const std::string size = fmt::format("{} {}\n", c.width_px, c.height_px);
  std::string text = c.IsDistorted() ? "RadTan" : "Pinhole";
  for (const double number : {c.fx, c.fy, c.cx, c.cy}) text += " " + ExactText(number);
  if (!c.IsDistorted()) return text + " 0\n" + size + "none\n" + size;
  for (const double number : {c.k1, c.k2, c.p1, c.p2}) text += " " + ExactText(number);
  return text + "\n" + size + "crop\n" + size;
}

/// @param prefix "Camera", "Camera1", "Camera2".
std::string OrbIntrinsics(const std::string& prefix, const CameraModel& c) {
  std::string text = Entry(prefix + ".fx", c.fx) + Entry(prefix + ".fy", c.fy) + Entry(prefix + ".cx", c.cx) +
                     Entry(prefix + ".cy", c.cy) + Entry(prefix + ".k1", c.k1) + Entry(prefix + ".k2", c.k2) +
                     Entry(prefix + ".p1", c.p1) + Entry(prefix + ".p2", c.p2);
  return c.k3 == 0 ? text : text + Entry(prefix + ".k3", c.k3);
}

/// What both versions call alike.
std::string OrbCommon(const Calibration& calibration) {
  const CameraModel& c = calibration.camera;
  return fmt::format("Camera.width: {}\nCamera.height: {}\n", c.width_px, c.height_px) +
         fmt::format("Camera.fps: {}  # a whole number is expected\n", WholeRate(calibration)) +
         "Camera.RGB: 0  # images come as OpenCV reads them: blue first, or grey\n" +
         "\nORBextractor.nFeatures: 1000\nORBextractor.scaleFactor: 1.2\nORBextractor.nLevels: 8\n"
         "ORBextractor.iniThFAST: 20\nORBextractor.minThFAST: 7\n"
         "\nViewer.KeyFrameSize: 0.05\nViewer.KeyFrameLineWidth: 1.0\nViewer.GraphLineWidth: 1.0\nViewer.PointSize: "
         "2.0\n"
         "Viewer.CameraSize: 0.08\nViewer.CameraLineWidth: 2.0\nViewer.ViewpointX: 0.0\nViewer.ViewpointY: -0.7\n"
         "Viewer.ViewpointZ: -2.0\nViewer.ViewpointF: 500.0\n";
}

constexpr double kDepthBaseline_m = 0.08;  // of the stereo rig that a depth camera stands for
constexpr double kNearDepth = 40;          // baselines within which a point counts as near

std::string OrbSlam3Text(const Calibration& calibration) {
  std::string text =
      "%YAML:1.0\n# ORB-SLAM3, every mode that these sensors allow.\nFile.version: \"1.0\"\n"
      "Camera.type: \"PinHole\"\n" +
      OrbIntrinsics("Camera1", calibration.camera);
  if (calibration.right) {
    text += OrbIntrinsics("Camera2", *calibration.right) + "# Maps points of the right camera into the left one.\n" +
            OpencvMatrix("Stereo.T_c1_c2", Matrix(calibration.X_LR), 'f');
  }
  if (calibration.right || calibration.has_depth) {
    const double baseline_m = calibration.right ? calibration.X_LR.translation.norm() : kDepthBaseline_m;
    text += Entry("Stereo.b", baseline_m) + Entry("Stereo.ThDepth", kNearDepth);
  }
  if (calibration.has_depth) text += Entry("RGBD.DepthMapFactor", kDepthUnitsPerMetre);
  if (HasImu(calibration)) {
    const ImuCalibration& imu = calibration.imu;
    text += "# Maps points of the left camera into the IMU's frame.\n" +
            OpencvMatrix("IMU.T_b_c1", Matrix(imu.X_CI.Inverse()), 'f') +
            Entry("IMU.NoiseGyro", imu.gyro_noise_density) + Entry("IMU.NoiseAcc", imu.accel_noise_density) +
            Entry("IMU.GyroWalk", imu.gyro_random_walk) + Entry("IMU.AccWalk", imu.accel_random_walk) +
            Entry("IMU.Frequency", imu.rate_hz);
  }
  return text + OrbCommon(calibration);
}

std::string OrbSlam2Text(const Calibration& calibration) {
  std::string text =
      "%YAML:1.0\n# ORB-SLAM2 with one camera, or with depth.\n" + OrbIntrinsics("Camera", calibration.camera);
  if (calibration.has_depth) {
    text += Entry("Camera.bf", kDepthBaseline_m * calibration.camera.fx) + Entry("ThDepth", kNearDepth) +
            Entry("DepthMapFactor", kDepthUnitsPerMetre);
  }
  return text + OrbCommon(calibration);
}

/// The cameras of the rectified images, and what rectifies them.
std::string OrbSlam2StereoText(const Calibration& calibration) {
  const CameraModel &left = calibration.camera, &right = *calibration.right;
  const Pose X_RL = calibration.X_LR.Inverse();
  const cv::Mat_<double> X = Matrix(X_RL);
  cv::Mat R_left, R_right, P_left, P_right, Q;
  cv::stereoRectify(K(left), Distortion(left), K(right), Distortion(right), {left.width_px, left.height_px},
                    X(cv::Range(0, 3), cv::Range(0, 3)), X(cv::Range(0, 3), cv::Range(3, 4)), R_left, R_right, P_left,
                    P_right, Q, cv::CALIB_ZERO_DISPARITY, 0);
  CameraModel rectified;
  rectified.fx = P_left.at<double>(0, 0), rectified.fy = P_left.at<double>(1, 1);
  rectified.cx = P_left.at<double>(0, 2), rectified.cy = P_left.at<double>(1, 2);
  std::string text = "%YAML:1.0\n# ORB-SLAM2 with two cameras, whose images it rectifies.\n" +
                     OrbIntrinsics("Camera", rectified) + Entry("Camera.bf", -P_right.at<double>(0, 3)) +
                     Entry("ThDepth", kNearDepth);
  const auto side = [&](const std::string& name, const CameraModel& c, const cv::Mat& R, const cv::Mat& P) {
    text += fmt::format("{0}.width: {1}\n{0}.height: {2}\n", name, c.width_px, c.height_px) +
            OpencvMatrix(name + ".D", Distortion(c), 'd') + OpencvMatrix(name + ".K", K(c), 'd') +
            OpencvMatrix(name + ".R", R, 'd') + OpencvMatrix(name + ".P", P, 'd');
  };
  side("LEFT", left, R_left, P_left);
  side("RIGHT", right, R_right, P_right);
  return text + OrbCommon(calibration);
}

/// The part that OpenVINS and Kalibr call alike.
std::string ChainCamera(const CameraModel& c, int index, bool other) {
  return fmt::format("  cam_overlaps: [{}]\n  camera_model: pinhole\n  intrinsics: {}\n", other ? 1 - index : index,
                     ExactList({c.fx, c.fy, c.cx, c.cy})) +
         fmt::format("  distortion_model: radtan\n  distortion_coeffs: {}\n", ExactList({c.k1, c.k2, c.p1, c.p2})) +
         fmt::format("  resolution: [{}, {}]\n  rostopic: /cam{}/image_raw\n  timeshift_cam_imu: 0.0\n", c.width_px,
                     c.height_px, index);
}

std::string ChainNoise(const ImuCalibration& imu, const std::string& indent) {
  return indent + Entry("accelerometer_noise_density", imu.accel_noise_density) + indent +
         Entry("accelerometer_random_walk", imu.accel_random_walk) + indent +
         Entry("gyroscope_noise_density", imu.gyro_noise_density) + indent +
         Entry("gyroscope_random_walk", imu.gyro_random_walk) + indent + "rostopic: /imu0\n" + indent +
         Entry("update_rate", imu.rate_hz);
}

std::string OpenvinsCameras(const Calibration& calibration) {
  const Pose X_IC = calibration.imu.X_CI.Inverse();
  const bool two = calibration.right.has_value();
  std::string text = "%YAML:1.0\n# T_imu_cam maps points of the camera into the IMU's frame.\ncam0:\n  T_imu_cam:\n" +
                     RowsText(X_IC) + ChainCamera(calibration.camera, 0, two);
  if (!two) return text;
  return text + "cam1:\n  T_imu_cam:\n" + RowsText(X_IC * calibration.X_LR) + ChainCamera(*calibration.right, 1, true);
}

/// Scale, misalignment and sensitivity to g are those of an ideal IMU.
std::string OpenvinsImu(const ImuCalibration& imu) {
  const auto square = [](const char* key, double diagonal) {
    std::string text = fmt::format("  {}:\n", key);
    for (int i = 0; i < 3; ++i)
      text += "    - " + ExactList({i == 0 ? diagonal : 0, i == 1 ? diagonal : 0, i == 2 ? diagonal : 0}) + "\n";
    return text;
  };
  return "%YAML:1.0\nimu0:\n  T_i_b:\n" + RowsText(Pose()) + ChainNoise(imu, "  ") +
         "  time_offset: 0.0\n  model: \"kalibr\"\n" + square("Tw", 1) + square("R_IMUtoGYRO", 1) + square("Ta", 1) +
         square("R_IMUtoACC", 1) + square("Tg", 0);
}

/// Every key that it requires.
std::string OpenvinsEstimator(const Calibration& calibration) {
  const bool two = calibration.right.has_value();
  return "%YAML:1.0\n# OpenVINS. The calibration is exact, so none of it is estimated again.\nverbosity: \"INFO\"\n"
         "use_fej: true\nintegration: \"rk4\"\nuse_imuavg: true\nuse_rk4int: true\n" +
         fmt::format("use_stereo: {}\nmax_cameras: {}\n", two, two ? 2 : 1) +
         "calib_cam_extrinsics: false\ncalib_cam_intrinsics: false\ncalib_cam_timeoffset: false\n"
         "calib_imu_intrinsics: false\ncalib_imu_g_sensitivity: false\n"
         "max_clones: 11\nmax_slam: 50\nmax_slam_in_update: 25\nmax_msckf_in_update: 40\ndt_slam_delay: 1\n" +
         Entry("gravity_mag", kGravity_m_s2) +
         "feat_rep_msckf: \"GLOBAL_3D\"\nfeat_rep_slam: \"ANCHORED_MSCKF_INVERSE_DEPTH\"\n"
         "feat_rep_aruco: \"ANCHORED_MSCKF_INVERSE_DEPTH\"\n"
         "try_zupt: false\nzupt_chi2_multipler: 0\nzupt_max_velocity: 0.1\nzupt_noise_multiplier: 10\n"
         "zupt_max_disparity: 0.5\nzupt_only_at_beginning: false\n"
         "init_window_time: 2.0\ninit_imu_thresh: 1.5\ninit_max_disparity: 10.0\ninit_max_features: 50\n"
         "init_dyn_use: true\ninit_dyn_mle_opt_calib: false\ninit_dyn_mle_max_iter: 50\ninit_dyn_mle_max_time: 0.05\n"
         "init_dyn_mle_max_threads: 2\ninit_dyn_num_pose: 6\ninit_dyn_min_deg: 10.0\ninit_dyn_inflation_ori: 10\n"
         "init_dyn_inflation_vel: 100\ninit_dyn_inflation_bg: 10\ninit_dyn_inflation_ba: 100\n"
         "init_dyn_min_rec_cond: 1e-12\ninit_dyn_bias_g: [0.0, 0.0, 0.0]\ninit_dyn_bias_a: [0.0, 0.0, 0.0]\n"
         "record_timing_information: false\nrecord_timing_filepath: \"traj_timing.txt\"\n"
         "save_total_state: false\nfilepath_est: \"ov_estimate.txt\"\nfilepath_std: \"ov_estimate_std.txt\"\n"
         "filepath_gt: \"ov_groundtruth.txt\"\n"
         "use_klt: true\nnum_pts: 200\nfast_threshold: 20\ngrid_x: 5\ngrid_y: 5\nmin_px_dist: 10\nknn_ratio: 0.7\n" +
         Entry("track_frequency", calibration.frame_rate_hz + 1) +
         "downsample_cameras: false\nnum_opencv_threads: 2\nhistogram_method: \"HISTOGRAM\"\n"
         "use_aruco: false\nnum_aruco: 1024\ndownsize_aruco: true\n"
         "up_msckf_sigma_px: 1\nup_msckf_chi2_multipler: 1\nup_slam_sigma_px: 1\nup_slam_chi2_multipler: 1\n"
         "up_aruco_sigma_px: 1\nup_aruco_chi2_multipler: 1\nuse_mask: false\n"
         "relative_config_imu: \"kalibr_imu_chain.yaml\"\nrelative_config_imucam: \"kalibr_imucam_chain.yaml\"\n";
}

std::string KalibrCameras(const Calibration& calibration) {
  const bool two = calibration.right.has_value(), imu = HasImu(calibration);
  const auto to_imu = [&](const Pose& X_SI) { return imu ? "  T_cam_imu:\n" + RowsText(X_SI) : std::string(); };
  std::string text =
      "# Kalibr. T_cam_imu maps points of the IMU's frame into the camera, T_cn_cnm1 those of the camera "
      "before.\ncam0:\n" +
      to_imu(calibration.imu.X_CI) + ChainCamera(calibration.camera, 0, two);
  if (!two) return text;
  const Pose X_RL = calibration.X_LR.Inverse();
  return text + "cam1:\n  T_cn_cnm1:\n" + RowsText(X_RL) + to_imu(X_RL * calibration.imu.X_CI) +
         ChainCamera(*calibration.right, 1, true);
}

/// Programs' names and arguments, by layout and sensors. @param version 2 or 3.
std::vector<std::string> OrbCommands(const Calibration& calibration, DatasetFormat format, int version) {
  const std::string settings = fmt::format("ORBvoc.txt DATASET/settings/orbslam{}.yaml ", version);
  const std::string stamps = StampListOf(kDataset).string();
  std::vector<std::string> commands;
  if (format == DatasetFormat::kTum) {
    commands.push_back("mono_tum " + settings + kDataset);
    if (calibration.has_depth) commands.push_back("rgbd_tum " + settings + "DATASET DATASET/associations.txt");
  } else if (format == DatasetFormat::kEuroc && version == 2) {
    commands.push_back("mono_euroc " + settings + "DATASET/mav0/cam0/data " + stamps);
  } else if (format == DatasetFormat::kEuroc) {
    commands.push_back("mono_euroc " + settings + "DATASET " + stamps);
    if (calibration.right) commands.push_back("stereo_euroc " + settings + "DATASET " + stamps);
    if (HasImu(calibration)) commands.push_back("mono_inertial_euroc " + settings + "DATASET " + stamps);
    if (HasImu(calibration) && calibration.right)
      commands.push_back("stereo_inertial_euroc " + settings + "DATASET " + stamps);
  }
  return commands;
}

std::vector<ProgramSettings> OrbSettings(const Calibration& calibration, DatasetFormat format) {
  std::vector<ProgramSettings> all{
      {"settings/orbslam3.yaml", "ORB-SLAM3", OrbCommands(calibration, format, 3), OrbSlam3Text(calibration)},
      {"settings/orbslam2.yaml", "ORB-SLAM2", OrbCommands(calibration, format, 2), OrbSlam2Text(calibration)}};
  if (!calibration.right) return all;
  std::vector<std::string> commands;
  if (format == DatasetFormat::kEuroc) {
    commands.push_back(
        "stereo_euroc ORBvoc.txt DATASET/settings/orbslam2_stereo.yaml DATASET/mav0/cam0/data DATASET/mav0/cam1/data " +
        StampListOf(kDataset).string());
  }
  all.push_back({"settings/orbslam2_stereo.yaml", "ORB-SLAM2, stereo", commands, OrbSlam2StereoText(calibration)});
  return all;
}

std::vector<ProgramSettings> KalibrSettings(const Calibration& calibration) {
  std::vector<std::string> commands{"kalibr_calibrate_cameras --bag BAG --target TARGET (to compare its result with)"};
  if (HasImu(calibration)) {
    commands = {
        "kalibr_calibrate_imu_camera --cams DATASET/settings/kalibr/camchain.yaml "
        "--imu DATASET/settings/kalibr/imu.yaml --bag BAG --target TARGET"};
  }
  std::vector<ProgramSettings> all{{"settings/kalibr/camchain.yaml", "Kalibr", commands, KalibrCameras(calibration)}};
  if (HasImu(calibration)) {
    all.push_back({"settings/kalibr/imu.yaml", "Kalibr", commands, "# Kalibr.\n" + ChainNoise(calibration.imu, "")});
  }
  return all;
}

}  // namespace

fs::path StampListOf(const fs::path& dataset) { return dataset / "settings" / "euroc_times.txt"; }

std::vector<ProgramSettings> SettingsOf(const Calibration& calibration, DatasetFormat format) {
  std::vector<ProgramSettings> all = OrbSettings(calibration, format);
  if (HasK3(calibration)) return all;
  const std::string images = ListingOf(kDataset, format, ImageStream::kLeft).folder.string();
  all.push_back({"settings/dso_camera.txt",
                 "DSO",
                 {"dso_dataset files=" + images + " calib=DATASET/settings/dso_camera.txt mode=1"},
                 DsoText(calibration.camera)});
  if (HasImu(calibration)) {
    const std::string folder = "settings/openvins/";
    const std::vector<std::string> commands{"run_subscribe_msckf DATASET/settings/openvins/estimator_config.yaml"};
    all.push_back({folder + "estimator_config.yaml", "OpenVINS", commands, OpenvinsEstimator(calibration)});
    all.push_back({folder + "kalibr_imu_chain.yaml", "OpenVINS", commands, OpenvinsImu(calibration.imu)});
    all.push_back({folder + "kalibr_imucam_chain.yaml", "OpenVINS", commands, OpenvinsCameras(calibration)});
  }
  for (ProgramSettings& settings : KalibrSettings(calibration)) all.push_back(std::move(settings));
  return all;
}

std::string SettingsGuide(const Calibration& calibration, DatasetFormat format) {
  std::string text = "Settings of other programs, from the same calibration; DATASET stands for this folder:\n";
  const std::vector<ProgramSettings> all = SettingsOf(calibration, format);
  for (size_t i = 0; i < all.size(); ++i) {
    text += "  " + all[i].file + " (" + all[i].program + ")\n";
    if (i + 1 < all.size() && !all[i].commands.empty() && all[i].commands == all[i + 1].commands) continue;
    for (const std::string& command : all[i].commands) text += "      " + command + "\n";
  }
  if (format == DatasetFormat::kEuroc) text += "  settings/euroc_times.txt (ORB-SLAM): the stamps of all frames\n";
  if (format == DatasetFormat::kVslamlab) {
    text +=
        "  calibration.yaml (every executable of VSLAM-LAB)\n"
        "      EXECUTABLE sequence_path:DATASET calibration_yaml:DATASET/calibration.yaml rgb_csv:DATASET/rgb.csv "
        "exp_folder:OUT exp_id:0 settings_yaml:ITS_OWN mode:mono\n";
  }
  if (HasK3(calibration)) text += "  none for DSO, OpenVINS and Kalibr: their lens model has no k3\n";
  if (!HasImu(calibration)) text += "  none for OpenVINS, which needs an IMU\n";
  return text;
}

}  // namespace gaitcam
