#include "models/place_file.h"

#include <algorithm>

namespace gaitcam {

void ReadYaml(const YamlNode& node, TextureUse& use) {
  use.node = node;
  if (node.node().IsMap()) {
    use.options.emplace();
    ReadYaml(node, *use.options);
  } else {
    ReadYaml(node, use.name);
  }
}

void ReadYaml(const YamlNode& node, std::map<std::string, TextureOptions>& textures) {
  if (!node.node().IsMap()) node.Fail("expected a map of names and textures");
  textures.clear();
  for (const auto& entry : node.node()) {
    const std::string name = entry.first.Scalar();
    const YamlNode child = node.Child(name);
    if (textures.count(name)) child.Fail("this name is given twice");
    ReadYaml(child, textures[name]);
  }
}

}  // namespace gaitcam
