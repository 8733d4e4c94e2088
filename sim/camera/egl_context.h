/// An OpenGL context without a window: on a GPU where there is one, in software (Mesa) otherwise.

#pragma once

#include <string>

namespace gaitcam {

/// One per thread. The context is current on the creating thread from construction to destruction; everything that
/// draws (Renderer) must be destroyed before it. Never fork while one exists: the child's copy of the driver is broken.
///
/// The environment variable GAITCAM_EGL overrides the choice: "gpu" (fail without one), "software" (Mesa on the CPU),
/// or "device:N" (the N-th EGL device, from 0). Unset or "auto": the first GPU that gives a context, else software.
class EglContext {
 public:
  /// @throws MissingResource with one line if no device gives a desktop OpenGL context; BadInput for an unknown
  /// GAITCAM_EGL.
  EglContext();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes the context current on this thread, after another one was in between.
  void MakeCurrent() const;

  const std::string& vendor() const { return vendor_; }  ///< GL_VENDOR.
  const std::string& renderer() const {
    return renderer_;
  }                                                        ///< GL_RENDERER, for example "llvmpipe (LLVM 15, 256 bits)".
  const std::string& version() const { return version_; }  ///< GL_VERSION.
  /// Drawn by the CPU: some 40 to 400 times slower than a GPU.
  bool is_software() const { return is_software_; }

 private:
  bool TryDisplay(void* display);
  bool TryDevices(int only_index, bool software);
  void Describe();

  // EGL's own handles are void*; its headers stay out of this one, as they define macros of common names.
  void* display_ = nullptr;
  void* context_ = nullptr;
  std::string vendor_, renderer_, version_;
  bool is_software_ = false;
};

}  // namespace gaitcam
