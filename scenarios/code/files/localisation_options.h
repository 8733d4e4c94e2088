/// `localisation:` places on a grid, views between them, and how well each method says where a view was taken: the
/// experiment 4.6 of the thesis, instead of a walk with a SLAM system.

#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/places/panorama.h"
#include "algorithms/places/wavelet_signature.h"
#include "models/code/scenes/scene.h"

namespace gaitcam {

/// Changes of the light between references and views: turned by 90 degrees, halved, turned orange.
enum class LightChange { kMoved, kDimmed, kColoured };
constexpr auto WordsOf(LightChange) {
  return std::array{EnumWord{LightChange::kMoved, "moved"}, EnumWord{LightChange::kDimmed, "dimmed"},
                    EnumWord{LightChange::kColoured, "coloured"}};
}

struct LocalisationOptions {
  using DescribedTag = void;

  int columns = 13, rows = 9;
  Eigen::Vector2d field_m{5.4, 3.6};
  Eigen::Vector2d centre_m{0, 0};
  int queries = 200;
  double margin_m = 0.15;
  std::vector<std::string> methods;
  int panorama_width_px = 720, panorama_height_px = 160;
  PanoramaOptions panorama;
  WaveletOptions wavelet;
  std::vector<double> occlusions{0.1, 0.2, 0.3};
  std::vector<LightChange> lights{LightChange::kMoved, LightChange::kDimmed,
                                  LightChange::kColoured};  ///< Changes of the light, for views alone.
  std::vector<double> walk_exposures_ms{20, 33};
  double walk_m = 1.2;
  double walk_every_s = 1;
  int heat_maps = 4;
};

template <class Visitor>
void VisitFields(Visitor& visit, LocalisationOptions& o) {
  visit("columns", o.columns, Between(2, 100), "references along x, in the middles of equal cells of the field");
  visit("rows", o.rows, Between(2, 100), "references along y");
  visit("field_m", o.field_m, Nested(), "size of the field along x and y");
  visit("centre_m", o.centre_m, Nested(), "the field's middle");
  visit("queries", o.queries, Between(5, 100000), "views of each condition");
  visit("margin_m", o.margin_m, Between(0, 10), "views are taken no nearer to the field's edge");
  visit("methods", o.methods, Nested(), "how places are recognised: wavelet, fourier, ...; all if empty");
  visit("panorama_width_px", o.panorama_width_px, Between(64, 8192), "of a panorama's 360 degrees");
  visit("panorama_height_px", o.panorama_height_px, Between(8, 2048), "height of panoramas and views");
  visit("panorama", o.panorama, Nested(), "stitching");
  visit("wavelet", o.wavelet, Nested(), "the wavelet signature");
  visit("occlusions", o.occlusions, Nested(), "shares of a view that pictures of other robots hide");
  visit("lights", o.lights, Nested(), "changes of the light, for views alone: moved, dimmed, coloured");
  visit("walk_exposures_ms", o.walk_exposures_ms, Nested(), "exposures of views that are filmed while walking");
  visit("walk_m", o.walk_m, Between(0.3, 100), "length of each walk, straight on from a random pose");
  visit("walk_every_s", o.walk_every_s, Between(0.05, 100), "time between two views of a walk");
  visit("heat_maps", o.heat_maps, Between(0, 50), "so many plain views are shown, and one of each other condition");
}

/// What no single number's limits can say.
struct LocalisationProblem {
  std::string key, text;
};
/// Words and numbers of lists, and whether the field lies on the scene's floor.
std::optional<LocalisationProblem> FindProblem(const LocalisationOptions& options, const Scene& scene);

}  // namespace gaitcam
