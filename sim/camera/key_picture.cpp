#include "sim/camera/key_picture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

/// Four numbers at once. The same operations in the same order on every machine, so the same bits.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = int __attribute__((vector_size(16)));
constexpr int kLanes = 4;

Float4 Load(const float* from) {
  Float4 value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

void Store(const Float4& value, float* to) { std::memcpy(to, &value, sizeof value); }

Float4 Repeat(float value) { return Float4{value, value, value, value}; }

/// Four pixels side by side: X/Z and Y/Z of their rays, 1/Z of what they see in the key picture.
struct PixelBlock {
  Float4 ray_x, ray_y, nearness;
};

struct PointBlock {
  Float4 x, y;
};

/// Where the points that pixels see lie in the key picture: X' = R X + t, projected.
class Follower {
 public:
  Follower(const Pose& X_KC, const CameraModel& key) {
    // The key's intrinsics come in here, so that a pixel costs nine products.
    Eigen::Matrix3d K;
    K << key.fx, 0, key.cx, 0, key.fy, key.cy, 0, 0, 1;
    const Eigen::Matrix3f R = (K * X_KC.R()).cast<float>();
    const Eigen::Vector3f t = (K * X_KC.translation).cast<float>();
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) R_[i][k] = Repeat(R(i, k));
      t_[i] = Repeat(t[i]);
    }
  }

  PointBlock Follow(const PixelBlock& p) const {
    const Float4 depth = R_[2][0] * p.ray_x + R_[2][1] * p.ray_y + (R_[2][2] + t_[2] * p.nearness);
    return {(R_[0][0] * p.ray_x + R_[0][1] * p.ray_y + (R_[0][2] + t_[0] * p.nearness)) / depth,
            (R_[1][0] * p.ray_x + R_[1][1] * p.ray_y + (R_[1][2] + t_[1] * p.nearness)) / depth};
  }

 private:
  Float4 R_[3][3], t_[3];
};

/// Reads a picture between four neighbouring pixels.
class Sampler {
 public:
  explicit Sampler(const cv::Mat& light)
      : pixels_(light.ptr<float>()),
        step_(ptrdiff_t(light.step1())),
        last_x_(float(light.cols - 2)),
        last_y_(float(light.rows - 2)) {}

  /// Adds to the light of four pixels what the picture shows at four points.
  void Add(const PointBlock& at, float weight, Float4* light) const {
    for (int lane = 0; lane < kLanes; ++lane) Add(at.x[lane], at.y[lane], weight, 0, 1, light + lane);
  }

  /// Adds to the light of `count` pixels what the picture shows at (x, y) and at every `step`-th pixel after it.
  void Add(float x, float y, float weight, int step, int count, Float4* light) const {
    // Also takes what is not a number to the border; a point is that far out only where nothing is known of it.
    x = x > 0 ? std::min(x, last_x_ - float(step * (count - 1))) : 0;
    y = y > 0 ? std::min(y, last_y_) : 0;
    const int left = int(x), top = int(y);
    const float s = x - float(left), t = (y - float(top)) * weight;
    const float lower_right = s * t, lower_left = t - lower_right, upper_right = s * weight - lower_right;
    const float upper_left = weight - t - upper_right;
    const float* upper = pixels_ + top * step_ + ptrdiff_t{kLanes} * left;
    const float* lower = upper + step_;
    for (int i = 0; i < count; ++i, upper += kLanes * step, lower += kLanes * step) {
      light[i] += upper_left * Load(upper) + upper_right * Load(upper + kLanes) +
                  (lower_left * Load(lower) + lower_right * Load(lower + kLanes));
    }
  }

 private:
  const float* pixels_;
  ptrdiff_t step_;
  float last_x_, last_y_;
};

/// Plainly integrated, a lens that bends is seen through a tent-shaped pixel, two pixels wide
/// (LightAccumulator::AddBent). Between its own pixels a key picture is read through a tent as many times narrower;
/// folded with this one it is the same.
void WidenTent(int finer, cv::Mat& light) {
  std::vector<float> tent;
  for (int i = 1 - finer; i < finer; ++i) tent.push_back(float(finer - std::abs(i)) / float(finer * finer));
  cv::sepFilter2D(light, light, CV_32F, tent, tent, {-1, -1}, 0, cv::BORDER_REPLICATE);
}

/// Of the image's pixels: the nearest of the picture's. What pads the rows stays 0.
template <class Value>
cv::Mat NearestPixels(const cv::Mat& picture, const CameraModel& camera, const std::vector<float>& ray_x,
                      const std::vector<float>& ray_y, int stride, const cv::Size& size) {
  cv::Mat nearest(size.height, stride, picture.type(), cv::Scalar(0));
  const float f = float(camera.fx), cx = float(camera.cx) + 0.5f, cy = float(camera.cy) + 0.5f;
  for (int v = 0; v < size.height; ++v) {
    const float* rx = ray_x.data() + ptrdiff_t{v} * stride;
    const float* ry = ray_y.data() + ptrdiff_t{v} * stride;
    Value* to = nearest.ptr<Value>(v);
    for (int u = 0; u < size.width; ++u) to[u] = picture.at<Value>(int(f * ry[u] + cy), int(f * rx[u] + cx));
  }
  return nearest;
}

}  // namespace

KeyCamera::KeyCamera(const Lens& lens) : lens_(&lens) {
  const cv::Mat& rays = lens.rays();
  stride_ = (rays.cols + kLanes - 1) / kLanes * kLanes;
  ray_x_.resize(size_t(stride_) * size_t(rays.rows), 0);
  ray_y_.resize(ray_x_.size(), 0);
  for (int v = 0; v < rays.rows; ++v) {
    for (int u = 0; u < rays.cols; ++u) {
      const cv::Vec2f& ray = rays.at<cv::Vec2f>(v, u);
      ray_x_[size_t(v) * stride_ + u] = ray[0];
      ray_y_[size_t(v) * stride_ + u] = ray[1];
    }
  }
}

KeyPicture KeyCamera::See(Renderer& renderer, mjData& data, const SceneInstant& at, int finer,
                          const Eigen::Vector2d& shift_px, cv::Mat* depth) const {
  KeyPicture key;
  key.at = at;
  key.finer = finer;
  key.camera = Raster(finer);
  renderer.Draw(data, at.X_WC, key.camera, shift_px, finer, true);
  renderer.ReadColor(key.picture);
  const cv::Mat nearness = renderer.ReadNearness();
  key.camera.cx -= shift_px.x();
  key.camera.cy -= shift_px.y();
  const cv::Size size = lens_->rays().size();
  key.nearness = NearestPixels<float>(nearness, key.camera, ray_x_, ray_y_, stride_, size);
  if (depth != nullptr) *depth = lens_->Depth(nearness, key.camera);
  if (renderer.ShowsMovingBodies()) {
    key.bodies = NearestPixels<int>(renderer.Bodies(data), key.camera, ray_x_, ray_y_, stride_, size);
  }
  key.seen = SeenBodies(key.bodies);
  if (key.seen.back() == 0) key.bodies.release();
  return key;
}

void KeyCamera::Decode(KeyPicture& key) const {
  if (!key.light.empty()) return;
  DecodeLight(key.picture, key.light);
  if (lens_->warps()) WidenTent(key.finer, key.light);
}

/// One instant: where its pixels look in the key picture.
class KeyCamera::Path {
 public:
  /// @param place of each body among those that the key sees.
  Path(const KeyPicture& key, std::span<const int> place, const ShearedFrame& frame, double shift_scale)
      : weights_(frame.row_weights),
        place_(place),
        shift_x_(Repeat(float(frame.shift_px.x() * shift_scale))),
        shift_y_(Repeat(float(frame.shift_px.y() * shift_scale))) {
    for (const int body : key.seen) followers_.emplace_back(RelativeMotion(*frame.at, key.at, body), key.camera);
  }

  float weight(int row) const { return weights_[size_t(row)]; }

  /// @param bodies which body each pixel sees; null where all see the world.
  PointBlock Follow(PixelBlock pixels, const int* bodies) const {
    pixels.ray_x += shift_x_;
    pixels.ray_y += shift_y_;
    PointBlock points = Of(bodies == nullptr ? 0 : bodies[0]).Follow(pixels);
    for (int lane = 1; bodies != nullptr && lane < kLanes; ++lane) {
      if (bodies[lane] == bodies[0]) continue;
      const PointBlock other = Of(bodies[lane]).Follow(pixels);
      points.x[lane] = other.x[lane];
      points.y[lane] = other.y[lane];
    }
    return points;
  }

 private:
  const Follower& Of(int body) const { return followers_[size_t(place_[size_t(body)])]; }

  std::span<const float> weights_;
  std::span<const int> place_;
  Float4 shift_x_, shift_y_;
  std::vector<Follower> followers_;  ///< Of the bodies that the key sees.
};

/// Points of one row of the image.
struct KeyCamera::Row {
  const float *ray_x, *ray_y, *nearness;
  const int* bodies;  ///< Null where all see the world.

  PointBlock Follow(const Path& path, int from) const {
    const PixelBlock pixels{Load(ray_x + from), Load(ray_y + from), Load(nearness + from)};
    return path.Follow(pixels, bodies == nullptr ? nullptr : bodies + from);
  }
  bool SeesOneBody(int from) const {
    return bodies == nullptr ||
           std::all_of(bodies + from, bodies + from + kLanes, [&](int b) { return b == bodies[from]; });
  }
};

/// Every fourth point of a row: the third of each four.
class KeyCamera::Anchors {
 public:
  Anchors(const Row& row, int stride) : count_(stride / kLanes) {
    const size_t padded = size_t(count_ + kLanes);
    for (std::vector<float>* values : {&ray_x_, &ray_y_, &nearness_}) values->resize(padded, 0.f);
    bodies_.resize(padded, 0);
    for (int i = 0; i < count_; ++i) {
      const int u = kLanes * i + kAnchor;
      ray_x_[size_t(i)] = row.ray_x[u];
      ray_y_[size_t(i)] = row.ray_y[u];
      nearness_[size_t(i)] = row.nearness[u];
      if (row.bodies != nullptr) bodies_[size_t(i)] = row.bodies[u];
    }
    row_ = {ray_x_.data(), ray_y_.data(), nearness_.data(), row.bodies == nullptr ? nullptr : bodies_.data()};
  }

  static constexpr int kAnchor = 2;

  void Follow(const Path& path, std::vector<float>& x, std::vector<float>& y) const {
    for (int i = 0; i < count_; i += kLanes) {
      const PointBlock points = row_.Follow(path, i);
      for (int lane = 0; lane < kLanes; ++lane) {
        x.push_back(points.x[lane]);
        y.push_back(points.y[lane]);
      }
    }
  }
  /// How many points Follow() appends.
  size_t padded() const { return size_t((count_ + kLanes - 1) / kLanes * kLanes); }

 private:
  int count_;
  std::vector<float> ray_x_, ray_y_, nearness_;
  std::vector<int> bodies_;
  Row row_{};
};

/// Four pixels side by side share the motion of the third of them, unless they see several bodies: over two pixels, the
/// motion that a key picture is made for varies by a twentieth of a pixel.
void KeyCamera::AddRow(const KeyPicture& key, std::span<const Path* const> paths, int row, cv::Mat& light) const {
  const ptrdiff_t begin = ptrdiff_t{row} * stride_;
  const Row pixels{ray_x_.data() + begin, ray_y_.data() + begin, key.nearness.ptr<float>(row),
                   key.bodies.empty() ? nullptr : key.bodies.ptr<int>(row)};
  const Sampler sampler(key.light);
  const bool shares = !lens_->warps();
  const Anchors anchors(pixels, stride_);
  std::vector<float> x, y;
  for (const Path* path : paths) {
    if (shares) anchors.Follow(*path, x, y);
  }
  for (int u = 0; u < light.cols; u += kLanes) {  // block by block, which looks at one place of the picture
    Float4 sum[kLanes] = {};
    const bool block = shares && pixels.SeesOneBody(u);
    for (size_t i = 0; i < paths.size(); ++i) {
      const float weight = paths[i]->weight(row);
      if (block) {
        const size_t at = i * anchors.padded() + size_t(u / kLanes);
        sampler.Add(x[at] - float(Anchors::kAnchor * key.finer), y[at], weight, key.finer, kLanes, sum);
      } else {
        sampler.Add(pixels.Follow(*paths[i], u), weight, sum);
      }
    }
    float* to = light.ptr<float>(row) + ptrdiff_t{kLanes} * u;
    for (int i = 0; i < std::min(kLanes, light.cols - u); ++i, to += kLanes) Store(Load(to) + sum[i], to);
  }
}

void KeyCamera::Add(const KeyPicture& key, std::span<const ShearedFrame> frames, cv::Mat& light) const {
  const cv::Size size = lens_->rays().size();
  GAITCAM_ASSERT(light.type() == CV_32FC4 && light.size() == size && !key.light.empty());
  // Through the tent of a lens that bends, pixels look at their centres (LightAccumulator::AddBent).
  const double shift_scale = lens_->warps() ? 0 : 1 / lens_->pinhole().fx;
  std::vector<int> place(key.at.X_WB.size(), 0);
  for (size_t i = 0; i < key.seen.size(); ++i) place[size_t(key.seen[i])] = int(i);
  std::vector<Path> paths;
  for (const ShearedFrame& frame : frames) {
    GAITCAM_ASSERT(int(frame.row_weights.size()) == size.height);
    paths.emplace_back(key, place, frame, shift_scale);
  }
  std::vector<const Path*> open;
  for (int row = 0; row < size.height; ++row) {
    open.clear();
    for (const Path& path : paths) {
      if (path.weight(row) > 0) open.push_back(&path);
    }
    if (!open.empty()) AddRow(key, open, row, light);
  }
}

}  // namespace gaitcam
