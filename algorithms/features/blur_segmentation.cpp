#include "algorithms/features/blur_segmentation.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// Sample points on a grid, with the histogram of each.
struct SampleGrid {
  int columns = 0, rows = 0, step_px = 0, bins = 0;
  std::vector<float> histograms;  ///< columns * rows, each of `bins`, normalised to a unit vector.

  int size() const { return columns * rows; }
  const float* Histogram(int i) const { return histograms.data() + size_t(i) * size_t(bins); }
  cv::Point2d Position(int i) const { return {(i % columns + 0.5) * step_px, (i / columns + 0.5) * step_px}; }
  cv::Rect Cell(int i) const { return {i % columns * step_px, i / columns * step_px, step_px, step_px}; }
};

/// Step 1. The derivatives of a point alone say little: those of its cell are added up.
SampleGrid SampleHistograms(const cv::Mat& values, const BlurSegmentationOptions& options) {
  constexpr int kInnerStep = 3;  // px, between derivatives in a cell
  SampleGrid grid;
  grid.step_px = options.sample_step_px;
  grid.columns = values.cols / grid.step_px;
  grid.rows = values.rows / grid.step_px;
  grid.bins = options.directions;
  for (int i = 0; i < grid.size(); ++i) {
    const std::vector<double> sums = DirectionalDerivatives(values, grid.Cell(i), grid.bins, kInnerStep);
    const double norm = std::sqrt(std::inner_product(sums.begin(), sums.end(), sums.begin(), 0.0));
    for (const double sum : sums) grid.histograms.push_back(norm > 0 ? float(sum / norm) : 0.0f);
  }
  return grid;
}

struct Centroid {
  cv::Point2d position;
  int bin = 0;  ///< Of the direction.
  std::vector<double> histogram;
  int members = 0;
};

/// Step 2.
std::vector<Centroid> FirstCentroids(const SampleGrid& grid, const cv::Size& image, int clusters) {
  std::vector<double> total(size_t(grid.bins), 0.0);
  for (int i = 0; i < grid.size(); ++i) {
    for (int b = 0; b < grid.bins; ++b) total[size_t(b)] += double(grid.Histogram(i)[b]);
  }
  std::vector<int> order(total.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return total[size_t(a)] < total[size_t(b)]; });
  std::vector<Centroid> centroids;
  for (int k = 0; k < clusters; ++k) {
    centroids.push_back({{image.width / 2.0, image.height / 2.0}, order[size_t(k) % order.size()], {}, 0});
  }
  return centroids;
}

/// Step 3, equation 5.17.
cv::Mat Assign(const SampleGrid& grid, const std::vector<Centroid>& centroids) {
  cv::Mat labels(grid.rows, grid.columns, CV_8UC1);
  for (int i = 0; i < grid.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < centroids.size(); ++k) {
      const cv::Point2d d = centroids[k].position - grid.Position(i);
      const double distance = double(grid.Histogram(i)[centroids[k].bin]) * std::hypot(d.x, d.y);
      if (distance < least) {
        least = distance;
        labels.at<uchar>(i / grid.columns, i % grid.columns) = uchar(k);
      }
    }
  }
  return labels;
}

/// Step 4. A tie keeps the point's own label if that is among the most frequent ones.
cv::Mat ModeFilter(const cv::Mat& labels, int clusters) {
  cv::Mat filtered = labels.clone();
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      std::vector<int> votes(size_t(clusters), 0);
      for (int v = std::max(0, y - 1); v <= std::min(labels.rows - 1, y + 1); ++v) {
        for (int u = std::max(0, x - 1); u <= std::min(labels.cols - 1, x + 1); ++u) {
          if (u != x || v != y) ++votes[labels.at<uchar>(v, u)];
        }
      }
      const auto most = std::max_element(votes.begin(), votes.end());
      if (votes[labels.at<uchar>(y, x)] < *most) filtered.at<uchar>(y, x) = uchar(most - votes.begin());
    }
  }
  return filtered;
}

/// Steps 5 and 6. A cluster without members keeps its centroid.
void UpdateCentroids(const SampleGrid& grid, const cv::Mat& labels, std::vector<Centroid>& centroids) {
  std::vector<cv::Point2d> sums(centroids.size());
  for (Centroid& c : centroids) {
    c.histogram.assign(size_t(grid.bins), 0.0);
    c.members = 0;
  }
  for (int i = 0; i < grid.size(); ++i) {
    const size_t k = labels.at<uchar>(i / grid.columns, i % grid.columns);
    sums[k] += grid.Position(i);
    ++centroids[k].members;
    for (int b = 0; b < grid.bins; ++b) centroids[k].histogram[size_t(b)] += double(grid.Histogram(i)[b]);
  }
  for (size_t k = 0; k < centroids.size(); ++k) {
    Centroid& c = centroids[k];
    if (c.members == 0) continue;
    c.position = sums[k] / double(c.members);
    c.bin = int(std::min_element(c.histogram.begin(), c.histogram.end()) - c.histogram.begin());
  }
}

/// Step 8, of the pixels of one cluster.
BlurEstimate ClusterEstimate(const cv::Mat& grey, const SampleGrid& grid, const cv::Mat& labels, int cluster,
                             const Centroid& centroid, const WhiteningPsf& whitening) {
  cv::Mat mask(grey.size(), CV_8UC1, cv::Scalar(0));
  for (int i = 0; i < grid.size(); ++i) {
    if (labels.at<uchar>(i / grid.columns, i % grid.columns) == cluster) mask(grid.Cell(i)).setTo(255);
  }
  return whitening.EstimateExtent(grey, mask, LeastDirection(centroid.histogram));
}

/// Two clusters with the same blur are one: the smallest two bins usually are neighbours.
bool MergeNearest(std::vector<Centroid>& centroids, const std::vector<BlurEstimate>& estimates, cv::Mat& labels,
                  const BlurSegmentationOptions& options) {
  for (size_t a = 0; a < estimates.size(); ++a) {
    for (size_t b = a + 1; b < estimates.size(); ++b) {
      const LineBlur &first = estimates[a].blur, &second = estimates[b].blur;
      const bool sharp = !estimates[a].blurred && !estimates[b].blurred;
      const bool near = first.DirectionError(second) * 180 / M_PI < options.merge_direction_deg &&
                        std::abs(first.extent_px - second.extent_px) < options.merge_extent_px;
      if (!sharp && !near) continue;
      for (auto label = labels.begin<uchar>(); label != labels.end<uchar>(); ++label) {
        if (*label == b) *label = uchar(a);
        if (*label > b) --*label;
      }
      centroids.erase(centroids.begin() + long(b));
      return true;
    }
  }
  return false;
}

void DropEmpty(std::vector<Centroid>& centroids, cv::Mat& labels) {
  for (size_t k = centroids.size(); k-- > 0;) {
    if (centroids[k].members > 0) continue;
    centroids.erase(centroids.begin() + long(k));
    for (auto label = labels.begin<uchar>(); label != labels.end<uchar>(); ++label) {
      if (*label > k) --*label;
    }
  }
}

/// Step 9: the rectangle is cut in two between the centroids, across the axis along which they lie further apart, until
/// each part has one centroid.
void Divide(const cv::Rect& rectangle, std::vector<int> clusters, const BlurClusters& found,
            std::vector<BlurRegion>& regions) {
  if (clusters.size() == 1) {
    regions.push_back({rectangle, found.estimates[size_t(clusters[0])]});
    return;
  }
  const auto at = [&](int k) { return found.centroids[size_t(k)]; };
  const auto spread = [&](auto coordinate) {
    const auto [low, high] = std::minmax_element(clusters.begin(), clusters.end(),
                                                 [&](int a, int b) { return coordinate(at(a)) < coordinate(at(b)); });
    return coordinate(at(*high)) - coordinate(at(*low));
  };
  const auto x_of = [](const cv::Point2d& p) { return p.x; };
  const auto y_of = [](const cv::Point2d& p) { return p.y; };
  const bool across = spread(x_of) >= spread(y_of);
  const auto along = [&](int k) { return across ? at(k).x : at(k).y; };
  std::stable_sort(clusters.begin(), clusters.end(), [&](int a, int b) { return along(a) < along(b); });
  // Cut in the widest gap.
  size_t cut = 1;
  for (size_t i = 1; i < clusters.size(); ++i) {
    if (along(clusters[i]) - along(clusters[i - 1]) > along(clusters[cut]) - along(clusters[cut - 1])) cut = i;
  }
  const int start = across ? rectangle.x : rectangle.y, length = across ? rectangle.width : rectangle.height;
  const int where = std::clamp(int(std::lround(0.5 * (along(clusters[cut]) + along(clusters[cut - 1])))) - start, 1,
                               std::max(1, length - 1));
  cv::Rect first = rectangle, second = rectangle;
  (across ? first.width : first.height) = where;
  (across ? second.x : second.y) += where;
  (across ? second.width : second.height) -= where;
  Divide(first, {clusters.begin(), clusters.begin() + long(cut)}, found, regions);
  Divide(second, {clusters.begin() + long(cut), clusters.end()}, found, regions);
}

}  // namespace

BlurClusters ClusterBlur(const cv::Mat& grey, const BlurSegmentationOptions& options) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  CheckFields(options);
  cv::Mat values;
  grey.convertTo(values, CV_32F);
  const SampleGrid grid = SampleHistograms(values, options);
  BlurClusters found;
  if (grid.size() == 0) {
    found.estimates.push_back({});
    found.centroids.push_back({grey.cols / 2.0, grey.rows / 2.0});
    return found;
  }
  std::vector<Centroid> centroids = FirstCentroids(grid, grey.size(), options.clusters);
  for (int i = 0; i < options.max_iterations; ++i) {
    const cv::Mat labels = ModeFilter(Assign(grid, centroids), options.clusters);
    const bool same = !found.labels.empty() && cv::countNonZero(labels != found.labels) == 0;
    found.labels = labels;
    UpdateCentroids(grid, found.labels, centroids);
    if (same) break;
  }
  DropEmpty(centroids, found.labels);
  const WhiteningPsf whitening(options.extent);
  do {
    UpdateCentroids(grid, found.labels, centroids);
    found.estimates.clear();
    for (size_t k = 0; k < centroids.size(); ++k) {
      found.estimates.push_back(ClusterEstimate(grey, grid, found.labels, int(k), centroids[k], whitening));
    }
  } while (MergeNearest(centroids, found.estimates, found.labels, options));
  for (const Centroid& c : centroids) found.centroids.push_back(c.position);
  return found;
}

std::vector<BlurRegion> SegmentBlur(const cv::Mat& grey, const BlurSegmentationOptions& options) {
  const BlurClusters found = ClusterBlur(grey, options);
  std::vector<int> all(found.estimates.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<BlurRegion> regions;
  Divide({{0, 0}, grey.size()}, all, found, regions);
  std::stable_sort(regions.begin(), regions.end(), [](const BlurRegion& a, const BlurRegion& b) {
    return std::pair(a.rectangle.y, a.rectangle.x) < std::pair(b.rectangle.y, b.rectangle.x);
  });
  return regions;
}

}  // namespace gaitcam
