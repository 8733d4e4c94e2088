/// A frame's features found by where they lie and by their descriptors.

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

/// Features sorted into square cells: those near a position are found without visiting all. Those of one cell, and of
/// the cells of one row, lie one behind the other.
class FeatureGrid {
 public:
  FeatureGrid(const std::vector<Eigen::Vector2d>& xy, double cell) : cell_(cell) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
    for (const Eigen::Vector2d& p : xy) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if (xy.empty()) return;
    low_ = low;
    columns_ = 1 + int((high.x() - low.x()) / cell);
    rows_ = 1 + int((high.y() - low.y()) / cell);
    const auto cell_of = [&](const Eigen::Vector2d& p) {
      return size_t(Cell(p.y(), low_.y())) * size_t(columns_) + size_t(Cell(p.x(), low_.x()));
    };
    begins_.assign(size_t(columns_) * size_t(rows_) + 1, 0);
    for (const Eigen::Vector2d& p : xy) ++begins_[cell_of(p) + 1];
    for (size_t c = 1; c < begins_.size(); ++c) begins_[c] += begins_[c - 1];
    features_.resize(xy.size());
    std::vector<int> next(begins_.begin(), begins_.end() - 1);
    for (size_t i = 0; i < xy.size(); ++i) features_[size_t(next[cell_of(xy[i])]++)] = {xy[i], int(i)};
  }

  template <class Visit>
  void Near(const Eigen::Vector2d& p, double radius, Visit visit) const {
    const int x0 = std::max(0, Cell(p.x() - radius, low_.x())),
              x1 = std::min(columns_ - 1, Cell(p.x() + radius, low_.x()));
    const int y0 = std::max(0, Cell(p.y() - radius, low_.y())),
              y1 = std::min(rows_ - 1, Cell(p.y() + radius, low_.y()));
    for (int y = y0; y <= y1 && x0 <= x1; ++y) {
      const size_t row = size_t(y) * size_t(columns_);
      for (int k = begins_[row + size_t(x0)]; k < begins_[row + size_t(x1) + 1]; ++k) {
        const Feature& feature = features_[size_t(k)];
        if ((feature.xy - p).squaredNorm() <= radius * radius) visit(feature.index);
      }
    }
  }

 private:
  struct Feature {
    Eigen::Vector2d xy;
    int index = 0;
  };
  int Cell(double v, double low) const { return int(std::floor((v - low) / cell_)); }

  double cell_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<int> begins_;        ///< Of each cell, row by row, in features_; and the end of the last one.
  std::vector<Feature> features_;  ///< In a cell, in their own order.
};

struct NearestFeature {
  int feature = -1;
  double distance = std::numeric_limits<double>::infinity();
};

/// Compares a descriptor with those of some features.
class DescriptorSearch {
 public:
  /// @param xy, descriptors of all features; both must outlive this.
  /// @param ratio nearest over second nearest distance
  /// @param same_point features nearer to each other than this, in the unit of xy, are no rivals in the ratio test
  DescriptorSearch(const std::vector<Eigen::Vector2d>& xy, const cv::Mat& descriptors, double ratio, double same_point)
      : xy_(xy), descriptors_(descriptors), ratio_(ratio), same_point_(same_point) {}

  /// The candidate with the nearest descriptor, if it passes the ratio test against candidates elsewhere in the image.
  /// @param latest a second descriptor of the same thing, or empty: the nearer of both counts.
  NearestFeature Find(const cv::Mat& descriptor, const cv::Mat& latest, const std::vector<int>& candidates);

 private:
  const std::vector<Eigen::Vector2d>& xy_;
  const cv::Mat& descriptors_;
  double ratio_, same_point_;
  std::vector<float> distances_, of_latest_;  ///< Of the candidates.
};

/// Of the landmarks that want a feature, the one observed most often gets it, so that tracks are long: several may be
/// the same point of the world.
struct LandmarkClaim {
  int landmark = -1;
  size_t observations = 0;
  double distance = std::numeric_limits<double>::infinity();

  bool Beats(const LandmarkClaim& other) const {
    if (observations != other.observations) return observations > other.observations;
    return distance < other.distance;
  }
};

}  // namespace gaitcam
