#include "scenarios/code/runs/mapped_floor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {

FloorTruth FloorTruthOf(const Scene& scene, double cell_m) {
  constexpr double kPixelsPerCell = 2, kMaxPixels = 64e6;
  const Eigen::Vector2d size = scene.floor_max - scene.floor_min;
  FloorTruth truth;
  truth.px_per_m = std::min(kPixelsPerCell / cell_m, std::sqrt(kMaxPixels / size.prod()));
  cv::cvtColor(FloorImage(scene, truth.px_per_m), truth.grey, cv::COLOR_BGR2GRAY);
  const double half_pixel = 0.5 / truth.px_per_m;
  truth.corner_m = {scene.floor_min.x() + half_pixel, scene.floor_max.y() - half_pixel};
  return truth;
}

FloorComparison CompareMappedFloor(const FloorPicture& map, const Scene& scene, const Similarity& X_WV,
                                   const std::optional<Similarity>& X_WV_start) {
  return CompareFloor(map, FloorTruthOf(scene, map.empty() ? 1 : map.cell_m), X_WV, {}, X_WV_start);
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
