/// Blocks of options that have presets: `KEY: WORD`, or a map of keys that differ from its preset.

#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

#include "algorithms/core/option_reader.h"
#include "models/code/yaml/yaml_writer.h"

namespace gaitcam {

/// @tparam Block a described struct with a described enum `preset`, whose first word means that nothing is changed, and
/// a `static Block Of(Preset)`.
template <class Block>
void ReadPresetBlock(const OptionValue& node, Block& value) {
  const OptionValue word = node.IsMap() ? node.Child("preset") : node;
  if (!node.IsMap() || node.Has("preset")) {
    decltype(value.preset) preset{};
    ReadOption(word, preset);
    value = Block::Of(preset);
  }
  if (node.IsMap()) ReadFields(node, value);
}

/// Whether the block changes nothing. Two blocks are the same if their files would be.
template <class Block>
bool IsPlainBlock(const Block& block) {
  const auto text = [](const Block& b) {
    YAML::Emitter out;
    WriteYaml(out, b);
    return std::string(out.c_str());
  };
  Block unnamed = block;
  unnamed.preset = {};
  return text(unnamed) == text(Block());
}

}  // namespace gaitcam
