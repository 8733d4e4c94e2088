// How does similarity fall with the distance between two places? Panoramas of runs in one and the same place, every one
// against every other, by the simulator's true positions. Prints a table: results/studies/khr1hv_loops.
//
//   gaitcam_place_distance RUN...     folders that `gaitcam run scenarios/khr1hv_loops.yaml --seed N` wrote

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/place_graph_file.h"
#include "algorithms/places/panorama_match.h"
#include "results/statistics.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
constexpr int kViewDeg = 41;  // of a view of 208 px in a panorama of 1830
constexpr double kSlackDeg = 15, kRigidDeg = 1;

struct Place {
  Eigen::Vector2d position_m;
  PanoramaSectors sectors;
};

struct Places {
  std::vector<Place> all;
  WaveletMap map;

  /// @throws BadInput if a run has no map, no true positions or no panoramas.
  void Read(const fs::path& run) {
    const PlaceGraphFile file = ReadPlaceGraph(run / "places.graphml");
    if (file.positions_m.empty()) throw BadInput((run / "places.graphml").string() + ": places have no x_m and y_m");
    for (size_t k = 0; k < file.positions_m.size(); ++k) {
      const fs::path picture = run / "panoramas" / fmt::format("place_{:03d}.png", k);
      const cv::Mat panorama = cv::imread(picture.string(), cv::IMREAD_GRAYSCALE);
      if (panorama.empty()) throw BadInput(picture.string() + ": is no picture");
      const WaveletEncoder encoder(panorama.rows);
      map.Add(encoder.OfPanorama(panorama));
      all.push_back({file.positions_m[k], SectorsOf(encoder, panorama, panorama.cols * kViewDeg / 360)});
    }
  }
};

/// Similarities of pairs so far apart.
struct Row {
  double from_m, to_m;
  std::vector<double> view, ring, sectors;
};

void Compare(const Places& places, std::vector<Row>& rows) {
  for (size_t a = 0; a < places.all.size(); ++a) {
    for (size_t b = 0; b < places.all.size(); ++b) {
      const double distance_m = (places.all[a].position_m - places.all[b].position_m).norm();
      for (Row& row : rows) {
        if (a == b || distance_m < row.from_m || distance_m >= row.to_m) continue;
        const PanoramaSectors& sectors = places.all[a].sectors;
        row.view.push_back(places.map.Query(sectors.views[a % sectors.views.size()], b).similarity);
        row.ring.push_back(MatchPanorama(places.map, b, sectors, kRigidDeg).similarity);
        row.sectors.push_back(MatchPanorama(places.map, b, sectors, kSlackDeg).similarity);
      }
    }
  }
}

std::string Cell(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", MedianOf(values), QuantileOf(values, 0.05), QuantileOf(values, 0.95));
}

int Main(const std::vector<std::string>& runs) {
  Places places;
  for (const std::string& run : runs) places.Read(run);
  std::vector<Row> rows;
  constexpr std::array<double, 10> kEdges{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.5, 10};
  for (size_t k = 0; k + 1 < kEdges.size(); ++k) rows.push_back({kEdges[k], kEdges[k + 1], {}, {}, {}});
  Compare(places, rows);
  fmt::print("| apart, m | pairs | one view | whole ring | sectors |\n|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    fmt::print("| {} to {} | {} | {} | {} | {} |\n", row.from_m, row.to_m, row.view.size(), Cell(row.view),
               Cell(row.ring), Cell(row.sectors));
  }
  return 0;
}

}  // namespace
}  // namespace gaitcam

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw gaitcam::BadInput("usage: gaitcam_place_distance RUN...");
    return gaitcam::Main({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "gaitcam_place_distance: {}\n", error.what());
    return 2;
  }
}
