/// What a run says of the maps that its system made: scores, files, and a section of the report.
///
/// This is the one place that knows all kinds of map (algorithms/core/map.h): a new kind has one overload of ResultOf.

#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "algorithms/core/map.h"
#include "algorithms/core/trajectory.h"
#include "models/code/people/person_walk.h"
#include "models/code/scenes/scene.h"
#include "results/reports/report.h"
#include "results/scoring/drive_score.h"
#include "results/scoring/place_graph_score.h"
#include "results/scoring/score.h"

namespace gaitcam {

/// What a map is compared with.
struct MapContext {
  const Scene& scene;
  const Trajectory& truth;   ///< X_WC of the camera.
  const Trajectory& taught;  ///< X_WC of the walk that taught the map that the run was given; empty if unknown.
  const Scores& poses;       ///< Their SE(3) alignment moves the map into the world of the truth.
  PeopleAt people;
  std::optional<CarriedSpan> carried;
  PlaceGraphScoreOptions places;  ///< When its loops are right.
  bool films = false;             ///< Whether the run makes films.
};

/// The middle of each person's body, seen from above.
PeopleAt WhereWalk(std::shared_ptr<const std::vector<PersonWalk>> people);

struct MapResult {
  std::vector<Score> scores;
  /// Files of its own in a run's folder. @throws MissingResource if they cannot be written.
  std::function<void(const std::filesystem::path& folder)> write = [](const std::filesystem::path&) {};
  /// On the run's page.
  std::function<ReportSection()> section = [] { return ReportSection(); };
};

/// map/{estimate,mask,truth,difference}.png. Without poses nothing aligns the picture, and nothing is compared.
MapResult ResultOf(const FloorPicture& map, const MapContext& context);
/// places.graphml (with the true positions of the places) and panoramas/*.png. @throws TooLittleData without truth.
MapResult ResultOf(const PlaceGraph& map, const MapContext& context);
/// landmarks.csv.
MapResult ResultOf(const LandmarkMap& map, const MapContext& context);
/// grid.png and grid.yaml, as ROS's map_server reads them.
MapResult ResultOf(const OccupancyGrid& map, const MapContext& context);

/// Beside the map of several sessions: X_WC of all of them, TUM format, stamps as the map's.
inline constexpr const char* kTaughtName = "taught.txt";

/// route.map and, of several sessions, taught.txt.
MapResult ResultOf(const RouteMap& map, const MapContext& context);
/// drive.csv and, if the run makes films, drive.mp4.
MapResult ResultOf(const TaughtDrive& map, const MapContext& context);

/// graph.g2o.
MapResult ResultOf(const PoseGraph& map, const MapContext& context);

/// Of each map in turn. The results refer to `maps` and to the true trajectory, which must outlive them.
std::vector<MapResult> ResultsOf(const std::vector<Map>& maps, const MapContext& context);

}  // namespace gaitcam
