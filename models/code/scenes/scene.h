/// A scene: floor, walls, posters, boxes and lights, with textures generated from a seed.

#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/pose.h"
#include "models/code/people/crowd_cast.h"
#include "models/code/people/people.h"

namespace gaitcam {

/// A textured box, or something flat, in world coordinates.
///
/// A texture shows on all six faces. On the side faces the image's up is the box's +z; on the two z faces it is +y.
/// Seen from outside, right is up x outward normal, so nothing is mirrored: on the +z face right is +x. With a
/// `texture_size_m` the image repeats from the face's lower left corner. Flat things (walls, posters, cards) have their
/// thin axis as z, pointing out of the picture, so that their picture is also the projection along z.
struct SceneBox {
  std::string name;
  Pose X_WB;                                       ///< Box frame in the world.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< Full edges, m.
  int texture = -1;                                ///< Index into Scene::textures, or -1 for plain colour.
  Eigen::Vector3d rgb{0.8, 0.8, 0.8};              ///< Display (sRGB) values 0..1; used when there is no texture.
  Eigen::Vector2d texture_size_m{0, 0};  ///< One repeat of the texture spans this; 0: stretched over the face.
  bool collides = true;
};

/// One texture image; what it shows has a real size, so that repeats and scales are metric.
///
/// A scene's pictures take tens of megabytes and most of the time that reading it would take, and few who have a scene
/// look at them: they are made when asked for, the same each time, and not kept.
struct SceneTexture {
  std::string name;
  cv::Size size_px;
  std::function<cv::Mat()> make;  ///< CV_8UC3 (BGR), display (sRGB) values, row 0 on top.

  cv::Mat Bgr() const { return make(); }
};

/// A texture whose picture is there already.
SceneTexture TextureOf(const std::string& name, const cv::Mat& bgr);

struct SceneLight {
  Eigen::Vector3d position{0, 0, 2.5};
  Eigen::Vector3d direction{0, 0, -1};
  bool directional = false;
  double brightness = 0.5;  ///< Diffuse, 0..1.
  bool casts_shadow = false;
  Eigen::Vector3d rgb{1, 1, 1};  ///< Its colour: factors on the brightness.
};

/// MuJoCo 2.2.2 draws 100 textures, the sky among them, and reports no error beyond that.
inline constexpr int kMaxSceneTextures = 99;

struct Scene {
  std::string name;
  std::filesystem::path file;
  std::vector<std::filesystem::path> bases;            ///< Files of the scenes that it derives from, the nearest first.
  Eigen::Vector2d floor_min{-3, -3}, floor_max{3, 3};  ///< The textured floor's extent, m.
  int floor_texture = -1;
  Eigen::Vector2d floor_texture_size_m{1, 1};  ///< One repeat; the texture's row 0 lies towards +y. Its lower left
                                               ///< corner lies at floor_min.
  double floor_friction = 0.8;
  std::vector<SceneTexture> textures;
  std::vector<std::filesystem::path> pictures;  ///< Files that textures show, in the order of the textures.
  std::vector<SceneBox> boxes;                  ///< Walls, posters, furniture, table tops, lines, goals.
  std::vector<SceneLight> lights;
  std::vector<PersonOptions> people;  ///< Who walks or stands there; see AddPeople.
  std::optional<CrowdEntry> crowd;    ///< Who walks there to goals of their own; see AddCrowd.
  std::vector<CrowdSpot> spots;       ///< Places before posters and furniture, and seats.
  int cloth_texture = -1;             ///< Texture of their clothes; one repeat spans `cloth_size_m`.
  Eigen::Vector2d cloth_size_m{1, 1};
  double ambient = 0.4;                  ///< 0..1
  Eigen::Vector3d ambient_rgb{1, 1, 1};  ///< Its colour: factors on `ambient`.
  double light = 1;  ///< Factor on all light that reaches a camera's sensor, linear; pictures for people ignore it.
  Eigen::Vector3d background_rgb{0.55, 0.65, 0.75};  ///< Colour of the background.
  Eigen::Vector3d start{0, 0, 0};  ///< Where robots start unless the scenario says otherwise: x, y, yaw.
};

/// Reads a shipped scene by name, or any scene by path. Textures follow from the scene's own seed.
/// @throws BadInput naming file, line, key and what is expected.
Scene ReadScene(const std::string& name_or_path, const std::filesystem::path& models_folder);

/// In what a repeat of an experiment finds a scene otherwise. The defaults change nothing.
struct SceneVariation {
  std::optional<uint64_t> seed;               ///< Instead of the scene's own: textures, scattered posters and prints.
  double light = 1;                           ///< Factor on Scene::light.
  double furniture_m = 0, furniture_deg = 0;  ///< Each piece stands up to so far beside its place, along x and y.
  uint64_t draw = 0;                          ///< Seed of where pieces stand.
};

/// A scene as a repeat finds it. @throws BadInput as ReadScene; also if the scene with that seed has no room for its
/// scattered posters or prints.
Scene ReadVariedScene(const std::string& name_or_path, const std::filesystem::path& models_folder,
                      const SceneVariation& variation);

/// Names of the shipped scenes, sorted.
std::vector<std::string> ListScenes(const std::filesystem::path& models_folder);

/// The true floor as seen from straight above, with the prints and lines that lie on it, x to the right and y up,
/// `pixels_per_m` pixels per metre over the floor's extent. CV_8UC3, display values, without lighting.
cv::Mat FloorImage(const Scene& scene, double pixels_per_m);

/// Adds people to a scene, and the texture of their clothes.
/// @throws BadInput if the scene has no room for another texture.
void AddPeople(const std::vector<PersonOptions>& people, Scene& scene);

}  // namespace gaitcam
