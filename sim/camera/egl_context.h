/// An OpenGL context without a window: on a GPU where there is one, in software (Mesa) otherwise; and the devices that
/// EGL offers for it.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/camera/renderer_choice.h"

namespace gaitcam {

/// What EGL says of a device before anything is drawn on it.
struct EglDevice {
  int index = 0;             ///< N of `device:N`: its place in EGL's list.
  bool is_software = false;  ///< By its own word; a driver may still render in software.
  std::string name;          ///< EGL_RENDERER_EXT; empty where EGL does not tell.
  std::string drm_node;      ///< Such as "/dev/dri/renderD128"; empty where EGL does not tell.
  std::optional<int> cuda;   ///< CUDA's number of it.
  void* handle = nullptr;    ///< EGL's.
};

/// A device after a context was tried on it.
struct EglDeviceReport {
  EglDevice device;
  RendererInfo opengl;  ///< If there was one.
  std::string failure;  ///< Why no desktop OpenGL context came up; empty if one did.

  /// One line: "llvmpipe (LLVM 15.0.6, 256 bits), software, OpenGL 4.5 ...", with DRM node and CUDA number if known.
  std::string ToText() const;
};

/// All devices in EGL's order, a context tried on one after the other; whatever was current on this thread is again.
std::vector<EglDeviceReport> ListEglDevices();

/// One per thread. The context is current on the creating thread from construction to destruction; everything that
/// draws (Renderer) must be destroyed before it. Never fork while one exists: the child's copy of the driver is broken.
class EglContext {
 public:
  /// The environment variable GAITCAM_EGL, if it is set, overrides the choice in the same words.
  /// @throws MissingResource with one line that says which devices there are, if none that is permitted gives a desktop
  /// OpenGL context; BadInput for an unknown GAITCAM_EGL.
  explicit EglContext(const RendererChoice& choice = {});
  /// On this device, whatever the environment says. @throws MissingResource saying why it gives no context.
  explicit EglContext(const EglDevice& device);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes the context current on this thread, after another one was in between.
  void MakeCurrent() const;

  const RendererInfo& info() const { return info_; }

 private:
  bool TryDevices(const std::vector<EglDevice>& devices, bool software);
  bool TrySurfaceless(const RendererChoice& choice);
  std::string Open(const EglDevice& device);
  std::string Open(void* display);
  void Close();
  void Describe();

  // EGL's own handles are void*; its headers stay out of this one, as they define macros of common names.
  void* display_ = nullptr;
  void* context_ = nullptr;
  RendererInfo info_;
};

/// RendererInfo::Key of who renders by this choice, or by what GAITCAM_EGL says instead: part of the name of cached
/// frames. Costs a context when asked for the first time; none may be current. @throws as EglContext does.
std::string RendererKey(const RendererChoice& choice);

}  // namespace gaitcam
