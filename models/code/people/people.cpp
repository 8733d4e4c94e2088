#include "models/code/people/people.h"

namespace gaitcam {
namespace {

constexpr double kMinSpeed = 0.1;  // m/s

void CheckColor(const OptionValue& node, const std::string& key, const Eigen::Vector3d& rgb) {
  if (rgb.allFinite() && rgb.minCoeff() >= 0 && rgb.maxCoeff() <= 1) return;
  node.Child(key).Fail("expected three numbers from 0 to 1");
}

void CheckPath(const OptionValue& node, const PersonOptions& person) {
  if (person.path.empty()) {
    (node.Has("path") ? node.Child("path") : node).Fail("path: missing; expected [[x, y], ...], one point or more");
  }
  const OptionValue path = node.Child("path");
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
  if (person.speed_m_s < kMinSpeed) {
    node.Child("speed_m_s").Fail("expected 0, or " + internal::NumberText(kMinSpeed) + " and more");
  }
}

}  // namespace

void ReadOption(const OptionValue& node, PersonOptions& person) {
  if (!node.IsMap()) node.Fail("expected a map {path: [[x, y], ...], speed_m_s: ..., ...}");
  ReadFields(node, person);
  CheckPath(node, person);
  CheckColor(node, "trousers_rgb", person.trousers_rgb);
  CheckColor(node, "top_rgb", person.top_rgb);
  CheckColor(node, "shoes_rgb", person.shoes_rgb);
  CheckColor(node, "soles_rgb", person.soles_rgb);
  CheckColor(node, "skin_rgb", person.skin_rgb);
  CheckColor(node, "hair_rgb", person.hair_rgb);
}

}  // namespace gaitcam
