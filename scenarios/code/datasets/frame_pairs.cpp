#include "scenarios/code/datasets/frame_pairs.h"

#include <fmt/format.h>

#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/geometry/depth_image.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

constexpr double kFloorHeight_m = 0.002;  // depth is good to 0.1 mm
constexpr double kSameDepth = 0.01;       // relative: a larger difference is another surface

void Copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (error) throw MissingResource(to.string() + ": cannot write this file: " + error.message());
}

std::string HomographyText(const Eigen::Matrix3d& H) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    text += ExactText(H(row, 0)) + " " + ExactText(H(row, 1)) + " " + ExactText(H(row, 2)) + "\n";
  return text;
}

std::string PointsText(const std::vector<TruePointPair>& points) {
  std::string text = "#a_x_px,a_y_px,b_x_px,b_y_px,X_m,Y_m,Z_m,floor\n";
  for (const TruePointPair& p : points) {
    for (const double number : {p.a.x(), p.a.y(), p.b.x(), p.b.y(), p.p_W.x(), p.p_W.y(), p.p_W.z()})
      text += ExactText(number) + ",";
    text += p.on_floor ? "1\n" : "0\n";
  }
  return text;
}

std::string FrameText(const char* name, size_t number, const RecordedFrame& frame) {
  const Eigen::Vector3d& t = frame.X_WC.translation;
  const Eigen::Quaterniond& q = frame.X_WC.rotation;
  std::string text = fmt::format("{} {} {} {:.3f}", name, number, frame.stamp_ns, frame.blur_median_px);
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) text += " " + ExactText(value);
  return text + "\n";
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw MissingResource(folder.string() + ": cannot make this folder: " + error.message());
}

/// One pair's folder. @returns its row of pairs.csv.
std::string WritePair(const RecordedWalk& walk, size_t a, size_t b, const PairOptions& options) {
  const RecordedFrame &frame_a = walk.frames[a], &frame_b = walk.frames[b];
  const std::string name = fmt::format("{:06d}_{:06d}", a, b);
  const fs::path folder = walk.folders.truth / "pairs" / name;
  MakeFolder(folder);
  for (const auto& [frame, letter] : {std::pair{&frame_a, "a"}, std::pair{&frame_b, "b"}}) {
    Copy(frame->image, folder / fmt::format("{}.png", letter));
    Copy(frame->sharp, folder / fmt::format("{}_sharp.png", letter));
    Copy(frame->blur, folder / fmt::format("{}_blur.png", letter));
  }
  const std::vector<TruePointPair> points =
      MatchPoints(walk.calibration.camera, frame_a.X_WC, ReadTrueDepth(walk, frame_a), frame_b.X_WC,
                  ReadTrueDepth(walk, frame_b), options.points);
  WriteWholeFile(folder / "H_floor.txt",
                 HomographyText(FloorHomography(walk.calibration.camera, frame_a.X_WC, frame_b.X_WC)));
  WriteWholeFile(folder / "points.csv", PointsText(points));
  WriteWholeFile(folder / "pair.txt", "# image frame stamp_ns blur_median_px X_WC: x y z qx qy qz qw\n" +
                                          FrameText("a", a, frame_a) + FrameText("b", b, frame_b));
  int on_floor = 0;
  for (const TruePointPair& p : points) on_floor += p.on_floor;
  return fmt::format("{},{},{},{},{},{:.3f},{:.3f},{},{}\n", name, a, b, frame_a.stamp_ns, frame_b.stamp_ns,
                     frame_a.blur_median_px, frame_b.blur_median_px, points.size(), on_floor);
}

}  // namespace

Eigen::Matrix3d FloorHomography(const CameraModel& camera, const Pose& X_WA, const Pose& X_WB) {
  const Pose X_BA = X_WB.Inverse() * X_WA;
  const Eigen::Vector3d n = X_WA.R().row(2).transpose();  // the world's z axis in a's frame
  const double d = -X_WA.translation.z();                 // of a point on the floor, n^T p
  const Eigen::Matrix3d K = camera.K();
  const Eigen::Matrix3d H = K * (X_BA.R() + X_BA.translation * n.transpose() / d) * K.inverse();
  return H / H(2, 2);
}

std::vector<TruePointPair> MatchPoints(const CameraModel& camera, const Pose& X_WA, const cv::Mat& depth_a,
                                       const Pose& X_WB, const cv::Mat& depth_b, int wanted) {
  const Pose X_BW = X_WB.Inverse();
  const double pixels = double(depth_a.cols) * depth_a.rows;
  const int step = std::max(1, int(std::floor(std::sqrt(pixels / wanted))));
  std::vector<TruePointPair> points;
  for (int y = step / 2; y < depth_a.rows; y += step) {
    for (int x = step / 2; x < depth_a.cols; x += step) {
      const Eigen::Vector2d a(x, y);
      if (!DepthAt(depth_a, a)) continue;  // no depth, or a depth edge
      const double z = double(depth_a.at<float>(y, x));
      const Eigen::Vector3d p_W = X_WA * Eigen::Vector3d(z * camera.Unproject(a)), p_B = X_BW * p_W;
      const std::optional<Eigen::Vector2d> b = camera.Project(p_B);
      const std::optional<double> seen = b ? DepthAt(depth_b, *b) : std::nullopt;
      if (!seen || std::abs(*seen - p_B.z()) > kSameDepth * p_B.z()) continue;
      points.push_back({a, *b, p_W, std::abs(p_W.z()) < kFloorHeight_m});
    }
  }
  return points;
}

int WriteFramePairs(const RecordedWalk& walk, const PairOptions& options) {
  for (const RecordedFrame& frame : walk.frames) {
    if (frame.sharp.empty() || frame.depth.empty() || frame.blur.empty())
      throw BadInput(walk.folders.truth.string() + ": pairs need sharp twins, depth and blur vectors of all frames");
  }
  MakeFolder(walk.folders.truth / "pairs");
  std::string table = "#pair,frame_a,frame_b,stamp_a_ns,stamp_b_ns,blur_a_px,blur_b_px,points,floor_points\n";
  int count = 0;
  for (size_t a = 0; a + size_t(options.gap) < walk.frames.size(); a += size_t(options.every), ++count)
    table += WritePair(walk, a, a + size_t(options.gap), options);
  WriteWholeFile(walk.folders.truth / "pairs" / "pairs.csv", table);
  return count;
}

}  // namespace gaitcam
