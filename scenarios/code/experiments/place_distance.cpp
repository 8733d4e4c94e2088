#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/io/place_graph_file.h"
#include "algorithms/places/panorama_match.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/experiments/table_experiment.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
constexpr int kViewDeg = 41;  // of a view of 208 px in a panorama of 1830
constexpr double kSlackDeg = 15, kRigidDeg = 1;

struct PlaceDistanceOptions {
  InputPaths runs;
};

template <class Visitor>
void VisitFields(Visitor& visit, PlaceDistanceOptions& o) {
  visit("runs", o.runs, Nested(), "folders of runs of scenarios/khr1hv_loops.yaml with several seeds");
}

struct Scene {
  Eigen::Vector2d position_m;
  PanoramaSectors sectors;
};

struct Places {
  std::vector<Scene> all;
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

/// How similarity falls with the distance between two places: panoramas of runs in one and the same scene, every one
/// against every other, by the simulator's true positions.
class PlaceDistance : public ExperimentOf<PlaceDistanceOptions> {
 public:
  void Run(const ExperimentSetup& setup) override {
    if (options_.runs.paths.empty()) throw BadInput("runs: name at least one folder of a run");
    command_ = setup.command;
    Places places;
    for (const std::string& run : options_.runs.paths) places.Read(run);
    constexpr std::array<double, 10> kEdges{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.5, 10};
    for (size_t k = 0; k + 1 < kEdges.size(); ++k) rows_.push_back({kEdges[k], kEdges[k + 1], {}, {}, {}});
    Compare(places, rows_);
  }
  std::string Table() const override {
    std::string text = fmt::format(
        "# Similarity of panoramas over distance\n\nMade by `{}`. Median and 5 to 95 % of all ordered pairs.\n\n"
        "| apart, m | pairs | one view | whole ring | sectors |\n|---|---|---|---|---|\n",
        command_);
    for (const Row& row : rows_) {
      text += fmt::format("| {} to {} | {} | {} | {} | {} |\n", row.from_m, row.to_m, row.view.size(), Cell(row.view),
                          Cell(row.ring), Cell(row.sectors));
    }
    return text;
  }

 private:
  std::string command_;
  std::vector<Row> rows_;
};

}  // namespace

std::unique_ptr<TableExperiment> MakePlaceDistance() { return std::make_unique<PlaceDistance>(); }

}  // namespace gaitcam
