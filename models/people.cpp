#include "models/people.h"

#include "models/place.h"
#include "models/texture.h"

namespace gaitcam {
namespace {

constexpr double kSlowest = 0.1;  // m/s; slower than that, nobody walks
constexpr int kMostTextures = 99;

void CheckColor(const YamlNode& node, const std::string& key, const Eigen::Vector3d& rgb) {
  if (rgb.allFinite() && rgb.minCoeff() >= 0 && rgb.maxCoeff() <= 1) return;
  node.Child(key).Fail("expected three numbers from 0 to 1");
}

void CheckPath(const YamlNode& node, const PersonOptions& person) {
  if (person.path.empty()) {
    (node.Has("path") ? node.Child("path") : node).Fail("path: missing; expected [[x, y], ...], one point or more");
  }
  const YamlNode path = node.Child("path");
  for (size_t i = 0; i < person.path.size(); ++i) {
    if (!person.path[i].allFinite()) path.Element(i).Fail("expected two finite numbers");
    if (i > 0 && (person.path[i] - person.path[i - 1]).norm() < 0.05) {
      path.Element(i).Fail("expected a point at least 0.05 m from the one before");
    }
  }
  if (person.speed_m_s == 0) return;
  if (person.path.size() < 2) {
    path.Fail("expected two points or more for somebody who walks; speed_m_s: 0 stands at one");
  }
  if (person.speed_m_s < kSlowest) {
    node.Child("speed_m_s").Fail("expected 0, or " + internal::NumberText(kSlowest) + " and more");
  }
}

}  // namespace

void ReadYaml(const YamlNode& node, PersonOptions& person) {
  if (!node.node().IsMap()) node.Fail("expected a map {path: [[x, y], ...], speed_m_s: ..., ...}");
  node.RejectUnknownKeys(FieldKeys<PersonOptions>());
  internal::YamlFieldReader reader{node};
  VisitFields(reader, person);
  CheckPath(node, person);
  CheckColor(node, "trousers_rgb", person.trousers_rgb);
  CheckColor(node, "top_rgb", person.top_rgb);
  CheckColor(node, "shoes_rgb", person.shoes_rgb);
  CheckColor(node, "soles_rgb", person.soles_rgb);
  CheckColor(node, "skin_rgb", person.skin_rgb);
  CheckColor(node, "hair_rgb", person.hair_rgb);
}

void AddPeople(const std::vector<PersonOptions>& people, Place& place) {
  if (people.empty()) return;
  if (place.cloth_texture < 0) {
    if (int(place.textures.size()) >= kMostTextures) {
      throw BadInput("people need one texture more than MuJoCo draws in a place (" + std::to_string(kMostTextures) +
                     ")");
    }
    TextureOptions cloth;
    cloth.kind = "cloth";
    place.cloth_texture = int(place.textures.size());
    cloth = CompleteTexture(cloth);
    place.cloth_size_m = cloth.size_m;
    place.textures.push_back({"cloth", MakeTexture(cloth)});
  }
  place.people.insert(place.people.end(), people.begin(), people.end());
}

}  // namespace gaitcam
