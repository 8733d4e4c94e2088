#include "models/code/scenes/scene.h"

#include <algorithm>

#include "algorithms/core/did_you_mean.h"
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
  if (std::filesystem::is_regular_file(shipped)) return shipped;
  const std::vector<std::string> scenes = ListScenes(models_folder);
  throw BadInput(
      "scene \"" + name_or_path + "\": no such scene; " +
      DidYouMean(name_or_path, scenes, "shipped are " + JoinWords(scenes) + "; or give the path of a YAML file"));
}

}  // namespace

Scene ReadScene(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const OptionValue root = LoadYaml(FindSceneFile(name_or_path, models_folder));
  SceneFile file;
  ReadOption(root, file);
  return BuildScene(file, root);
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
