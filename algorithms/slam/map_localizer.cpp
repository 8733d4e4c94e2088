#include "algorithms/slam/map_localizer.h"

#include <algorithm>
#include <utility>

#include "algorithms/core/errors.h"
#include "algorithms/core/units.h"
#include "algorithms/estimation/pose_graph_solver.h"
#include "algorithms/estimation/semi_consensus.h"

namespace gaitcam {
namespace {

constexpr double kChi2 = 22.46;  // 99.9 % of six degrees of freedom

Matrix6d MapCovariance(const MapLocalizerOptions& o) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(o.map_sigma_m), Eigen::Vector3d::Constant(kRadPerDeg * o.map_sigma_deg);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

MapLocalizer::MapLocalizer(const Calibration& calibration, std::shared_ptr<const RouteMap> map,
                           const std::string& feature, const MetricModelOptions& models,
                           const MapLocalizerOptions& options, uint64_t seed)
    : map_(std::move(map)), options_(options), map_covariance_(MapCovariance(options)), random_(seed, "map_localizer") {
  models_ = ModelsOf(*map_, calibration, feature, models);
}

std::optional<MapLocalizer::Fix> MapLocalizer::Locate(int64_t stamp_ns, const MetricModel& seen,
                                                      const BodyTrack& body) {
  std::optional<Fix> fix = CarriedOn(stamp_ns, body);
  if (fix) {
    if (const std::optional<Fix> confirmed = Confirmed(*fix, seen)) fix = confirmed;
  }
  unconfirmed_ = fix && fix->view >= 0 ? 0 : unconfirmed_ + 1;
  if (!fix || unconfirmed_ > options_.unconfirmed_frames) {
    if (const std::optional<Fix> found = FindInWholeMap(seen)) {
      fix = found;
      unconfirmed_ = 0;
    }
  }
  last_ = fix;
  last_stamp_ns_ = stamp_ns;
  return fix;
}

std::optional<MapLocalizer::Fix> MapLocalizer::CarriedOn(int64_t stamp_ns, const BodyTrack& body) const {
  if (!last_) return std::nullopt;
  const std::optional<RelativePose> moved = body.Between(last_stamp_ns_, stamp_ns);
  if (!moved) return std::nullopt;
  return Fix{last_->X_WC * moved->X_FT,
             CovarianceOfProduct(moved->X_FT, last_->covariance, moved->covariance),
             -1,
             false,
             0,
             0};
}

/// The nearest first.
std::vector<int> MapLocalizer::ViewsNear(const Pose& X_WC) const {
  std::vector<std::pair<double, int>> near;
  for (int v = 0; v < int(models_.size()); ++v) {
    if (int(models_[size_t(v)].p_C.size()) < options_.links.min_inliers) continue;
    const Pose X_VC = map_->graph.nodes[size_t(v)].X_WC.Inverse() * X_WC;
    const double turned_deg = kDegPerRad * RotationAngle(Eigen::Quaterniond::Identity(), X_VC.rotation);
    const double away_m = X_VC.translation.norm();
    if (away_m <= options_.near_m && turned_deg <= options_.near_deg)
      near.emplace_back(away_m / options_.near_m + turned_deg / options_.near_deg, v);
  }
  std::sort(near.begin(), near.end());
  std::vector<int> views;
  for (const auto& [distance, view] : near) views.push_back(view);
  return views;
}

std::optional<MapLocalizer::Fix> MapLocalizer::LinkWith(int view, const MetricModel& seen) {
  const auto link = LinkModels(models_[size_t(view)], seen, options_.links, random_);
  if (!link) return std::nullopt;
  return Fix{map_->graph.nodes[size_t(view)].X_WC * link->X_FT,
             CovarianceOfProduct(link->X_FT, map_covariance_, link->covariance),
             view,
             false,
             link->inliers,
             link->matches};
}

/// By that of the nearest views which agrees with what is expected and has the most inliers.
std::optional<MapLocalizer::Fix> MapLocalizer::Confirmed(const Fix& expected, const MetricModel& seen) {
  std::optional<Fix> best;
  int tried = 0;
  for (const int view : ViewsNear(expected.X_WC)) {
    if (tried++ == options_.neighbours) break;
    const std::optional<Fix> fix = LinkWith(view, seen);
    if (!fix || (best && fix->inliers <= best->inliers)) continue;
    if (InnovationChi2(expected.X_WC, expected.covariance, fix->X_WC, fix->covariance) <= kChi2) best = fix;
  }
  if (!best) return std::nullopt;
  best->X_WC = MahalanobisMean({{expected.X_WC, expected.covariance}, {best->X_WC, best->covariance}});
  best->covariance = (expected.covariance.inverse() + best->covariance.inverse()).inverse();
  return best;
}

std::optional<MapLocalizer::Fix> MapLocalizer::FindInWholeMap(const MetricModel& seen) {
  if (!search_) {
    search_.emplace(options_.search);
    for (const MetricModel& model : models_) search_->Add(model.features.descriptors);
  }
  std::optional<Fix> best;
  for (const std::vector<int>& pass : search_->BestOfEachPass(seen.features.descriptors, search_->size())) {
    for (const int view : pass) {
      const std::optional<Fix> fix = LinkWith(view, seen);
      if (fix && fix->inliers >= options_.relocalise_inliers && (!best || fix->inliers > best->inliers)) best = fix;
    }
  }
  if (best) best->found = true;
  return best;
}

}  // namespace gaitcam
