#include "scenarios/runs/mapped_floor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {

FloorTruth FloorTruthOf(const Place& place, double cell_m) {
  constexpr double kPixelsPerCell = 2, kMostPixels = 64e6;
  const Eigen::Vector2d size = place.floor_max - place.floor_min;
  FloorTruth truth;
  truth.px_per_m = std::min(kPixelsPerCell / cell_m, std::sqrt(kMostPixels / size.prod()));
  cv::cvtColor(FloorImage(place, truth.px_per_m), truth.grey, cv::COLOR_BGR2GRAY);
  const double half_pixel = 0.5 / truth.px_per_m;
  truth.corner_m = {place.floor_min.x() + half_pixel, place.floor_max.y() - half_pixel};
  return truth;
}

std::optional<FloorComparison> AddMapScores(const Estimate& estimate, const Place& place, Scores& scores) {
  if (!estimate.floor) return std::nullopt;
  const double cell_m = estimate.floor->empty() ? 1 : estimate.floor->cell_m;
  FloorComparison comparison = CompareFloor(*estimate.floor, FloorTruthOf(place, cell_m), scores.se3.X_WV);
  scores.scores.insert(scores.scores.end(), comparison.scores.begin(), comparison.scores.end());
  return comparison;
}

void WriteMapPictures(const FloorComparison& comparison, const std::filesystem::path& folder) {
  if (comparison.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const auto& [name, picture] : {std::pair("estimate.png", comparison.estimate),
                                      {"mask.png", comparison.mask},
                                      {"truth.png", comparison.truth},
                                      {"difference.png", comparison.difference}}) {
    const std::filesystem::path file = folder / name;
    bool written = false;
    try {
      written = cv::imwrite(file.string(), picture);
    } catch (const cv::Exception&) {  // a full disk, or a folder that cannot be made
    }
    if (!written) throw MissingResource(file.string() + ": cannot be written");
  }
}

}  // namespace gaitcam
