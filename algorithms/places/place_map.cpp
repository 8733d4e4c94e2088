#include "algorithms/places/place_map.h"

#include <cmath>
#include <numbers>

namespace gaitcam {

PlaceMap::PlaceMap(const CylinderProjection& projection, const PanoramaLayout& layout, const Options& options)
    : projection_(projection),
      layout_(layout),
      options_(options),
      encoder_(layout.height_px, options.wavelet),
      nodes_(options.wavelet) {
  Encode(cv::Mat::zeros(layout.height_px, projection.width_px(), CV_8UC1));  // throws now what every view would
}

void PlaceMap::AddNode(const cv::Mat& panorama, double ahead_rad) {
  nodes_.Add(encoder_.OfPanorama(panorama));
  ahead_rad_.push_back(ahead_rad);
  Visit(size() - 1);
}

void PlaceMap::Visit(int node) {
  last_ = node;
  surroundings_.reset();
}

void PlaceMap::SetSurroundings(const cv::Mat& panorama, double ahead_rad) {
  surroundings_ = Surroundings{WaveletMap(options_.wavelet), ahead_rad};
  surroundings_->map.Add(encoder_.OfPanorama(panorama));
}

double PlaceMap::surroundings_ahead_rad() const {
  return surroundings_ ? surroundings_->ahead_rad : ahead_rad_[size_t(last_)];
}

double PlaceMap::TolerancePx() const {
  return *options_.heading_tolerance_deg * std::numbers::pi / 180 * layout_.px_per_rad();
}

WaveletMatch PlaceMap::Match(const WaveletView& view, const WaveletMap& map, int node, double ahead_rad,
                             double heading_rad) const {
  if (!options_.heading_tolerance_deg) return map.Query(view, size_t(node));
  const double middle = layout_.ColumnOf(heading_rad - ahead_rad);
  return map.Query(view, size_t(node), WaveletWindow{middle - 0.5 * (view.width_px - 1), TolerancePx()});
}

std::vector<WaveletMatch> PlaceMap::MatchNodes(const WaveletView& view, double heading_rad) const {
  std::vector<WaveletMatch> matches;
  for (int node = 0; node < size(); ++node) matches.push_back(Match(view, nodes_, node, ahead_rad(node), heading_rad));
  return matches;
}

WaveletMatch PlaceMap::MatchSurroundings(const WaveletView& view, std::optional<double> heading_rad) const {
  const WaveletMap& map = surroundings_ ? surroundings_->map : nodes_;
  const int node = surroundings_ ? 0 : last_;
  if (!heading_rad) return map.Query(view, size_t(node));
  return Match(view, map, node, surroundings_ahead_rad(), *heading_rad);
}

PanoramaSectors PlaceMap::Sectors(const cv::Mat& panorama) const {
  return SectorsOf(encoder_, panorama, projection_.width_px());
}

std::vector<PanoramaMatch> PlaceMap::MatchNodes(const PanoramaSectors& sectors, double ahead_rad) const {
  std::vector<PanoramaMatch> matches;
  for (int node = 0; node < size(); ++node) {
    std::optional<WaveletWindow> turns;
    if (options_.heading_tolerance_deg) {
      const double left_rad = ahead_rad - ahead_rad_[size_t(node)];
      turns = WaveletWindow{-left_rad * layout_.px_per_rad(), TolerancePx()};
    }
    matches.push_back(MatchPanorama(nodes_, size_t(node), sectors, options_.sector_slack_deg, turns));
  }
  return matches;
}

double PlaceMap::BearingOf(const WaveletMatch& match) const {
  const double middle = match.left_px + 0.5 * (projection_.width_px() - 1);
  return std::remainder(layout_.AzimuthOf(middle), 2 * std::numbers::pi);
}

}  // namespace gaitcam
