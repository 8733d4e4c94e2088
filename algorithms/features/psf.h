/// Estimators of an image's point spread function, behind one interface.
///
/// Three use the image alone and are made by name: "whitening" (the thesis, section 5.2.1), "spectral" and
/// "spectral_light". Two use other data and are constructed from these: InertialPsf (psf_inertial.h) from gyroscope
/// readings, OraclePsf (psf_oracle.h) from the ground truth, for experiments.

#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/features/line_blur.h"

namespace gaitcam {

class PsfEstimator {
 public:
  virtual ~PsfEstimator() = default;

  /// The one blur that fits a part of an image best. Has no state: the same image gives the same bits.
  /// @param grey CV_8UC1, not empty.
  /// @param region the part to evaluate; clipped to the image. Too small a part (each estimator says) gives blurred ==
  /// false and confidence 0.
  virtual BlurEstimate Estimate(const cv::Mat& grey, const cv::Rect& region) const = 0;

  /// The same of the whole image.
  BlurEstimate EstimateWhole(const cv::Mat& grey) const { return Estimate(grey, cv::Rect({0, 0}, grey.size())); }
};

struct PsfEstimatorInfo {
  std::string name;
  std::string description;  ///< One line.
};

/// The estimators that need the image alone, sorted by name.
std::vector<PsfEstimatorInfo> ListPsfEstimators();

/// An estimator with its default options.
/// @throws BadInput naming the unknown estimator and the nearest known one.
std::unique_ptr<PsfEstimator> MakePsfEstimator(const std::string& name);

}  // namespace gaitcam
