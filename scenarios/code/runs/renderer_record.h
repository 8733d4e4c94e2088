/// Who rendered, as the files of runs, recordings and caches say it: under the keys `renderer`, `software_renderer`,
/// `egl_device` (where EGL has a number for it) and `opengl`.

#pragma once

#include "sim/camera/renderer_choice.h"

namespace gaitcam {

/// @param json an object of nlohmann's, ordered or not.
template <class Json>
void WriteRenderer(const RendererInfo& info, Json& json) {
  json["renderer"] = info.name;
  json["software_renderer"] = info.is_software;
  if (info.egl_device) json["egl_device"] = *info.egl_device;
  json["opengl"] = info.version;
}

/// Recordings of earlier versions lack `egl_device` and `opengl`. @throws nlohmann's exception where another is
/// missing.
template <class Json>
RendererInfo ReadRenderer(const Json& json) {
  RendererInfo info;
  info.name = json.at("renderer");
  info.is_software = json.at("software_renderer");
  if (json.contains("egl_device")) info.egl_device = json.at("egl_device").template get<int>();
  info.version = json.value("opengl", "");
  return info;
}

}  // namespace gaitcam
