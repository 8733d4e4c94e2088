/// A topological map: places that were seen all around, and which of them follow each other.

#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace gaitcam {

struct PlaceNode {
  int64_t stamp_ns = 0;  ///< First frame of its scan.
  size_t bytes = 0;      ///< What a robot must keep in memory to know the place again.
  cv::Mat panorama;      ///< CV_8UC1, 360 degrees wide, column 0 to the left of straight back; for people, not kept.
  cv::Mat view{};        ///< CV_8UC1, a small picture of it, where it was seen in one view; for people, not kept.
};

struct PlaceLink {
  int from = 0, to = 0;  ///< Nodes.
  bool loop = false;     ///< `to` was known before: a loop was closed.
  int64_t stamp_ns = 0;
};

/// One try to recognise a known place.
struct PlaceTest {
  int64_t stamp_ns = 0;
  std::vector<double> likelihood;  ///< Of "no loop" first, then of each node; 0 for a node that was left out.
  std::vector<double> posterior;   ///< Likewise; sums to 1.
  int matched = -1;                ///< The node, or -1.
  double bearing_rad = 0;          ///< Of the view's middle in the matched panorama; 0 is its middle, left is positive.
  /// CV_8UC1, what was compared: a view, or a panorama as wide as the nodes'; of nodes with views a small picture of
  /// it.
  cv::Mat view;
};

struct PlaceGraph {
  std::vector<PlaceNode> nodes;
  std::vector<PlaceLink> links;
  std::vector<PlaceTest> tests;
};

}  // namespace gaitcam
