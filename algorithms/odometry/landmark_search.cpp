#include "algorithms/odometry/landmark_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "algorithms/features/descriptor_distance.h"
#include "algorithms/features/matching.h"
#include "algorithms/geometry/inverse_depth.h"

namespace gaitcam {
namespace {

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

struct Nearest {
  int feature = -1;
  double distance = std::numeric_limits<double>::infinity();
};

/// Compares landmarks with features by their descriptors.
class DescriptorSearch {
 public:
  DescriptorSearch(const FrameView& view, const LandmarkSearchOptions& options) : view_(view), options_(options) {}

  /// The feature with the nearest descriptor, if it passes the ratio test against candidates elsewhere in the image.
  Nearest Find(const Landmark& landmark, const std::vector<int>& candidates) {
    DescriptorDistances(landmark.descriptor, view_.features.descriptors, candidates, distances_);
    if (!landmark.latest.empty()) {
      DescriptorDistances(landmark.latest, view_.features.descriptors, candidates, of_latest_);
      for (size_t k = 0; k < candidates.size(); ++k) distances_[k] = std::min(distances_[k], of_latest_[k]);
    }
    Nearest best;
    for (size_t k = 0; k < candidates.size(); ++k) {
      if (double(distances_[k]) < best.distance) best = {candidates[k], double(distances_[k])};
    }
    for (size_t k = 0; k < candidates.size(); ++k) {
      if (double(distances_[k]) * options_.ratio > best.distance || candidates[k] == best.feature) continue;
      const Eigen::Vector2d apart = view_.xy[size_t(candidates[k])] - view_.xy[size_t(best.feature)];
      if (apart.norm() > options_.same_point) return {};
    }
    return best;
  }

 private:
  const FrameView& view_;
  const LandmarkSearchOptions& options_;
  std::vector<float> distances_, of_latest_;  ///< Of the candidates.
};

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
  DescriptorSearch search(view, options);
  const InverseDepthCamera camera(X_WC);
  std::vector<Eigen::Matrix3d> R_WA;
  for (const Pose& X_WA : map.keyframes()) R_WA.push_back(X_WA.R());
  std::vector<int> candidates;
  for (size_t l = 0; l < map.landmarks().size(); ++l) {
    const Landmark& landmark = map.landmarks()[l];
    const size_t anchor = size_t(landmark.anchor);
    const auto projection = camera.See({R_WA[anchor], map.keyframes()[anchor].translation, landmark.ray, landmark.rho});
    if (!projection) continue;
    const double spread = options.depth_sigmas * landmark.rho_sigma * projection->d_rho.norm();
    candidates.clear();
    grid.Near(projection->xy, options.radius + std::min(spread, 2 * options.radius),
              [&](int i) { candidates.push_back(i); });
    const Nearest found = search.Find(landmark, candidates);
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
