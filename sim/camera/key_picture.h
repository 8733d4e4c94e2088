/// Light at instants near one that was rendered.
///
/// What happens between two renders is known: the depth of every pixel, and how the camera and all bodies move. A pixel
/// at time t therefore looks at the place of a key picture where its point was at the key's time, and light integrated
/// over time becomes light integrated along a path through one picture (sheared reconstruction: K. Egan et al.,
/// "Frequency analysis and sheared reconstruction for rendering motion blur", 2009). Here the path is followed pose by
/// pose, not as one straight line, because a step's jolt bends it.
///
/// A pixel's depth is taken from the same pixel of the key. That is exact while the camera turns; while it moves, a
/// strip along each depth edge is wrong that is as wide as the two sides have moved against each other since the key
/// (occlusion.h measures it).

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "algorithms/core/camera.h"
#include "sim/camera/blur_field.h"
#include "sim/camera/lens.h"
#include "sim/camera/renderer.h"

namespace gaitcam {

/// One instant, seen in more detail and a little beyond the image's border.
struct KeyPicture {
  SceneInstant at;
  int finer = 1;       ///< Its pixels in the place of one of the image, in a row.
  CameraModel camera;  ///< The raster of `picture` and `light`: an ideal camera at the same place.
  cv::Mat picture;     ///< As Renderer::ReadColor gives it.
  cv::Mat light;       ///< CV_32FC4: linear light of B, G, R, and nothing; row 0 on top. Empty before Decode().
  // By the image's pixels; rows are padded to a whole number of vectors.
  cv::Mat bodies;         ///< CV_32SC1; empty where only the world is in view.
  std::vector<int> seen;  ///< The numbers in `bodies` (SeenBodies).
  cv::Mat nearness;       ///< CV_32FC1, 1/m; 0 where nothing is.
};

/// An instant whose light is computed from a key picture.
struct ShearedFrame {
  const SceneInstant* at;
  Eigen::Vector2d shift_px;            ///< Every pixel looks so far beside its centre.
  std::span<const float> row_weights;  ///< Of each row of the image; rows of weight 0 cost nothing.
};

class KeyCamera {
 public:
  /// @param lens must outlive this.
  explicit KeyCamera(const Lens& lens);

  /// A key picture serves sub-frames in which no point has moved further than this, px: 8 in an image of 320 px.
  int reach_px() const { return std::max(8, lens_->camera().width_px / 40); }
  /// The raster of key pictures; it shows somewhat more than the image, so that what is followed stays within.
  CameraModel Raster(int finer) const { return Finer(lens_->pinhole(), finer, reach_px() + 2); }

  /// Renders `at`, which `data` must hold. @param finer pixels of the picture in the place of one of the image.
  /// @param shift_px of the sampling points, in pixels of the picture, so that several pictures sample differently.
  /// @param depth if wanted: what the camera sees, CV_32FC1, m; 0 where nothing is.
  KeyPicture See(Renderer& renderer, mjData& data, const SceneInstant& at, int finer, const Eigen::Vector2d& shift_px,
                 cv::Mat* depth = nullptr) const;
  /// Fills `key.light`, unless it is there. May run on another thread.
  void Decode(KeyPicture& key) const;

  /// Adds the light of several instants to an image (CV_32FC4). @pre Decode().
  void Add(const KeyPicture& key, std::span<const ShearedFrame> frames, cv::Mat& light) const;

 private:
  class Path;
  class Anchors;
  struct Row;

  void AddRow(const KeyPicture& key, std::span<const Path* const> paths, int row, cv::Mat& light) const;

  const Lens* lens_;
  int stride_;                        ///< Of the rays' rows.
  std::vector<float> ray_x_, ray_y_;  ///< X/Z and Y/Z of all pixels, each by itself; padded as `nearness` is.
};

}  // namespace gaitcam
