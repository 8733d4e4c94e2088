/// What a localisation works on, made by the simulator: panoramas of a grid of places, and views between them.
///
/// The robot is put down at every pose, comes to rest under its own weight, and its servos and camera do the rest, as
/// in a walk. What is compared later is grey and laid onto the panoramas' cylinder.

#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/places/panorama.h"
#include "results/scoring/place_score.h"
#include "scenarios/code/files/scenario.h"

namespace gaitcam {

struct PlaceReference {
  Eigen::Vector2d position_m{0, 0};  ///< Where it truly stood.
  double heading_rad = 0;            ///< True heading of the panorama's middle.
  cv::Mat panorama;                  ///< CV_8UC1
  int frames = 0;
  double seam_error_px = 0;  ///< Mean of the stitch.
};

struct PlaceQuery {
  std::string condition;
  Eigen::Vector2d position_m{0, 0};  ///< Where the robot truly stood ...
  double heading_rad = 0;            ///< ... and the camera truly looked.
  cv::Mat image;                     ///< CV_8UC3 as filmed; with what was pasted in.
  cv::Mat view;                      ///< CV_8UC1: what is compared.
  double covered_ratio = 0;          ///< Share of the view behind pasted robots.
  double blur_px = 0;                ///< Median length of the motion blur.
};

/// All that a localisation works on.
struct PlaceViews {
  PlaceGrid grid;
  PanoramaLayout layout;
  int view_width_px = 0;
  RendererInfo renderer;
  std::vector<PlaceReference> references;  ///< In the order of the grid.
  std::vector<PlaceQuery> queries;         ///< Condition after condition.
};

/// The conditions in their order: "plain", "occlusion_20", "light_moved", "walk_33ms", ...
std::vector<std::string> PlaceConditions(const LocalisationOptions& options);
/// What a condition is, in a few words.
std::string PlaceConditionText(const std::string& condition);

PlaceGrid GridOf(const LocalisationOptions& options);

/// Whether robot, scene and options can do it, without rendering. @throws BadInput or BadOption in one line.
void CheckPlaceViews(const ResolvedScenario& resolved);

/// @param advance is called after each panorama and each condition's views with what was done of what is to do; it
/// returns false to stop. @returns what was made until then. @throws BadInput, MissingResource.
PlaceViews MakePlaceViews(const ResolvedScenario& resolved, const std::function<bool(int done, int all)>& advance);

}  // namespace gaitcam
