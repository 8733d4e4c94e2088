/// Base of the detectors that account for motion blur: a cv::Feature2D that can be given the blur (from a gyroscope, or
/// the ground truth) instead of estimating it.

#pragma once

#include <opencv2/features2d.hpp>
#include <optional>
#include <vector>

#include "algorithms/features/features.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// What a detector does with saddle points of the Hessian's determinant, corners between blobs.
enum class SaddleUse {
  kByStrength,  ///< They are features as blobs are.
  kAfterBlobs,  ///< They are features, each held to be weaker than all blobs.
  kNone,
};

class BlurAwareFeature : public cv::Feature2D {
 public:
  /// Uses this as the whole image's blur from now on, with confidence 1; nullopt: estimate it again.
  void SetBlur(const std::optional<LineBlur>& blur);
  /// The same for an image whose parts have a blur of their own. Regions cover the images to come; none: estimate
  /// again.
  void SetBlurRegions(const std::vector<BlurRegion>& regions) { known_ = regions; }
  /// Images with a shorter blur are taken as they are from now on; of a length that no image has: all of them.
  /// @throws BadOption of a detector that has no such limit.
  virtual void SetMinBlur(double extent_px);
  /// Of the images to come, kByStrength until it is said; nothing changes for a detector that has no saddle points.
  virtual void SetSaddleUse(SaddleUse) {}

  /// OpenCV's entry. Keypoints cannot be handed in (cv::Exception): they would have to come from the same scale space.
  /// @param image CV_8UC1 or CV_8UC3 (BGR); an empty one has no features.
  /// @param mask 0 where no keypoint shall be; empty: everywhere.
  void detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                        cv::OutputArray descriptors, bool use_provided_keypoints = false) override;
  void detect(cv::InputArray image, std::vector<cv::KeyPoint>& keypoints, cv::InputArray mask) override;

  /// The features of largest response, and few others: those of the `most` largest are all there.
  /// @param grey CV_8UC1, not empty.
  Features ExtractStrongest(const cv::Mat& grey, int most) { return Extract(grey, most); }

  int descriptorType() const override { return CV_32FC1; }
  int defaultNorm() const override { return cv::NORM_L2; }

 protected:
  /// @param grey CV_8UC1, not empty.
  /// @param most only so many of largest response are wanted, more may come; kAllFeatures: all.
  virtual Features Extract(const cv::Mat& grey, int most) = 0;

  /// What was set, for an image of this size; empty if nothing was.
  std::vector<BlurRegion> KnownRegions(const cv::Size& image) const;

 private:
  std::vector<BlurRegion> known_;
};

}  // namespace gaitcam
