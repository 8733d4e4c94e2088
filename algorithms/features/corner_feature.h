/// Corners of one scale, each with SIFT's description of what is around it: what older systems worked on, as a
/// detector like the others. They find the same corner again as long as the camera keeps its distance and stays level.
///
/// Sources: E. Rosten and T. Drummond, "Machine learning for high-speed corner detection", ECCV 2006 (FAST);
/// C. Harris and M. Stephens, "A combined corner and edge detector", 1988. Both as OpenCV has them.

#pragma once

#include <opencv2/features2d.hpp>

namespace gaitcam {

enum class CornerKind { kFast, kHarris };

/// FAST or Harris corners as a cv::Feature2D. Descriptors are CV_32F. Not invariant to scale or to the camera's roll.
/// Deterministic.
class CornerFeature : public cv::Feature2D {
 public:
  /// @param threshold FAST: by how much the circle's pixels must differ from its centre, grey levels, >= 1. Harris: of
  ///                  the response, in that of the strongest corner, > 0.
  static cv::Ptr<CornerFeature> create(CornerKind kind, double threshold);

  /// @param image CV_8UC1 or CV_8UC3 (BGR).
  void detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                        cv::OutputArray descriptors, bool use_provided_keypoints) override;
  int descriptorSize() const override { return 128; }
  int descriptorType() const override { return CV_32F; }
  int defaultNorm() const override { return cv::NORM_L2; }
  cv::String getDefaultName() const override { return kind_ == CornerKind::kFast ? "Fast" : "Harris"; }

 private:
  std::vector<cv::KeyPoint> Detect(const cv::Mat& grey, const cv::Mat& mask) const;

  CornerKind kind_ = CornerKind::kFast;
  double threshold_ = 20;
};

}  // namespace gaitcam
