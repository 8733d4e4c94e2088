#include "models/code/scenes/scene.h"

#include <algorithm>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/file_names.h"
#include "algorithms/core/random.h"
#include "models/code/scenes/scene_builder.h"
#include "models/code/scenes/scene_file.h"
#include "models/code/textures/texture.h"
#include "models/code/yaml/yaml_reader.h"

namespace gaitcam {
namespace {

std::filesystem::path FindSceneFile(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const std::filesystem::path path(name_or_path);
  if (path.has_parent_path() || path.extension() == ".yaml" || path.extension() == ".yml") return path;
  const std::filesystem::path shipped = models_folder / "scenes" / (name_or_path + ".yaml");
  if (IsFile(shipped)) return shipped;
  const std::vector<std::string> scenes = ListScenes(models_folder);
  throw BadInput(
      "scene \"" + name_or_path + "\": no such scene; " +
      DidYouMean(name_or_path, scenes, "shipped are " + JoinWords(scenes) + "; or give the path of a YAML file"));
}

constexpr size_t kMostBases = 8;

std::filesystem::path FindBase(const OptionValue& key, const std::string& base,
                               const std::filesystem::path& models_folder) {
  const std::filesystem::path beside = key.folder() / base;
  if (IsFile(beside)) return beside;
  try {
    const std::filesystem::path file = FindSceneFile(base, models_folder);
    if (IsFile(file)) return file;
  } catch (const BadInput& e) {
    key.Fail(e.what());
  }
  key.Fail("there is no file " + beside.string());
}

/// The file laid over its base, that over its own, and so on. @param bases receives their files.
OptionValue LoadScene(const std::filesystem::path& file, const std::filesystem::path& models_folder,
                      std::vector<std::filesystem::path>& bases) {
  const OptionValue root = LoadYaml(file);
  if (!root.Has("base")) return root;
  const OptionValue key = root.Child("base");
  if (bases.size() >= kMostBases) key.Fail("the bases lead to no end; expected at most 8, one after the other");
  std::string base;
  ReadOption(key, base);
  bases.push_back(FindBase(key, base, models_folder));
  return Overlay(LoadScene(bases.back(), models_folder, bases), root);
}

void MoveFurniture(const SceneVariation& variation, SceneFile& file) {
  for (size_t i = 0; i < file.furniture.size(); ++i) {
    RandomStream random(variation.draw, "variation.furniture" + std::to_string(i));
    const auto within = [&](double limit) { return random.Uniform(-limit, limit); };
    FurnitureEntry& piece = file.furniture[i];
    piece.at.x() += within(variation.furniture_m);
    piece.at.y() += within(variation.furniture_m);
    piece.yaw_deg += within(variation.furniture_deg);
  }
}

}  // namespace

Scene ReadScene(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  return ReadVariedScene(name_or_path, models_folder, {});
}

Scene ReadVariedScene(const std::string& name_or_path, const std::filesystem::path& models_folder,
                      const SceneVariation& variation) {
  std::vector<std::filesystem::path> bases;
  const OptionValue root = LoadScene(FindSceneFile(name_or_path, models_folder), models_folder, bases);
  SceneFile file;
  ReadOption(root, file);
  if (variation.seed) file.seed = *variation.seed;
  if (variation.furniture_m > 0 || variation.furniture_deg > 0) MoveFurniture(variation, file);
  Scene scene = BuildScene(file, root);
  scene.bases = std::move(bases);
  scene.light *= variation.light;
  return scene;
}

SceneTexture TextureOf(const std::string& name, const cv::Mat& bgr) {
  return {name, bgr.size(), [bgr] { return bgr; }};
}

std::vector<std::string> ListScenes(const std::filesystem::path& models_folder) {
  std::vector<std::string> names;
  std::error_code missing;  // no folder: no scenes
  for (const auto& entry : std::filesystem::directory_iterator(models_folder / "scenes", missing)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void AddPeople(const std::vector<PersonOptions>& people, Scene& scene) {
  if (people.empty()) return;
  if (scene.cloth_texture < 0) {
    if (int(scene.textures.size()) >= kMaxSceneTextures) {
      throw BadInput("people need one texture more than MuJoCo draws in a scene (" + std::to_string(kMaxSceneTextures) +
                     ")");
    }
    TextureOptions cloth;
    cloth.kind = "cloth";
    scene.cloth_texture = int(scene.textures.size());
    cloth = CompleteTexture(cloth);
    scene.cloth_size_m = cloth.size_m;
    scene.textures.push_back({"cloth", TextureSize(cloth), [cloth] { return MakeTexture(cloth); }});
  }
  scene.people.insert(scene.people.end(), people.begin(), people.end());
}

}  // namespace gaitcam
