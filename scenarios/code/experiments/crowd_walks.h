/// How many features of a walk through a crowd are kept by images before, and by images before or after.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenarios/code/experiments/crowd_views.h"

namespace gaitcam {

/// Views of a walk, in their order.
struct CrowdWalk {
  std::string scene;
  std::vector<CrowdView> views;
};

/// Features that are kept, over the images of all walks that have a neighbour on both sides.
struct WalkCount {
  std::string detector, filter;
  double single = 0, both = 0;                      ///< Mean numbers per image.
  double single_on_people = 0, both_on_people = 0;  ///< Shares of them.
};

/// By Hua's ICGM with its threshold and with an automatic one, and by the consensus.
std::vector<WalkCount> CountWalks(const std::vector<CrowdWalk>& walks, const std::vector<std::string>& detectors,
                                  uint64_t seed);

/// In Markdown. @param views of each walk.
std::string WalkTable(const std::vector<WalkCount>& counts, int views);

}  // namespace gaitcam
