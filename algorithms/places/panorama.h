/// Panoramas of 360 degrees: the frames of a pan scan projected onto a cylinder and stitched.
///
/// Source: Alberto Pretto, Visual-SLAM for Humanoid Robots, PhD thesis, University of Padua, chapter 4 ("Image
/// Similarity for Image-Based Topological SLAM"), section 4.3. It is meant wherever this folder says "thesis".
///
/// The cylinder's axis is the vertical through the camera's centre. With azimuth a, left positive, and elevation e,
/// columns are equally spaced in a and rows in tan e, as those of a perspective image are in its middle column;
/// vertical lines stay vertical. Column 0 lies to the left of straight back, columns grow to the right, and the middle
/// of the image, between columns width / 2 - 1 and width / 2, is straight ahead as the scan began. A single view is
/// projected onto the same cylinder, so that it can be found in the panorama without scaling.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"

namespace gaitcam {

struct PanoramaLayout {
  int width_px = 720;  ///< 360 degrees: 2 px per degree as the ERS-7's; the KHR-1HV's had 1830.
  int height_px = 160;
  double tan_low = -0.4;  ///< Tangent of the elevation of the lower edge of the lowest row ...
  double tan_high = 0.4;  ///< ... and of the upper edge of the highest one.

  double px_per_rad() const;
  double AzimuthOf(double column) const;  ///< rad, left positive, 0 straight ahead; not wrapped.
  double ColumnOf(double azimuth_rad) const;
  double TanElevationOf(double row) const;

  /// @throws BadOption
  void Check() const;
};

/// The rows that a view fills: the layout of `width_px` x `height_px` onto which a view of this camera projects with
/// the largest area without holes. @param up_C the vertical in the camera's frame. @throws BadInput if the camera is
/// pitched too steeply for a panorama.
PanoramaLayout LayoutFor(const CameraModel& camera, const Eigen::Vector3d& up_C, int width_px, int height_px);

/// Horizontal and vertical axes in a camera's frame: forward, left, up.
struct LevelAxes {
  Eigen::Vector3d forward, left, up;

  /// @throws BadInput if the camera is pitched too steeply to have a heading.
  explicit LevelAxes(const Eigen::Vector3d& up_C);
  Eigen::Vector3d Ray(double azimuth_rad, double tan_elevation) const;
};

/// Projects frames of one camera onto the cylinder.
class CylinderProjection {
 public:
  /// @throws BadInput if a view does not fill the layout's rows, or the camera is pitched too steeply.
  CylinderProjection(const CameraModel& camera, const Eigen::Vector3d& up_C, const PanoramaLayout& layout);

  /// A view as a section of a panorama: CV_8UC1, layout's height, width_px() wide, no holes; the optical axis is in its
  /// middle column. @param image CV_8UC1 or CV_8UC3 of the camera's size; @throws BadInput if it is not.
  cv::Mat ProjectView(const cv::Mat& image) const;
  /// The same for a camera that sways: `up_C` is the vertical at this instant. Rows outside the image repeat its
  /// border.
  cv::Mat ProjectView(const cv::Mat& image, const Eigen::Vector3d& up_C) const;
  int width_px() const { return view_.x.cols; }
  /// To either side of the optical axis all rows of the layout are seen up to here, rad.
  double half_width_rad() const { return half_width_rad_; }

  /// The image that is projected: grey, and reduced by averaging where it is much finer than the panorama.
  cv::Mat Prepare(const cv::Mat& image) const;
  /// `columns` columns to the right of `azimuth_rad`, which is relative to the optical axis, from a prepared image.
  /// CV_8UC1.
  cv::Mat Strip(const cv::Mat& prepared, double azimuth_rad, int columns) const;

 private:
  struct Map {
    cv::Mat x, y;  ///< CV_32FC1: where each pixel of the cylinder lies in the prepared image.
  };
  Map MapOf(const LevelAxes& axes, double azimuth_rad, int columns) const;
  bool IsSeen(double azimuth_rad) const;

  PanoramaLayout layout_;
  CameraModel camera_, prepared_;  ///< Of the images given, and of the prepared ones.
  LevelAxes axes_;
  double half_width_rad_ = 0;
  Map view_;
};

struct PanoramaOptions {
  using DescribedTag = void;
  double blend_deg = 2;       ///< Two neighbouring frames are blended over this width, or their distance if it is less.
  double min_step_deg = 0.5;  ///< A frame nearer than this to one before it adds nothing.
  double search_deg = 4;      ///< Largest seam error that is searched for.
};

template <class Visitor>
void VisitFields(Visitor& visit, PanoramaOptions& o) {
  visit("blend_deg", o.blend_deg, Between(0.01, 90.0), "width over which neighbouring frames are blended");
  visit("min_step_deg", o.min_step_deg, Between(0.0, 30.0), "a frame nearer to one before it is left out");
  visit("search_deg", o.search_deg, Between(0.5, 20.0), "largest seam error that is searched for");
}

struct Panorama {
  cv::Mat image;                 ///< CV_8UC1
  int frames = 0;                ///< That were stitched.
  std::vector<double> seams_px;  ///< Of each seam with enough contrast: offset of the right frame's content against the
                                 ///< left one's, positive to the right.
  double mean_seam_error_px = 0;  ///< Mean magnitude.
  double max_seam_error_px = 0;
  double gain_spread = 1;  ///< Greatest over least gain of the exposure compensation.
};

/// Stitches one panorama from frames with known azimuths, one at a time.
class PanoramaBuilder {
 public:
  PanoramaBuilder(const CylinderProjection& projection, const PanoramaLayout& layout,
                  const PanoramaOptions& options = {});

  /// @param yaw_rad azimuth of the optical axis against straight ahead: pan of the head plus turn of the body.
  void Add(const cv::Mat& image, double yaw_rad);
  /// Frames that are kept.
  int frames() const { return int(frames_.size()); }
  /// Degrees of 360 that no frame has seen yet.
  double missing_deg() const;
  /// @throws TooLittleData saying how many degrees are missing.
  Panorama Finish() const;

 private:
  struct Frame {
    double yaw_rad = 0;  ///< In [-pi, pi).
    cv::Mat image;       ///< Prepared.
  };
  /// Two neighbouring frames compared where they overlap.
  struct Seam {
    bool known = false;
    double error_px = 0, log_ratio = 0;  ///< log of left brightness over right
  };

  size_t Next(size_t i) const { return (i + 1) % frames_.size(); }
  double Gap(size_t i) const;  ///< From frame i to the next one to the right, rad.
  Seam Judge(size_t i) const;
  std::vector<double> Gains(const std::vector<Seam>& seams) const;
  void Draw(size_t i, double gain, cv::Mat& sum, cv::Mat& weights) const;

  const CylinderProjection& projection_;
  PanoramaLayout layout_;
  PanoramaOptions options_;
  std::vector<Frame> frames_;  ///< From left to right: by falling yaw.
};

}  // namespace gaitcam
