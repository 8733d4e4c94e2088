/// SURF with 64 numbers (Bay, Ess, Tuytelaars and Van Gool, CVIU 110, 2008) as dlib implements it.

#pragma once

#include <opencv2/features2d.hpp>

namespace gaitcam {

/// dlib's SURF as a cv::Feature2D. Descriptors are CV_32F, of length 1. Deterministic.
class Surf : public cv::Feature2D {
 public:
  /// @param threshold of the Hessian's determinant in dlib's units (its own default is 30), > 0.
  static cv::Ptr<Surf> create(double threshold = 30);

  /// @param image CV_8UC1 or CV_8UC3 (BGR).
  void detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                        cv::OutputArray descriptors, bool use_provided_keypoints) override;
  int descriptorSize() const override { return 64; }
  int descriptorType() const override { return CV_32F; }
  int defaultNorm() const override { return cv::NORM_L2; }
  cv::String getDefaultName() const override { return "Surf"; }

 private:
  double threshold_ = 30;
};

}  // namespace gaitcam
