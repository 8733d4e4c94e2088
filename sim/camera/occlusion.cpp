#include "sim/camera/occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "algorithms/core/errors.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

constexpr float kEdgeRatio = 1.05f;  // neighbours whose depths differ by more lie on different surfaces

/// What one pair of neighbouring pixels does to the image.
struct Strip {
  double levels = 0;  ///< The error of each pixel that it passes ...
  double pixels = 0;  ///< ... and how many these are.
};

class Edges {
 public:
  Edges(const KeyPicture& key, const cv::Mat& rays, const cv::Mat& depth, const SceneInstant& open,
        const SceneInstant& close)
      : key_(key), rays_(rays), depth_(depth) {
    f_ = (rays.cols - 1) / double(rays.at<cv::Vec2f>(0, rays.cols - 1)[0] - rays.at<cv::Vec2f>(0, 0)[0]);
    to_open_.resize(key.at.X_WB.size());
    to_close_.resize(key.at.X_WB.size());
    for (const int body : key.seen) {
      to_open_[size_t(body)] = RelativeMotion(key.at, open, body);
      to_close_[size_t(body)] = RelativeMotion(key.at, close, body);
    }
    for (size_t i = 0; i < level_.size(); ++i) level_[i] = float(255 * std::sqrt(SrgbToLinear(double(i) / 255)));
  }

  bool Between(const cv::Point& a, const cv::Point& b) const {
    const float near = std::min(depth_.at<float>(a), depth_.at<float>(b));
    const float far = std::max(depth_.at<float>(a), depth_.at<float>(b));
    return far > kEdgeRatio * near || BodyAt(a) != BodyAt(b);
  }

  /// Of two neighbours with an edge between them.
  Strip At(const cv::Point& a, const cv::Point& b) const {
    const Eigen::Vector2d open = Moved(a, a, to_open_), close = Moved(a, a, to_close_);
    const double apart = ((open - Moved(a, b, to_open_)).norm() + (close - Moved(a, b, to_close_)).norm()) / 4;
    const double path = std::max(1.0, (close - open).norm());
    const cv::Point step = b - a;
    return {Contrast(a - step, b + step) * std::min(apart, path) / path, path};
  }

 private:
  int BodyAt(const cv::Point& p) const { return key_.bodies.empty() ? 0 : key_.bodies.at<int>(p); }

  /// How far a point moves that is seen at `pixel` if it is part of what `seen` sees, px.
  Eigen::Vector2d Moved(const cv::Point& pixel, const cv::Point& seen, const std::vector<Pose>& motion) const {
    const cv::Vec2f ray = rays_.at<cv::Vec2f>(pixel);
    const float z = depth_.at<float>(seen);
    const Eigen::Vector3d from(ray[0], ray[1], 1);
    const Pose& X = motion[size_t(BodyAt(seen))];
    const Eigen::Vector3d to = X.R() * from + (z > 0 ? Eigen::Vector3d(X.translation / z) : Eigen::Vector3d::Zero());
    if (to.z() <= 0) return Eigen::Vector2d::Zero();
    return f_ * (to.head<2>() / to.z() - from.head<2>());
  }

  /// In grey levels, whose curve is near a square root.
  double Contrast(const cv::Point& a, const cv::Point& b) const {
    float largest = 0;
    const uint8_t *at_a = Seen(a), *at_b = Seen(b);
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(level_[at_a[c]] - level_[at_b[c]]));
    return largest;
  }

  const uint8_t* Seen(const cv::Point& p) const {
    const cv::Vec2f ray = rays_.at<cv::Vec2f>(std::clamp(p.y, 0, rays_.rows - 1), std::clamp(p.x, 0, rays_.cols - 1));
    const int row = int(key_.camera.fy * ray[1] + key_.camera.cy + 0.5);
    return key_.picture.ptr<uint8_t>(key_.picture.rows - 1 - row, int(key_.camera.fx * ray[0] + key_.camera.cx + 0.5));
  }

  const KeyPicture& key_;
  const cv::Mat &rays_, &depth_;
  double f_;                              ///< Pixels per unit of a ray, over the width of the image.
  std::vector<Pose> to_open_, to_close_;  ///< By body, of those that are seen.
  std::array<float, 256> level_;          ///< Of display values.
};

}  // namespace

GreyError OcclusionError(const KeyPicture& key, const cv::Mat& rays, const cv::Mat& depth, const SceneInstant& open,
                         const SceneInstant& close) {
  GAITCAM_ASSERT(rays.type() == CV_32FC2 && depth.type() == CV_32FC1 && rays.size() == depth.size());
  const Edges edges(key, rays, depth, open, close);
  std::vector<Strip> strips;
  for (int v = 0; v < rays.rows; ++v) {
    for (int u = 0; u < rays.cols; ++u) {
      const cv::Point here(u, v), right(u + 1, v), below(u, v + 1);
      if (right.x < rays.cols && edges.Between(here, right)) strips.push_back(edges.At(here, right));
      if (below.y < rays.rows && edges.Between(here, below)) strips.push_back(edges.At(here, below));
    }
  }
  GreyError error;
  double squares = 0, worse = 0;
  const double all = double(rays.total());
  for (const Strip& strip : strips) squares += strip.levels * strip.levels * strip.pixels;
  error.rms = std::sqrt(squares / all);
  std::sort(strips.begin(), strips.end(), [](const Strip& a, const Strip& b) { return a.levels > b.levels; });
  for (const Strip& strip : strips) {
    worse += strip.pixels;
    if (worse <= 0.001 * all) continue;
    error.p99_9 = strip.levels;
    break;
  }
  return error;
}

}  // namespace gaitcam
