/// Pictures of samples and covariance ellipses.

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace gaitcam {

/// Drawn at two standard deviations.
struct PlottedEllipse {
  std::string label;
  Eigen::Vector2d centre;
  Eigen::Matrix2d covariance;
  cv::Scalar bgr;
  bool dashed = false;
};

/// One plot: all samples as dots, ellipses over them. Its axes have scales of their own, chosen so that all fits.
struct EllipsePanel {
  std::string title, x_label, y_label;  ///< Labels with units.
  std::vector<Eigen::Vector2d> samples;
  std::vector<PlottedEllipse> ellipses;
};

/// Mean and covariance of samples, as an ellipse.
PlottedEllipse EllipseOf(const std::vector<Eigen::Vector2d>& samples, const std::string& label, const cv::Scalar& bgr);

/// Panels side by side, BGR.
cv::Mat DrawPanels(const std::vector<EllipsePanel>& panels);

}  // namespace gaitcam
