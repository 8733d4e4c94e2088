#include "models/code/scenes/scene_crowd.h"

#include "models/code/scenes/footprint.h"

namespace gaitcam {

CrowdRoom RoomOf(const Scene& scene) {
  constexpr double kHead_m = 2.0;  // what hangs higher is in nobody's way
  CrowdRoom room;
  room.min = scene.floor_min;
  room.max = scene.floor_max;
  room.spots = scene.spots;
  for (const SceneBox& box : scene.boxes) {
    FloorPolygon area;
    for (const cv::Point2f& corner : Footprint(box, kHead_m)) area.emplace_back(corner.x, corner.y);
    if (!area.empty()) room.obstacles.push_back(std::move(area));
  }
  return room;
}

void AddCrowd(const CrowdPlan& plan, Scene& scene) {
  std::erase_if(scene.people, [](const PersonOptions& person) { return person.course != nullptr; });
  AddPeople(SimulateCrowd(plan, RoomOf(scene)), scene);
}

}  // namespace gaitcam
