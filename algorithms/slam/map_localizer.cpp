#include "algorithms/slam/map_localizer.h"

#include <algorithm>
#include <cmath>
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
  CarryOnAndConfirm(stamp_ns, seen, body);
  bool elsewhere = places_.empty();
  unconfirmed_ = AnyConfirmed() ? 0 : unconfirmed_ + 1;
  if (places_.empty() || unconfirmed_ > options_.unconfirmed_frames) {
    std::vector<Place> found = FindInWholeMap(seen);
    if (!found.empty()) {
      elsewhere = WeighAgainstTheWheels(std::move(found));
      unconfirmed_ = 0;
    }
  }
  elsewhere = GiveUpTheWorse() || elsewhere;
  last_stamp_ns_ = stamp_ns;
  if (places_.empty()) return std::nullopt;
  if (places_.size() == 1) places_.front().was_alone = true;
  Fix fix = places_.front().fix;
  fix.places = int(places_.size());
  fix.found = elsewhere;
  return fix;
}

std::vector<Pose> MapLocalizer::Elsewhere() const {
  std::vector<Pose> poses;
  for (size_t i = 1; i < places_.size(); ++i) poses.push_back(places_[i].fix.X_WC);
  return poses;
}

/// A frame from where the last one was taken says nothing new: what was explained is forgotten with the way.
/// Where the map has no view that looks the same way, a frame says nothing against a place. But a place that a view
/// alone speaks for is forgotten while another one is confirmed.
void MapLocalizer::CarryOnAndConfirm(int64_t stamp_ns, const MetricModel& seen, const BodyTrack& body) {
  constexpr double kForgets_m = 0.33, kForgets_rad = 0.33;  // half of it after 0.23 m or 13 degrees
  if (places_.empty()) return;
  const std::optional<RelativePose> moved = body.Between(last_stamp_ns_, stamp_ns);
  if (!moved) return places_.clear();
  const double turned_rad = RotationAngle(Eigen::Quaterniond::Identity(), moved->X_FT.rotation);
  const double kept = std::exp(-moved->X_FT.translation.norm() / kForgets_m - turned_rad / kForgets_rad);
  std::vector<bool> is_mapped;
  for (Place& place : places_) {
    place.fix = CarriedOn(place.fix, *moved);
    const std::vector<int> views = ViewsNear(place.fix.X_WC);
    is_mapped.push_back(!views.empty());
    if (const std::optional<Fix> confirmed = Confirmed(place.fix, views, seen)) place.fix = *confirmed;
  }
  const bool any_confirmed = AnyConfirmed();
  for (size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    const bool says_nothing = !is_mapped[i] && (place.was_alone || !any_confirmed);
    if (!says_nothing) place.explained = kept * place.explained + (1 - kept) * place.fix.inliers;
  }
}

bool MapLocalizer::AnyConfirmed() const {
  return std::any_of(places_.begin(), places_.end(), [](const Place& place) { return place.fix.view >= 0; });
}

/// @returns whether the first place was among them.
bool MapLocalizer::GiveUpTheWorse() {
  if (places_.empty()) return false;
  const auto less = [](const Place& a, const Place& b) { return a.explained < b.explained; };
  const auto best = std::max_element(places_.begin(), places_.end(), less);
  const double enough = 0.5 * best->explained;
  const bool first = places_.front().explained < enough;
  if (first) std::iter_swap(places_.begin(), best);
  std::erase_if(places_, [&](const Place& place) { return place.explained < enough; });
  return first;
}

MapLocalizer::Fix MapLocalizer::CarriedOn(const Fix& last, const RelativePose& moved) const {
  Fix fix;
  fix.X_WC = last.X_WC * moved.X_FT;
  fix.covariance = CovarianceOfProduct(moved.X_FT, last.covariance, moved.covariance);
  return fix;
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
             link->matches,
             1};
}

/// By that of the nearest views which agrees with what is expected and has the most inliers.
std::optional<MapLocalizer::Fix> MapLocalizer::Confirmed(const Fix& expected, const std::vector<int>& views,
                                                         const MetricModel& seen) {
  std::optional<Fix> best;
  int tried = 0;
  for (const int view : views) {
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

/// As a view of the map that shows the other place might also show the one.
bool MapLocalizer::Near(const Fix& a, const Fix& b) const {
  const Pose X_AB = a.X_WC.Inverse() * b.X_WC;
  return X_AB.translation.norm() <= options_.near_m &&
         kDegPerRad * RotationAngle(Eigen::Quaterniond::Identity(), X_AB.rotation) <= options_.near_deg;
}

/// The place whose view has the most inliers first, and every other place that half as many agree with.
std::vector<MapLocalizer::Place> MapLocalizer::FindInWholeMap(const MetricModel& seen) {
  if (!search_) {
    search_.emplace(options_.search);
    for (const MetricModel& model : models_) search_->Add(model.features.descriptors);
  }
  std::vector<Fix> fits;
  for (const std::vector<int>& pass : search_->BestOfEachPass(seen.features.descriptors, search_->size())) {
    for (const int view : pass) {
      if (const std::optional<Fix> fix = LinkWith(view, seen)) fits.push_back(*fix);
    }
  }
  std::stable_sort(fits.begin(), fits.end(), [](const Fix& a, const Fix& b) { return a.inliers > b.inliers; });
  std::vector<Place> places;
  if (fits.empty() || fits.front().inliers < options_.relocalise_inliers) return places;
  for (const Fix& fix : fits) {
    const bool there = std::any_of(places.begin(), places.end(), [&](const Place& p) { return Near(p.fix, fix); });
    if (!there) places.push_back({fix, double(fix.inliers)});
  }
  return places;
}

/// What is seen next will tell whether a view of the whole map is right or the wheels are.
/// @returns whether the first place is one that was found.
bool MapLocalizer::WeighAgainstTheWheels(std::vector<Place> found) {
  const auto carried = std::find_if(places_.begin(), places_.end(), [](const Place& p) { return p.was_alone; });
  if (carried != places_.end()) {
    const double best = found.front().explained;
    auto same = std::find_if(found.begin(), found.end(), [&](const Place& f) { return Near(carried->fix, f.fix); });
    if (same == found.end()) same = found.insert(same, *carried);
    same->was_alone = true;
    same->explained = best;
    std::iter_swap(found.begin(), same);
  }
  places_ = std::move(found);
  return places_.front().fix.view >= 0;
}

}  // namespace gaitcam
