/// Blur along a path that is bent, or run through unevenly, from the power spectrum alone.
///
/// A line's spectrum has zeros at equal steps, and psf_spectral.h looks for these. A path whose speed or direction
/// changes has none; but its |H|^2 is known once the path is, so the path is found whose |H|^2 agrees best with the
/// logarithm of the image's power. What pictures have of their own, a slope over the frequency and a preference for
/// some directions, is taken out of both before they are compared. The spectrum has no phases: a path and the same one
/// turned by half a turn have the same, and a second look at the image decides (CompareEdges).

#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "algorithms/features/blur_path.h"
#include "algorithms/features/log_spectrum.h"

namespace gaitcam {

struct PathFit {
  BlurPath path;         ///< Its mean over time is (0, 0).
  double agreement = 0;  ///< Correlation of the path's log power with the image's, pictures' own part left out.
};

/// Root mean square distance of two paths' places at the same times, whichever way they were run through and turned: 0
/// for paths of one |H|^2 whose speed is even. px.
double PathDistance(const BlurPath& a, const BlurPath& b);

class PathSpectrum {
 public:
  static constexpr int kWindow_px = 256;

  /// @param image CV_32FC1 in the units that the blur acted on, white being 1; at least 64 x 64 px.
  explicit PathSpectrum(const cv::Mat& image);

  bool empty() const { return samples_.empty(); }  ///< No contrast.

  /// How far the image's log power departs from a picture's, root mean square.
  double depth() const { return empty() ? 0 : double(bands_.back().depth); }

  /// How well a path explains the spectrum; -1 if empty().
  double Agreement(const BlurPath& path) const;

  /// The best path near one that is known roughly. @param modes by which it may differ, each a half-wave more over the
  /// exposure: 1 moves the ends apart, 2 bends or speeds up.
  PathFit Refine(const BlurPath& start, int modes) const { return Refine(start, modes, kBands - 1); }

  /// The best path there is: bent and uneven lines of all lengths and directions, compared first.
  PathFit Search(double min_extent_px, double max_extent_px) const;

 private:
  static constexpr int kBands = 3;
  /// Frequencies up to a limit: the lower ones are hardly moved by what is small of a path, and lead to the higher
  /// ones.
  struct Band {
    long samples = 0;         ///< The first so many.
    int reach = 0;            ///< Highest frequency, in parts of 1 / kWindow_px.
    float depth = 0;          ///< Root mean square of `seen` before it was scaled, natural logarithms of power.
    Eigen::MatrixXf picture;  ///< Orthonormal columns: what pictures have of their own.
    Eigen::VectorXf seen;     ///< The image's log power without these, scaled to length 1.
  };

  Band MakeBand(double highest) const;
  PathFit Refine(const BlurPath& start, int modes, int band) const;
  Eigen::VectorXf Model(const BlurPath& path, const Band& band) const;

  std::vector<SpectrumSample> samples_;  ///< In the order of their radius.
  std::vector<cv::Point> places_;        ///< Of the samples in PathTransfer's plane.
  std::vector<float> floors_;            ///< Of each ring.
  std::vector<Band> bands_;
};

/// Mean absolute over root mean square difference of neighbouring pixels: small where edges are few and strong. Of an
/// image, of the same restored, and restored along the path turned by half a turn: the wrong one of both has echoes,
/// which are edges too.
struct EdgeSpreads {
  double image = 1, restored = 1, half_turned = 1;
};
/// @param image CV_32FC1, as PathSpectrum; its middle, at most 400 pixels square, is evaluated.
EdgeSpreads CompareEdges(const cv::Mat& image, const BlurPath& path);

/// What the image alone says of a blur along any path.
struct PathEstimate {
  BlurPath path;           ///< Empty if the image has no contrast, or is smaller than 64 x 64 px.
  bool straight = false;   ///< The line that was given explains the image as well.
  bool of_light = false;   ///< The blur acted on light (light_response.h): its spectrum agrees better.
  double agreement = 0;    ///< PathFit's.
  double depth = 0;        ///< Of the image's log power, what the path explains: root mean square, natural logarithm.
  double orientation = 0;  ///< Logarithm of how much fewer edges the path has than the one turned by half a turn,
  double sharpened = 0;    ///< and than the image.
  double confidence = 0;   ///< Share of such estimates by which an image gains when it is restored.
};

/// Takes a second or two.
/// @param grey CV_8UC1. @param line what a line was found to be (psf_spectral.h).
PathEstimate EstimatePath(const cv::Mat& grey, const LineBlur& line);

/// Whether the blur of known paths acted on light. @param regions as RestoreRegions.
bool PathsActedOnLight(const cv::Mat& grey, const std::vector<BlurRegion>& regions);

}  // namespace gaitcam
