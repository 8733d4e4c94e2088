/// Who is asked to render, and who did: `camera.renderer` of a scenario, and what a run says of it.

#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "algorithms/core/option_value.h"

namespace YAML {
class Emitter;
}

namespace gaitcam {

/// Who did. Pictures of two renderers may differ in single grey levels.
struct RendererInfo {
  std::string name;     ///< GL_RENDERER, for example "llvmpipe (LLVM 15.0.6, 256 bits)".
  std::string vendor;   ///< GL_VENDOR.
  std::string version;  ///< GL_VERSION: OpenGL's and the driver's.
  /// Drawn by the CPU: some 40 to 400 times slower than a GPU.
  bool is_software = false;
  std::optional<int> egl_device;  ///< Its number among this machine's EGL devices (egl_context.h), where EGL has one.

  /// One line: "llvmpipe (LLVM 15.0.6, 256 bits), software, EGL device 0, OpenGL 4.5 ...".
  std::string ToText() const;
  /// On one machine, renderers of the same key draw the same pictures to the bit, on whichever device.
  std::string Key() const { return name + " " + version; }
};

/// `auto`: the first GPU that gives an OpenGL context, else software. `gpu` and `software` accept nothing else.
/// `device:N`: the N-th EGL device, from 0. What a scenario shows does not depend on it, so that hashes of frames and
/// baselines leave it out; caches of frames are keyed by who rendered (RendererInfo::Key).
struct RendererChoice {
  enum class Kind { kAuto, kGpu, kSoftware, kDevice };
  Kind kind = Kind::kAuto;
  int device = 0;  ///< With kDevice.

  /// @returns nothing for a text that is none.
  static std::optional<RendererChoice> FromText(std::string_view text);
  std::string ToText() const;
  /// False where the choice rules out who rendered.
  bool Permits(bool software_renderer) const;
  bool operator==(const RendererChoice&) const = default;
};

/// What FromText accepts, for messages.
std::string PermittedRenderers();

/// @throws BadOption naming file, line, key and what is permitted.
void ReadOption(const OptionValue& node, RendererChoice& value);
void WriteYaml(YAML::Emitter& out, const RendererChoice& value);
/// `auto` says nothing of the machine, and a resolved scenario does not show it.
inline bool SaysNothing(const RendererChoice& value) { return value == RendererChoice(); }

}  // namespace gaitcam
