#include "sim/camera/egl_context.h"

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr unsigned kGlVendor = 0x1F00, kGlRenderer = 0x1F01, kGlVersion = 0x1F02;

template <class Function>
Function Load(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

bool HasWord(const char* list, const char* word) {
  if (list == nullptr) return false;
  const size_t length = std::strlen(word);
  for (const char* at = std::strstr(list, word); at != nullptr; at = std::strstr(at + 1, word)) {
    const bool starts = at == list || at[-1] == ' ';
    if (starts && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

/// An 8-bit RGBA, 24-bit depth, 8-bit stencil configuration of desktop OpenGL, or null.
EGLConfig ChooseConfig(EGLDisplay display) {
  const EGLint wanted[] = {EGL_RED_SIZE,
                           8,
                           EGL_GREEN_SIZE,
                           8,
                           EGL_BLUE_SIZE,
                           8,
                           EGL_ALPHA_SIZE,
                           8,
                           EGL_DEPTH_SIZE,
                           24,
                           EGL_STENCIL_SIZE,
                           8,
                           EGL_SURFACE_TYPE,
                           EGL_PBUFFER_BIT,
                           EGL_RENDERABLE_TYPE,
                           EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count) || count == 0) return nullptr;
  return config;
}

bool LooksLikeSoftware(const std::string& renderer) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"}) {
    if (renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

EglContext::EglContext() {
  const char* variable = std::getenv("GAITCAM_EGL");
  const std::string choice = variable == nullptr || *variable == '\0' ? "auto" : variable;
  bool made = false;
  if (choice == "auto" || choice == "gpu") made = TryDevices(-1, false);
  if (!made && (choice == "auto" || choice == "software")) {
    const auto get_display = Load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (get_display != nullptr && HasWord(extensions, "EGL_MESA_platform_surfaceless")) {
      made = TryDisplay(get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
    }
    if (!made) made = TryDevices(-1, true);
  } else if (!made && choice.rfind("device:", 0) == 0) {
    char* end = nullptr;
    const long index = std::strtol(choice.c_str() + 7, &end, 10);
    if (end == choice.c_str() + 7 || *end != '\0' || index < 0) {
      throw BadInput("GAITCAM_EGL=" + choice + ": expected auto, gpu, software or device:N");
    }
    made = TryDevices(int(index), true);
  } else if (!made && choice != "gpu") {
    throw BadInput("GAITCAM_EGL=" + choice + ": expected auto, gpu, software or device:N");
  }
  if (!made) {
    throw MissingResource(
        "no EGL device gives an OpenGL context (GAITCAM_EGL=" + choice +
        "); install a GPU driver with EGL, or Debian's libegl-mesa0 and libgl1-mesa-dri for software");
  }
  Describe();
}

EglContext::~EglContext() {
  // The display is not terminated: EGL displays belong to the process, and another context may live on this one.
  if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

void EglContext::MakeCurrent() const {
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
    throw MissingResource("the OpenGL context cannot be made current on this thread");
  }
}

bool EglContext::TryDisplay(void* display) {
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return false;
  const EGLConfig config = ChooseConfig(display);
  if (config == nullptr || !eglBindAPI(EGL_OPENGL_API)) return false;
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, nullptr);
  if (context == EGL_NO_CONTEXT) return false;
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglDestroyContext(display, context);
    return false;
  }
  display_ = display;
  context_ = context;
  return true;
}

bool EglContext::TryDevices(int only_index, bool software) {
  const auto query_devices = Load<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  const auto query_string = Load<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const auto get_display = Load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (query_devices == nullptr || query_string == nullptr || get_display == nullptr) return false;
  std::array<EGLDeviceEXT, 64> devices;
  EGLint count = 0;
  if (!query_devices(EGLint(devices.size()), devices.data(), &count)) return false;
  for (int i = 0; i < count; ++i) {
    if (only_index >= 0 && i != only_index) continue;
    const bool is_software = HasWord(query_string(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software");
    if (is_software && !software) continue;
    if (TryDisplay(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr))) return true;
  }
  return false;
}

void EglContext::Describe() {
  using GetString = const unsigned char* (*)(unsigned);
  const auto get_string = Load<GetString>("glGetString");
  const auto text = [&](unsigned name) {
    const unsigned char* value = get_string == nullptr ? nullptr : get_string(name);
    return value == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(value));
  };
  vendor_ = text(kGlVendor);
  renderer_ = text(kGlRenderer);
  version_ = text(kGlVersion);
  is_software_ = LooksLikeSoftware(renderer_);
}

}  // namespace gaitcam
