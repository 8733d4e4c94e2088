#include "sim/camera/renderer_choice.h"

#include <charconv>

#include "algorithms/core/option_reader.h"
#include "models/code/yaml/yaml_writer.h"

namespace gaitcam {
namespace {

constexpr std::string_view kDevice = "device:";

Words ChoiceWords() { return OneOf({"auto", "gpu", "software", "device:N"}); }

}  // namespace

std::string RendererInfo::ToText() const {
  return name + (is_software ? ", software" : "") +
         (egl_device ? ", EGL device " + std::to_string(*egl_device) : std::string()) +
         (version.empty() ? "" : ", OpenGL " + version);
}

std::optional<RendererChoice> RendererChoice::FromText(std::string_view text) {
  if (text == "auto") return RendererChoice{Kind::kAuto};
  if (text == "gpu") return RendererChoice{Kind::kGpu};
  if (text == "software") return RendererChoice{Kind::kSoftware};
  if (!text.starts_with(kDevice)) return std::nullopt;
  RendererChoice choice{Kind::kDevice};
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + kDevice.size(), end, choice.device);
  if (error != std::errc() || rest != end || choice.device < 0) return std::nullopt;
  return choice;
}

std::string RendererChoice::ToText() const {
  switch (kind) {
    case Kind::kAuto: return "auto";
    case Kind::kGpu: return "gpu";
    case Kind::kSoftware: return "software";
    case Kind::kDevice: return std::string(kDevice) + std::to_string(device);
  }
  GAITCAM_ASSERT(false);
  return {};
}

bool RendererChoice::Permits(bool software_renderer) const {
  return !(kind == Kind::kGpu && software_renderer) && !(kind == Kind::kSoftware && !software_renderer);
}

std::string PermittedRenderers() { return ChoiceWords().ToText(); }

void ReadOption(const OptionValue& node, RendererChoice& value) {
  std::string text;
  ReadOption(node, text);
  const std::optional<RendererChoice> choice = RendererChoice::FromText(text);
  if (!choice) throw BadOption(node.Located(ChoiceWords().Refusal(text)));
  value = *choice;
}

void WriteYaml(YAML::Emitter& out, const RendererChoice& value) { WriteYaml(out, value.ToText()); }

}  // namespace gaitcam
