/// Seeing all around from where the robot stands: frames of a camera that pans, laid onto a cylinder (thesis, 4.3).
///
/// The cylinder stands upright about the camera's centre. With azimuth a, left positive, and elevation e, its columns
/// are equally spaced in a and its rows in tan e, as those of a perspective image are in its middle column; verticals
/// stay verticals. Column 0 lies to the left of straight back, columns grow to the right, and the middle of the image,
/// between columns width / 2 - 1 and width / 2, is straight ahead as the scan began. A single view is laid onto the
/// same cylinder, so that it is found again in the panorama without being scaled.

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
/// the largest area without holes. @param up_C the vertical in the camera's frame. @throws BadInput if the camera looks
/// too steeply up or down to see all around.
PanoramaLayout LayoutFor(const CameraModel& camera, const Eigen::Vector3d& up_C, int width_px, int height_px);

/// Level axes in a camera's frame: where it looks, its left, and up.
struct LevelAxes {
  Eigen::Vector3d forward, left, up;

  /// @throws BadInput if the camera looks too steeply up or down for a heading.
  explicit LevelAxes(const Eigen::Vector3d& up_C);
  Eigen::Vector3d Ray(double azimuth_rad, double tan_elevation) const;
};

/// Lays frames of one camera onto the cylinder.
class CylinderProjection {
 public:
  /// @throws BadInput if a view does not fill the layout's rows, or looks too steeply up or down.
  CylinderProjection(const CameraModel& camera, const Eigen::Vector3d& up_C, const PanoramaLayout& layout);

  /// A view as a piece of a panorama: CV_8UC1, layout's height, width_px() wide, no holes; its middle is where the
  /// camera looks. @param image CV_8UC1 or CV_8UC3 of the camera's size; @throws BadInput if it is not.
  cv::Mat ProjectView(const cv::Mat& image) const;
  /// The same of a camera that sways: `up_C` is the vertical as it is now. As wide as ever; rows that the camera has
  /// turned away from repeat the last one that it sees.
  cv::Mat ProjectView(const cv::Mat& image, const Eigen::Vector3d& up_C) const;
  int width_px() const { return view_.x.cols; }
  /// So far to either side of the optical axis all rows are seen, rad.
  double half_width_rad() const { return half_width_rad_; }

  /// The camera's image as it is projected: grey, and shrunk where it is much finer than the panorama.
  cv::Mat Prepare(const cv::Mat& image) const;
  /// Columns to the right of `azimuth_rad` against the camera's, from a prepared image. CV_8UC1.
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
  double search_deg = 4;      ///< Seam errors are looked for up to here.
};

template <class Visitor>
void VisitFields(Visitor& visit, PanoramaOptions& o) {
  visit("blend_deg", o.blend_deg, Between(0.01, 90.0), "width over which neighbouring frames are blended");
  visit("min_step_deg", o.min_step_deg, Between(0.0, 30.0), "a frame nearer to one before it is left out");
  visit("search_deg", o.search_deg, Between(0.5, 20.0), "seam errors are looked for up to here");
}

struct Panorama {
  cv::Mat image;                  ///< CV_8UC1
  int frames = 0;                 ///< It is made of.
  std::vector<double> seams_px;   ///< For each seam that could be judged: how far the right frame's picture lies to the
                                  ///< right of where the left one's goes on.
  double mean_seam_error_px = 0;  ///< Mean magnitude.
  double max_seam_error_px = 0;
  double gain_spread = 1;  ///< Brightest frame's exposure over the darkest one's, as evened out.
};

/// Stitches one panorama from frames with known azimuths, one at a time.
class PanoramaBuilder {
 public:
  PanoramaBuilder(const CylinderProjection& projection, const PanoramaLayout& layout,
                  const PanoramaOptions& options = {});

  /// @param yaw_rad azimuth of the optical axis against straight ahead: pan and turn of the body together.
  void Add(const cv::Mat& image, double yaw_rad);
  /// Frames that were of use.
  int frames() const { return int(frames_.size()); }
  /// What no frame has seen yet, of 360.
  double missing_deg() const;
  /// @throws TooLittleData saying how many degrees are missing.
  Panorama Finish() const;

 private:
  struct Frame {
    double yaw_rad = 0;  ///< In [-pi, pi).
    cv::Mat image;       ///< Prepared.
  };
  /// Of one pair of neighbours, by what both see.
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
  std::vector<Frame> frames_;  ///< From left to right: yaw falls.
};

}  // namespace gaitcam
