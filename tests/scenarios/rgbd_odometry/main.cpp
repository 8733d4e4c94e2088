// Somebody else's odometry, as a program of its own: OpenCV's dense RGB-D odometry (RgbdICPOdometry of Debian's
// opencv_rgbd) on a folder in TUM RGB-D layout. From frame to frame it makes grey values (Steinbrücker et al. 2011) and
// the distances of points to planes agree, together. Grey values alone (RgbdOdometry) slip where the view has little
// texture. It knows nothing of gaitcam but the dataset's files.
//
//   rgbd_odometry DATASET OUTPUT

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/rgbd/depth.hpp>
#include <sstream>
#include <string>

namespace {

cv::Mat ReadK(const std::string& folder) {
  const YAML::Node camera = YAML::LoadFile(folder + "/calibration.yaml")["camera"];
  cv::Mat K = cv::Mat::eye(3, 3, CV_32F);
  K.at<float>(0, 0) = camera["fx"].as<float>();
  K.at<float>(1, 1) = camera["fy"].as<float>();
  K.at<float>(0, 2) = camera["cx"].as<float>();
  K.at<float>(1, 2) = camera["cy"].as<float>();
  return K;
}

cv::Ptr<cv::rgbd::OdometryFrame> ReadFrame(const std::string& image_file, const std::string& depth_file) {
  const cv::Mat image = cv::imread(image_file, cv::IMREAD_GRAYSCALE);
  cv::Mat depth;
  cv::imread(depth_file, cv::IMREAD_UNCHANGED).convertTo(depth, CV_32F, 1.0 / 5000);
  depth.setTo(std::numeric_limits<float>::quiet_NaN(), depth == 0);
  return cv::rgbd::OdometryFrame::create(image, depth);
}

void WritePose(std::ofstream& out, const std::string& stamp, const Eigen::Isometry3d& X_WC) {
  const Eigen::Quaterniond q(X_WC.rotation());
  const Eigen::Vector3d t = X_WC.translation();
  out << stamp << std::setprecision(9) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << q.x() << ' ' << q.y()
      << ' ' << q.z() << ' ' << q.w() << '\n';
}

int Track(const std::string& folder, const std::string& output) {
  cv::setNumThreads(1);
  std::ifstream table(folder + "/associations.txt");
  if (!table) {
    std::fprintf(stderr, "%s/associations.txt: not there; this program needs depth\n", folder.c_str());
    return 2;
  }
  const cv::Ptr<cv::rgbd::Odometry> odometry = cv::rgbd::RgbdICPOdometry::create(ReadK(folder), 0.1F, 12.0F);
  std::ofstream out(output);
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  cv::Ptr<cv::rgbd::OdometryFrame> last;
  for (std::string line; std::getline(table, line);) {
    std::istringstream fields(line);
    std::string stamp, image, depth_stamp, depth;
    if (!(fields >> stamp >> image >> depth_stamp >> depth) || stamp[0] == '#') continue;
    cv::Ptr<cv::rgbd::OdometryFrame> frame = ReadFrame(folder + "/" + image, folder + "/" + depth);
    cv::Mat X_FL;  // maps points of the last frame into this one
    if (last && odometry->compute(last, frame, X_FL)) {
      Eigen::Matrix4d matrix;
      cv::cv2eigen(X_FL, matrix);
      X_WC = X_WC * Eigen::Isometry3d(matrix).inverse();
    }
    WritePose(out, stamp, X_WC);
    last = frame;
  }
  return out.good() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: rgbd_odometry DATASET OUTPUT\n");
    return 2;
  }
  try {
    return Track(argv[1], argv[2]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
