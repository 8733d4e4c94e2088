/// How the known places look, and how well a view or a panorama fits each of them.
///
/// A place is a node: the signature of its panorama and the heading of the panorama's middle. Views are also compared
/// with the surroundings: the panorama that was scanned last, be it a node's or, a step aside of a known place, one
/// that is dropped with the next.

#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/places/panorama.h"
#include "algorithms/places/panorama_match.h"
#include "algorithms/places/wavelet_map.h"

namespace gaitcam {

class PlaceMap {
 public:
  struct Options {
    WaveletOptions wavelet;
    /// A view lies within this of where its heading says; none: headings are not known, it may lie anywhere.
    std::optional<double> heading_tolerance_deg;
    double sector_slack_deg = 15;  ///< A panorama's sectors may slide by this against each other, see panorama_match.h.
  };

  /// @param projection must outlive the map. @throws BadInput if its views are too small for a signature.
  PlaceMap(const CylinderProjection& projection, const PanoramaLayout& layout, const Options& options);

  /// A new node, which is also the surroundings. @param ahead_rad heading of the panorama's middle.
  void AddNode(const cv::Mat& panorama, double ahead_rad);
  /// The robot is at a node again; its panorama is the surroundings.
  void Visit(int node);
  /// The robot is at `last()`, from where it sees this.
  void SetSurroundings(const cv::Mat& panorama, double ahead_rad);

  int size() const { return int(ahead_rad_.size()); }
  /// The node that was added or visited last; -1 before.
  int last() const { return last_; }
  double ahead_rad(int node) const { return ahead_rad_[size_t(node)]; }
  /// Heading of the middle of the surroundings. @pre size() > 0.
  double surroundings_ahead_rad() const;
  size_t bytes_per_node() const { return nodes_.bytes_per_place(); }

  WaveletView Encode(const cv::Mat& view) const { return encoder_.OfView(view); }
  /// Of a view with each node. @param heading_rad of the view's middle.
  std::vector<WaveletMatch> MatchNodes(const WaveletView& view, double heading_rad) const;
  /// Of a view with the surroundings. @param heading_rad of its middle, if it is to be believed. @pre size() > 0.
  WaveletMatch MatchSurroundings(const WaveletView& view, std::optional<double> heading_rad) const;
  /// Sectors of a panorama, as many as there are views side by side.
  PanoramaSectors Sectors(const cv::Mat& panorama) const;
  /// Of a panorama with each node. @param ahead_rad heading of its middle.
  std::vector<PanoramaMatch> MatchNodes(const PanoramaSectors& sectors, double ahead_rad) const;

  /// Azimuth of a view's middle in the panorama that it was matched with, in [-pi, pi].
  double BearingOf(const WaveletMatch& match) const;
  /// By how much a panorama is turned to the left against the node that it was matched with, rad, not wrapped.
  double BearingOf(const PanoramaMatch& match) const { return -match.turn_px / layout_.px_per_rad(); }

 private:
  struct Surroundings {
    WaveletMap map;  ///< Of one panorama.
    double ahead_rad = 0;
  };

  double TolerancePx() const;
  WaveletMatch Match(const WaveletView& view, const WaveletMap& map, int node, double ahead_rad,
                     double heading_rad) const;

  const CylinderProjection& projection_;
  PanoramaLayout layout_;
  Options options_;
  WaveletEncoder encoder_;
  WaveletMap nodes_;
  std::vector<double> ahead_rad_;  ///< Of each node.
  int last_ = -1;
  std::optional<Surroundings> surroundings_;  ///< None: those of node `last_`.
};

}  // namespace gaitcam
