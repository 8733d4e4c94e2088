#include "models/code/scenes/scene_file.h"

#include <algorithm>

namespace gaitcam {

void ReadOption(const OptionValue& node, TextureUse& use) {
  use.node = node;
  if (node.IsMap()) {
    use.options.emplace();
    ReadOption(node, *use.options);
  } else {
    ReadOption(node, use.name);
  }
}

void ReadOption(const OptionValue& node, std::map<std::string, TextureOptions>& textures) {
  if (!node.IsMap()) node.Fail("expected a map of names and textures");
  textures.clear();
  for (const auto& entry : node.entries()) {
    const OptionValue child = node.Child(entry.key);
    if (textures.count(entry.key)) child.Fail("this name is given twice");
    ReadOption(child, textures[entry.key]);
  }
}

}  // namespace gaitcam
