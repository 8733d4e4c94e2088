/// Robust features of an image in a sequence, by ICGM with its neighbours; and which share of them a moving camera
/// leaves.
///
/// Source: Hua, sections 4.1.3 and 4.1.4.

#pragma once

#include <array>
#include <span>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/features/icgm.h"
#include "algorithms/features/pirf.h"

namespace gaitcam {

/// With which neighbours an image's features are compared.
enum class IcgmDirection {
  kSingle,  ///< Those before it (Hua, Fig. 4.2).
  kDouble,  ///< Those before it or those after it: what either keeps (Fig. 4.3). It is known later.
};
constexpr auto WordsOf(IcgmDirection) {
  return std::array{EnumWord{IcgmDirection::kSingle, "single"}, EnumWord{IcgmDirection::kDouble, "double"}};
}

struct RobustFeatureOptions {
  using DescribedTag = void;
  IcgmDirection direction = IcgmDirection::kSingle;
  int window = 2;  ///< Hua's.
  IcgmOptions icgm;
  MatchingOptions matching;
};

template <class Visitor>
void VisitFields(Visitor& visit, RobustFeatureOptions& o) {
  visit("direction", o.direction, EnumWords<IcgmDirection>(), "compared with images before, or also with those after");
  visit("window", o.window, AtLeast(2), "images in a row that a feature is found in, the image itself among them");
  visit("icgm", o.icgm, Nested(), "which matches are believed");
  visit("matching", o.matching, Nested(), "between neighbours");
}

/// Rows of the features of image `current` that stand still, ascending. With a threshold of 1 and direction single they
/// are PIRF's. Where an end of the sequence leaves no room for the window, that side keeps none; likewise where two
/// neighbours have fewer than 2 matches.
/// @param random draws ICGM's starts.
/// @throws BadInput if images of a window differ in size; BadOption.
std::vector<int> RobustFeatures(std::span<const FeatureImage> images, int current, const RobustFeatureOptions& options,
                                RandomStream& random);

/// P_alpha and P_beta: the share of static features that a camera keeps which turns (Hua, Eqs. 4.21 to 4.23), if they
/// are spread evenly over the angle.
/// @param lambda angle turned between two images over the field of view, >= 0 (Eq. 4.23)
double TurningShare(double lambda, IcgmDirection direction);

/// The same of a camera that moves away from a wall (Eqs. 4.24 to 4.27), if features are spread evenly over its image.
/// @param lambda way between two images over the distance after it, from 0 to 1 (Eq. 4.27)
double RecedingShare(double lambda, IcgmDirection direction);

}  // namespace gaitcam
