/// Interest points and their descriptors, and every detector by name.
///
/// Source of this folder, where it says "thesis": Alberto Pretto, Visual-SLAM for Humanoid Robots, PhD thesis,
/// University of Padua: section 3.5 (features and their matching) and chapter 5 (MoBIF, features for blurred images).
///
/// All detectors are cv::Feature2D, so that they can be dropped into any OpenCV program and any cv::Feature2D into
/// ours.

#pragma once

#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

namespace gaitcam {

/// Interest points of one image; row i of `descriptors` describes `keypoints[i]`.
struct Features {
  std::vector<cv::KeyPoint> keypoints;  ///< `pt` in pixels of the image, the centre of the first pixel being (0, 0).
  cv::Mat descriptors;                  ///< CV_32FC1 (compare by Euclidean distance) or CV_8UC1 (by Hamming distance).

  int size() const { return int(keypoints.size()); }
};

/// For a number of features: as many as there are.
constexpr int kAllFeatures = std::numeric_limits<int>::max();

struct FeatureInfo {
  std::string name;
  std::string description;  ///< One line.
};

/// Names of all detectors, sorted.
std::vector<FeatureInfo> ListFeatures();

/// A detector with descriptor by name. Each call makes a new one; none has state that one image hands to the next.
/// @param sensitivity the detector's own threshold divided by this: above 1 weaker points are kept, as dim or blurred
///                    images need
/// @throws BadInput naming the unknown detector and the nearest known one.
cv::Ptr<cv::Feature2D> MakeFeature2d(const std::string& name, double sensitivity = 1);

/// Detects and describes.
/// @param image CV_8UC1 or CV_8UC3 (BGR).
/// @returns the strongest `max_features`, strongest first, in an order that depends on the image alone. None in an
/// image without texture.
Features DetectFeatures(cv::Feature2D& detector, const cv::Mat& image, int max_features);

}  // namespace gaitcam
