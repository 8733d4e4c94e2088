#include "algorithms/odometry/landmark_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "algorithms/features/matching.h"

namespace gaitcam {
namespace {

/// Descriptors' distance: Euclidean for numbers, Hamming for bits.
double Distance(const cv::Mat& a, const cv::Mat& b, int row_b) {
  if (a.depth() == CV_8U) return cv::norm(a, b.row(row_b), cv::NORM_HAMMING);
  using Row = Eigen::Map<const Eigen::VectorXf>;
  return std::sqrt((Row(a.ptr<float>(), a.cols) - Row(b.ptr<float>(row_b), b.cols)).squaredNorm());
}

/// Features sorted into square cells: those near a position are found without visiting all.
class FeatureGrid {
 public:
  FeatureGrid(const std::vector<Eigen::Vector2d>& xy, double cell) : xy_(xy), cell_(cell) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
    for (const Eigen::Vector2d& p : xy) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if (xy.empty()) return;
    low_ = low;
    columns_ = 1 + int((high.x() - low.x()) / cell);
    rows_ = 1 + int((high.y() - low.y()) / cell);
    cells_.resize(size_t(columns_) * size_t(rows_));
    for (size_t i = 0; i < xy.size(); ++i) {
      cells_[size_t(Cell(xy[i].y(), low_.y())) * size_t(columns_) + size_t(Cell(xy[i].x(), low_.x()))].push_back(
          int(i));
    }
  }

  template <class Visit>
  void Near(const Eigen::Vector2d& p, double radius, Visit visit) const {
    const int x0 = std::max(0, Cell(p.x() - radius, low_.x())),
              x1 = std::min(columns_ - 1, Cell(p.x() + radius, low_.x()));
    const int y0 = std::max(0, Cell(p.y() - radius, low_.y())),
              y1 = std::min(rows_ - 1, Cell(p.y() + radius, low_.y()));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        for (const int i : cells_[size_t(y) * size_t(columns_) + size_t(x)]) {
          if ((xy_[size_t(i)] - p).squaredNorm() <= radius * radius) visit(i);
        }
      }
    }
  }

 private:
  int Cell(double v, double low) const { return int(std::floor((v - low) / cell_)); }

  const std::vector<Eigen::Vector2d>& xy_;
  double cell_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

struct Nearest {
  int feature = -1;
  double distance = std::numeric_limits<double>::infinity();
};

/// The feature with the nearest descriptor, if it passes the ratio test against candidates elsewhere in the image.
Nearest FindNearest(const Landmark& landmark, const FrameView& view, const std::vector<int>& candidates,
                    const LandmarkSearchOptions& options) {
  Nearest best;
  std::vector<double> distances;
  for (const int i : candidates) {
    distances.push_back(std::min(Distance(landmark.descriptor, view.features.descriptors, i),
                                 Distance(landmark.latest, view.features.descriptors, i)));
    if (distances.back() < best.distance) best = {i, distances.back()};
  }
  for (size_t k = 0; k < candidates.size(); ++k) {
    if (distances[k] * options.ratio > best.distance || candidates[k] == best.feature) continue;
    const Eigen::Vector2d apart = view.xy[size_t(candidates[k])] - view.xy[size_t(best.feature)];
    if (apart.norm() > options.same_point) return {};
  }
  return best;
}

}  // namespace

std::vector<LandmarkMatch> SearchNear(const KeyframeMap& map, const FrameView& view, const Pose& X_WC,
                                      const LandmarkSearchOptions& options) {
  const FeatureGrid grid(view.xy, std::max(0.02, options.radius));
  // Several landmarks may be the same point of the world: the one observed most often gets the feature, so that tracks
  // are long.
  struct Claim {
    int landmark = -1;
    size_t observations = 0;
    double distance = std::numeric_limits<double>::infinity();

    bool Beats(const Claim& other) const {
      if (observations != other.observations) return observations > other.observations;
      return distance < other.distance;
    }
  };
  std::vector<Claim> claims(view.xy.size());
  std::vector<int> candidates;
  for (size_t l = 0; l < map.landmarks().size(); ++l) {
    const Landmark& landmark = map.landmarks()[l];
    const auto projection =
        LinearizeInverseDepth(map.keyframes()[size_t(landmark.anchor)], landmark.ray, landmark.rho, X_WC);
    if (!projection) continue;
    const double spread = options.depth_sigmas * landmark.rho_sigma * projection->d_rho.norm();
    candidates.clear();
    grid.Near(projection->xy, options.radius + std::min(spread, 2 * options.radius),
              [&](int i) { candidates.push_back(i); });
    const Nearest found = FindNearest(landmark, view, candidates, options);
    if (found.feature < 0) continue;
    const Claim claim = {int(l), landmark.observations.size(), found.distance};
    Claim& present = claims[size_t(found.feature)];
    if (present.landmark < 0 || claim.Beats(present)) present = claim;
  }
  std::vector<LandmarkMatch> matches;
  for (size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].landmark >= 0) matches.push_back({claims[i].landmark, int(i)});
  }
  return matches;
}

std::vector<LandmarkMatch> SearchAnywhere(const KeyframeMap& map, const FrameView& view, double ratio) {
  if (map.landmarks().empty() || view.xy.empty()) return {};
  cv::Mat descriptors;
  for (const Landmark& landmark : map.landmarks()) descriptors.push_back(landmark.descriptor);
  MatchingOptions matching;
  matching.ratio = ratio;
  std::vector<LandmarkMatch> matches;
  for (const Match& match : MatchDescriptors(descriptors, view.features.descriptors, matching)) {
    matches.push_back({match.a, match.b});
  }
  return matches;
}

}  // namespace gaitcam
