#include "algorithms/planes/floor_search.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Zero-mean intensities and the mask of known cells.
struct Masked {
  cv::Mat value, known;  ///< CV_32FC1; 0 and 1.
};

Masked MaskedOf(const FloorPicture& picture) {
  Masked masked;
  masked.known = cv::Mat(picture.sightings.size(), CV_32FC1, cv::Scalar(0));
  masked.known.setTo(1, picture.sightings > 0);
  picture.intensity.convertTo(masked.value, CV_32F);
  masked.value = (masked.value - cv::mean(masked.value, picture.sightings > 0)[0]).mul(masked.known);
  return masked;
}

/// Spectra of x, x^2 and the mask, padded so that no shift wraps round.
struct Spectra {
  cv::Mat value, square, known;

  Spectra(const Masked& masked, const cv::Size& size) {
    value = Of(masked.value, size);
    square = Of(masked.value.mul(masked.value), size);
    known = Of(masked.known, size);
  }
  static cv::Mat Of(const cv::Mat& picture, const cv::Size& size) {
    cv::Mat padded, spectrum;
    cv::copyMakeBorder(picture, padded, 0, size.height - picture.rows, 0, size.width - picture.cols,
                       cv::BORDER_CONSTANT, 0);
    cv::dft(padded, spectrum, cv::DFT_COMPLEX_OUTPUT);
    return spectrum;
  }
};

/// sum over cells of a(cell + shift) b(cell), for all shifts.
cv::Mat Correlate(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat product, sum;
  cv::mulSpectrums(a, b, product, 0, true);
  cv::dft(product, sum, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return sum;
}

/// Per shift, the correlation of the common cells; -1 where they are too few or have no contrast.
cv::Mat CorrelationOf(const Spectra& map, const Spectra& submap, int min_cells) {
  const cv::Mat n = cv::max(Correlate(map.known, submap.known), 1);
  const cv::Mat a = Correlate(map.value, submap.known), b = Correlate(map.known, submap.value);
  const cv::Mat aa = Correlate(map.square, submap.known) - a.mul(a) / n;
  const cv::Mat bb = Correlate(map.known, submap.square) - b.mul(b) / n;
  const cv::Mat ab = Correlate(map.value, submap.value) - a.mul(b) / n;
  constexpr float kMinVariance = 4;  // grey levels squared, per cell
  cv::Mat result(n.size(), CV_32FC1);
  for (int y = 0; y < n.rows; ++y) {
    for (int x = 0; x < n.cols; ++x) {
      const float count = n.at<float>(y, x), va = aa.at<float>(y, x), vb = bb.at<float>(y, x);
      const bool enough = count >= float(min_cells) && va > kMinVariance * count && vb > kMinVariance * count;
      result.at<float>(y, x) = enough ? ab.at<float>(y, x) / std::sqrt(va * vb) : -1.0F;
    }
  }
  return result;
}

/// The submap, rotated about its centre.
Masked Turned(const Masked& submap, double angle_rad) {
  const cv::Size2d size(submap.value.size());
  const int side = int(std::ceil(std::hypot(size.width, size.height)));
  // Rows count downwards and y upwards: a rotation to the left in the world is one to the left in the image.
  cv::Mat turn =
      cv::getRotationMatrix2D(cv::Point2d(0.5 * (size.width - 1), 0.5 * (size.height - 1)), angle_rad * 180 / CV_PI, 1);
  turn.at<double>(0, 2) += 0.5 * (side - size.width);
  turn.at<double>(1, 2) += 0.5 * (side - size.height);
  Masked turned;
  cv::warpAffine(submap.value, turned.value, turn, {side, side}, cv::INTER_LINEAR);
  cv::warpAffine(submap.known, turned.known, turn, {side, side}, cv::INTER_LINEAR);
  cv::threshold(turned.known, turned.known, 0.99, 1, cv::THRESH_BINARY);
  turned.value = turned.value.mul(turned.known);
  return turned;
}

/// Centre of the picture, m.
Eigen::Vector2d MiddleOf(const FloorPicture& picture) {
  return picture.corner_m +
         0.5 * picture.cell_m * Eigen::Vector2d(picture.intensity.cols - 1, 1 - picture.intensity.rows);
}

void AddPeaks(const cv::Mat& correlation, const FloorPicture& map, int side, const FloorSearchRange& range,
              const Eigen::Vector2d& expected, const Eigen::Vector2d& middle, double heading,
              std::vector<FloorFind>& finds) {
  const auto at = [&](int y, int x) {  // shifts below 0 come from the other end
    const int rows = correlation.rows, cols = correlation.cols;
    return correlation.at<float>((y + rows) % rows, (x + cols) % cols);
  };
  for (int y = 1 - side; y < map.intensity.rows; ++y) {
    for (int x = 1 - side; x < map.intensity.cols; ++x) {
      const float here = at(y, x);
      if (here <= 0 || here < at(y - 1, x) || here < at(y + 1, x) || here < at(y, x - 1) || here < at(y, x + 1))
        continue;
      const Eigen::Vector2d cells(x + 0.5 * (side - 1), -(y + 0.5 * (side - 1)));
      const Eigen::Vector2d there = map.corner_m + map.cell_m * cells;
      if ((there - expected).norm() > range.reach_m) continue;
      finds.push_back({PlanarPose(there - Rotate(middle, heading), heading), double(here)});
    }
  }
}

}  // namespace

std::vector<FloorFind> SearchFloor(const FloorPicture& map, const FloorPicture& submap, const FloorSearchRange& range,
                                   int min_cells, int max_finds) {
  GAITCAM_ASSERT(range.step_rad > 0);
  if (map.empty() || submap.empty()) return {};
  GAITCAM_ASSERT(std::abs(map.cell_m - submap.cell_m) < 1e-9);
  const Masked whole = MaskedOf(map), part = MaskedOf(submap);
  const int side = int(std::ceil(std::hypot(part.value.cols, part.value.rows)));
  const cv::Size size(cv::getOptimalDFTSize(whole.value.cols + side), cv::getOptimalDFTSize(whole.value.rows + side));
  const Spectra of_map(whole, size);
  const Eigen::Vector2d middle = MiddleOf(submap), expected = range.X_MS * middle;
  std::vector<FloorFind> all;
  const int turns = int(std::floor(range.reach_rad / range.step_rad));
  for (int turn = -turns; turn <= turns; ++turn) {
    const double heading = range.X_MS.heading + turn * range.step_rad;
    const Spectra of_submap(Turned(part, heading), size);
    AddPeaks(CorrelationOf(of_map, of_submap, min_cells), map, side, range, expected, middle, heading, all);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const FloorFind& a, const FloorFind& b) { return a.correlation > b.correlation; });
  std::vector<FloorFind> finds;
  for (const FloorFind& find : all) {
    const bool known = std::any_of(finds.begin(), finds.end(), [&](const FloorFind& better) {
      return (better.X_MS * middle - find.X_MS * middle).norm() < 3 * map.cell_m;
    });
    if (!known) finds.push_back(find);
    if (int(finds.size()) == max_finds) break;
  }
  return finds;
}

}  // namespace gaitcam
