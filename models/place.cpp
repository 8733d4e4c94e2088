#include "models/place.h"

#include <algorithm>

#include "models/place_builder.h"
#include "models/place_file.h"

namespace gaitcam {
namespace {

std::filesystem::path FindPlaceFile(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const std::filesystem::path path(name_or_path);
  if (path.has_parent_path() || path.extension() == ".yaml" || path.extension() == ".yml") return path;
  const std::filesystem::path shipped = models_folder / "places" / (name_or_path + ".yaml");
  if (std::filesystem::is_regular_file(shipped)) return shipped;
  const std::vector<std::string> places = ListPlaces(models_folder);
  const std::string near = NearestWord(name_or_path, places);
  std::string all;
  for (const std::string& place : places) all += (all.empty() ? "" : ", ") + place;
  throw BadInput(
      "place \"" + name_or_path + "\": no such place; " +
      (near.empty() ? "shipped are " + all + "; or give the path of a YAML file" : "did you mean " + near + "?"));
}

}  // namespace

Place ReadPlace(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const YamlNode root = YamlNode::LoadFile(FindPlaceFile(name_or_path, models_folder));
  PlaceFile file;
  ReadYaml(root, file);
  return BuildPlace(file, root);
}

std::vector<std::string> ListPlaces(const std::filesystem::path& models_folder) {
  std::vector<std::string> names;
  std::error_code missing;  // no folder: no places
  for (const auto& entry : std::filesystem::directory_iterator(models_folder / "places", missing)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace gaitcam
