/// How well detectors and descriptors survive motion blur: correct matches of image pairs whose true homography is
/// known, one or both images blurred (the protocol of the thesis' figures 5.12 and 5.13).
///
/// Blur, then crop: the cropped image holds light from beyond its border, as a camera's does.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/features/features.h"
#include "algorithms/features/line_blur.h"

namespace gaitcam {

/// Where a point of the first image is truly seen in the second; nothing where that is not known.
using TrueMap = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d& pixel)>;

/// Two grey images of one plane.
struct ImagePair {
  std::string name;
  cv::Mat a, b;          ///< CV_8UC1.
  Eigen::Matrix3d H_ba;  ///< Maps pixels of a to pixels of b; centre of the first pixel (0, 0).
};

/// Pairs of a folder in the layout of the Oxford affine data set (img1.*, img2.*, ..., H1to2p, ...), or of one that
/// holds graf1.png, graf3.png and H1to3p.xml as OpenCV's examples do.
/// @throws BadInput if there is no pair, or a file cannot be read.
std::vector<ImagePair> ReadPairs(const std::filesystem::path& folder);

/// Photographs seen from two sides: each file and its image under a homography drawn from the seed.
/// @throws BadInput if a file cannot be read.
std::vector<ImagePair> MakePairs(const std::vector<std::filesystem::path>& photographs, uint64_t seed);

/// Two frames of a walk, blurred as they were filmed.
struct WalkPair {
  cv::Mat a, b;        ///< CV_8UC1.
  TrueMap map;         ///< From the truth's depth and poses; points near a jump of the depth are not known.
  double blur_px = 0;  ///< The greater of the two frames' median blur.
};

/// Pairs of a recording (TUM layout) with its truth beside it: every `stride`-th frame with the one `gap` frames later.
/// @throws BadInput if the truth is not there.
std::vector<WalkPair> ReadWalkPairs(const std::filesystem::path& dataset, int gap, int stride);

/// What happens to an image beside blur.
struct CameraSetting {
  std::string name;
  bool linear_light = false;  ///< Blur adds up light, not grey values.
  double noise_sigma = 0;     ///< Of the grey values 0 ... 255.
  int jpeg_quality = 0;       ///< 0: no compression.
};

/// "clean", "noise" (sigma 2), "realistic" (linear light, noise of sigma 2, JPEG 90).
std::vector<CameraSetting> CameraSettings();

/// Weights of a line blur, centred, with light shared among the four nearest pixels; sum 1. CV_32FC1, odd sides.
cv::Mat LineKernel(const LineBlur& blur);

/// A pixel frame this wide is cut off every image, sharp or blurred, after the blur.
constexpr int kCrop_px = 24;

/// The true map between two images after kCrop_px was cut off both.
Eigen::Matrix3d AfterCrop(const Eigen::Matrix3d& H_ba);

/// @param grey CV_8UC1, larger than two crops.
cv::Mat FilmBlurred(const cv::Mat& grey, const LineBlur& blur, const CameraSetting& setting, uint64_t seed);

/// Outcome of matching under a known homography; sums add up.
struct MatchCount {
  int matches = 0, correct = 0;      ///< Without duplicates; correct: within kCorrect_px of where H puts the point.
  int fewest_points = kAllFeatures;  ///< Key points of the image that had the fewest.
  std::vector<double> errors_px;     ///< Of the correct ones.

  void operator+=(const MatchCount& other);
  double Precision() const { return matches ? double(correct) / matches : 0; }
  double MedianError() const;  ///< NaN if there is none.
};
constexpr double kCorrect_px = 3;

/// Nearest neighbour whose distance is less than `ratio` times the second nearest's, for several ratios at once.
std::vector<MatchCount> CountMatches(const Features& a, const Features& b, const TrueMap& map,
                                     const std::vector<double>& ratios);
TrueMap MapOfHomography(const Eigen::Matrix3d& H_ba);

/// Every registered detector, and those of this experiment alone, sorted: `sift_single` is OpenCV's SIFT without the
/// points of its doubled octave; `mobif_of_light` looks for blur in light and not in grey values; of `mobif_discards`
/// features of low entropy are discarded (thesis, 5.3.2), of `mobif_adapt_all` none. @param registered_alone leaves out
/// the latter.
std::vector<std::string> ExperimentDetectors(bool registered_alone = false);

struct FeatureExperimentOptions {
  std::vector<std::string> detectors = ExperimentDetectors();
  std::vector<double> extents_px = {0, 10, 20, 30, 40};
  std::vector<double> ratios = {0.8, 0.5};
  uint64_t seed = 1;
  /// 0: what each detector finds at its own threshold, 20000 points at most. Else so many of the strongest of each
  /// image, thresholds lowered so that there are as many, if the image has them: detectors of this experiment alone
  /// cannot do that.
  int strongest = 0;
  int jobs = 0;  ///< Threads; 0: one per core.
};

/// @throws BadInput for a detector that is neither registered nor one of this experiment alone, or that has no
/// threshold to lower.
void CheckDetectors(const FeatureExperimentOptions& options);

/// Sums over all pairs.
struct FeatureCell {
  std::string detector, setting;
  double extent_px = 0, ratio = 0;
  bool both = false;  ///< Both images are blurred, in different directions.
  MatchCount count;
};

/// @throws BadInput on an unknown detector, before any work.
std::vector<FeatureCell> RunFeatureExperiment(const std::vector<ImagePair>& pairs,
                                              const FeatureExperimentOptions& options,
                                              const std::function<void(int done, int all)>& progress);

/// Sums over the pairs of a walk whose blur lies in an interval; at the first of the ratios.
struct WalkCell {
  std::string detector;
  double from_px = 0, to_px = 0;
  int pairs = 0;
  MatchCount count;
  std::optional<int> more_than_sift;  ///< Pairs with more correct matches than `sift` has; nothing without `sift`.
};

std::vector<WalkCell> RunWalkExperiment(const std::vector<WalkPair>& pairs, const FeatureExperimentOptions& options,
                                        const std::function<void(int done, int all)>& progress);

}  // namespace gaitcam
