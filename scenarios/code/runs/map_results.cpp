#include "scenarios/code/runs/map_results.h"

#include <fmt/format.h>

#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/clock.h"
#include "algorithms/core/errors.h"
#include "algorithms/io/landmark_map_file.h"
#include "algorithms/io/occupancy_grid_file.h"
#include "algorithms/io/place_graph_file.h"
#include "algorithms/io/pose_graph_file.h"
#include "algorithms/io/route_map_file.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/io/whole_file.h"
#include "results/reports/drive_film.h"
#include "results/reports/report_drive.h"
#include "results/reports/report_graph.h"
#include "results/reports/report_map.h"
#include "results/reports/report_poses.h"
#include "results/scoring/floor_pose.h"
#include "results/scoring/place_graph_score.h"
#include "results/scoring/route_map_score.h"
#include "scenarios/code/runs/mapped_floor.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

void WritePanoramas(const PlaceGraph& graph, const fs::path& folder) {
  fs::create_directories(folder);
  for (size_t n = 0; n < graph.nodes.size(); ++n) {
    if (graph.nodes[n].panorama.empty()) continue;
    const fs::path file = folder / fmt::format("place_{:03}.png", n);
    if (!cv::imwrite(file.string(), graph.nodes[n].panorama))
      throw MissingResource(file.string() + ": cannot be written");
  }
}

/// Of this run and, where its map goes on with one of earlier sessions, of those.
Trajectory TruthOfSessions(const RouteMap& map, const MapContext& context) {
  if (map.sessions.size() == 1) return context.truth;
  Trajectory truth = context.taught;
  for (StampedPose pose : context.truth) {
    pose.stamp_ns += int64_t(map.sessions.size() - 1) * kSessionApart_ns;
    truth.push_back(pose);
  }
  return truth;
}

}  // namespace

PeopleAt WhereWalk(std::shared_ptr<const std::vector<PersonWalk>> people) {
  return [people = std::move(people)](int64_t stamp_ns) {
    std::vector<Eigen::Vector2d> at;
    for (const PersonWalk& walk : *people) {
      at.emplace_back(walk.At(SecondsIntoWalk(stamp_ns))[size_t(PersonPart::kHips)].translation.head<2>());
    }
    return at;
  };
}

MapResult ResultOf(const FloorPicture& map, const MapContext& context) {
  if (!context.poses.HasPoses()) return {};
  const PoseErrors& poses = context.poses.last;
  const Pose start = poses.pairs.front().truth * poses.pairs.front().estimate.Inverse();
  const auto comparison = std::make_shared<const FloorComparison>(
      CompareMappedFloor(map, context.scene, poses.se3.X_WV, Similarity{1, start.rotation, start.translation}));
  MapResult result;
  result.scores = comparison->scores;
  for (const Score& score : Evaluate(FloorPoseMetrics(), MeasureFloorPoses(poses.pairs))) {
    result.scores.push_back(score);
  }
  result.write = [comparison](const fs::path& folder) { WriteMapPictures(*comparison, folder / "map"); };
  result.section = [comparison, &truth = context.truth, estimate = poses.aligned_se3] {
    return FloorReportSection(*comparison, truth, estimate);
  };
  return result;
}

MapResult ResultOf(const PlaceGraph& map, const MapContext& context) {
  const auto comparison =
      std::make_shared<const PlaceGraphComparison>(ComparePlaceGraph(map, context.truth, context.places));
  MapResult result;
  result.scores = comparison->scores;
  result.write = [comparison, &map](const fs::path& folder) {
    WritePlaceGraph(folder / "places.graphml", map, comparison->nodes_m);
    WritePanoramas(map, folder / "panoramas");
  };
  result.section = [comparison, &map] { return PlaceReportSection(*comparison, map); };
  return result;
}

MapResult ResultOf(const LandmarkMap& map, const MapContext&) {
  MapResult result;
  result.write = [&map](const fs::path& folder) { WriteLandmarkMap(folder / "landmarks.csv", map); };
  return result;
}

MapResult ResultOf(const OccupancyGrid& map, const MapContext&) {
  MapResult result;
  result.write = [&map](const fs::path& folder) { WriteOccupancyGrid(folder / "grid.yaml", map); };
  return result;
}

MapResult ResultOf(const RouteMap& map, const MapContext& context) {
  const auto truth = std::make_shared<const Trajectory>(TruthOfSessions(map, context));
  MapResult result;
  result.scores = CompareRouteMap(map, *truth).scores;
  result.write = [&map, truth](const fs::path& folder) {
    WriteRouteMap(folder / kRouteMapName, map);
    if (map.sessions.size() > 1) WriteTrajectory(folder / kTaughtName, *truth, TrajectoryFormat::kTum);
  };
  return result;
}

MapResult ResultOf(const TaughtDrive& map, const MapContext& context) {
  const auto comparison = std::make_shared<const DriveComparison>(
      CompareDrive(map, {context.truth, context.taught, context.people, context.carried}));
  MapResult result;
  result.scores = comparison->scores;
  const bool films = context.films;
  result.write = [comparison, &map, films](const fs::path& folder) {
    WriteWholeFile(folder / "drive.csv", DriveCsv(map, *comparison));
    if (films) WriteDriveFilm(folder / kDriveFilmName, map, *comparison);
  };
  result.section = [comparison, &map, films] {
    return DriveReportSection(*comparison, map, films ? kDriveFilmName : "");
  };
  return result;
}

MapResult ResultOf(const PoseGraph& map, const MapContext& context) {
  const auto comparison = std::make_shared<const PoseGraphComparison>(ComparePoseGraph(map, context.truth));
  MapResult result;
  result.scores = comparison->scores;
  result.write = [&map](const fs::path& folder) { WritePoseGraph(folder / "graph.g2o", map); };
  if (!context.poses.HasPoses()) return result;
  result.section = [comparison, &map, &truth = context.truth, X_WV = context.poses.last.se3.X_WV] {
    return PoseGraphReportSection(*comparison, map, truth, X_WV);
  };
  return result;
}

std::vector<MapResult> ResultsOf(const std::vector<Map>& maps, const MapContext& context) {
  std::vector<MapResult> results;
  for (const Map& map : maps) {
    results.push_back(std::visit([&](const auto& kind) { return ResultOf(kind, context); }, map));
  }
  return results;
}

}  // namespace gaitcam
