#include "sim/camera/egl_context.h"

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr unsigned kGlVendor = 0x1F00, kGlRenderer = 0x1F01, kGlVersion = 0x1F02;
constexpr EGLint kDeviceName = 0x335F;  // EGL_RENDERER_EXT of EGL_EXT_device_query_name
constexpr const char* kInstall =
    "install a GPU driver with EGL, or Debian's libegl-mesa0 and libgl1-mesa-dri for software";

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

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

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

/// "eglInitialize: EGL_NOT_INITIALIZED"
std::string Failed(const char* call) {
  const EGLint error = eglGetError();
  const std::string said = std::string(call) + " failed";
  switch (error) {
    case EGL_SUCCESS: return said;
    case EGL_NOT_INITIALIZED: return said + ": EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS: return said + ": EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC: return said + ": EGL_BAD_ALLOC";
    case EGL_BAD_MATCH: return said + ": EGL_BAD_MATCH";
    case EGL_BAD_DISPLAY: return said + ": EGL_BAD_DISPLAY";
    case EGL_BAD_PARAMETER: return said + ": EGL_BAD_PARAMETER";
    case EGL_CONTEXT_LOST: return said + ": EGL_CONTEXT_LOST";
    default: return said + ": EGL error " + std::to_string(error);
  }
}

EglDevice DeviceOf(int index, EGLDeviceEXT handle) {
  const auto query_string = Load<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const auto query_attribute = Load<PFNEGLQUERYDEVICEATTRIBEXTPROC>("eglQueryDeviceAttribEXT");
  EglDevice device;
  device.index = index;
  device.handle = handle;
  if (query_string == nullptr) return device;
  const char* extensions = query_string(handle, EGL_EXTENSIONS);
  const auto has = [&](const char* word) { return HasWord(extensions, word); };
  device.is_software = has("EGL_MESA_device_software");
  if (has("EGL_EXT_device_query_name")) device.name = TextOf(query_string(handle, kDeviceName));
  if (has("EGL_EXT_device_drm_render_node"))
    device.drm_node = TextOf(query_string(handle, EGL_DRM_RENDER_NODE_FILE_EXT));
  if (device.drm_node.empty() && has("EGL_EXT_device_drm"))
    device.drm_node = TextOf(query_string(handle, EGL_DRM_DEVICE_FILE_EXT));
  EGLAttrib cuda = 0;
  if (query_attribute != nullptr && has("EGL_NV_device_cuda") && query_attribute(handle, EGL_CUDA_DEVICE_NV, &cuda))
    device.cuda = int(cuda);
  return device;
}

/// Without trying anything on them.
std::vector<EglDevice> EnumerateDevices() {
  const auto query_devices = Load<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  EGLint count = 0;
  if (query_devices == nullptr || !query_devices(0, nullptr, &count) || count <= 0) return {};
  std::vector<EGLDeviceEXT> handles(static_cast<size_t>(count));
  if (!query_devices(count, handles.data(), &count)) return {};
  std::vector<EglDevice> devices;
  for (int i = 0; i < std::min(count, EGLint(handles.size())); ++i) devices.push_back(DeviceOf(i, handles[size_t(i)]));
  return devices;
}

/// Makes current on this thread what was so when it was created.
class CurrentAgain {
 public:
  ~CurrentAgain() {
    if (context_ != EGL_NO_CONTEXT) eglMakeCurrent(display_, draw_, read_, context_);
  }

 private:
  EGLDisplay display_ = eglGetCurrentDisplay();
  EGLContext context_ = eglGetCurrentContext();
  EGLSurface draw_ = eglGetCurrentSurface(EGL_DRAW), read_ = eglGetCurrentSurface(EGL_READ);
};

struct AskedRenderer {
  RendererChoice choice;
  std::string text;  ///< As a message shows it: "GAITCAM_EGL=gpu", "camera.renderer = gpu".
};

/// @throws BadInput if the environment says what is no choice.
AskedRenderer Asked(const RendererChoice& choice) {
  const char* variable = std::getenv("GAITCAM_EGL");
  if (variable == nullptr || *variable == '\0') return {choice, "camera.renderer = " + choice.ToText()};
  const std::string text = std::string("GAITCAM_EGL=") + variable;
  const std::optional<RendererChoice> said = RendererChoice::FromText(variable);
  if (!said) throw BadInput(text + ": expected " + PermittedRenderers());
  return {*said, text};
}

/// "; EGL lists device 0: llvmpipe ..., software; device 1: ..."
std::string WhatIsThere() {
  std::string text;
  for (const EglDeviceReport& report : ListEglDevices())
    text += (text.empty() ? "" : "; ") + ("device " + std::to_string(report.device.index)) + ": " + report.ToText();
  return text.empty() ? "EGL lists no device" : "EGL lists " + text;
}

std::string WhatIsMissing(const RendererChoice& choice, size_t devices) {
  switch (choice.kind) {
    case RendererChoice::Kind::kGpu: return "no GPU gives an OpenGL context";
    case RendererChoice::Kind::kSoftware: return "no EGL device gives an OpenGL context in software";
    case RendererChoice::Kind::kAuto: return "no EGL device gives an OpenGL context";
    case RendererChoice::Kind::kDevice:
      return size_t(choice.device) < devices ? "this EGL device gives no OpenGL context"
                                             : "there is no such EGL device";
  }
  GAITCAM_ASSERT(false);
  return {};
}

[[noreturn]] void Refuse(const AskedRenderer& asked, size_t devices) {
  const bool is_named = asked.choice.kind == RendererChoice::Kind::kDevice;
  throw MissingResource(asked.text + ": " + WhatIsMissing(asked.choice, devices) + "; " + WhatIsThere() +
                        (is_named ? "" : std::string("; ") + kInstall));
}

}  // namespace

std::string EglDeviceReport::ToText() const {
  std::string text = device.drm_node + (device.cuda ? ", CUDA device " + std::to_string(*device.cuda) : std::string());
  if (!failure.empty()) {
    const std::string what = !device.name.empty() ? device.name : device.is_software ? "software" : "GPU";
    return what + (text.empty() ? "" : ", " + text) + ", no OpenGL context: " + failure;
  }
  RendererInfo shown = opengl;
  shown.egl_device.reset();  // whoever shows the text has said it
  return shown.ToText() + (text.empty() ? "" : ", " + text);
}

std::vector<EglDeviceReport> ListEglDevices() {
  const CurrentAgain again;
  std::vector<EglDeviceReport> reports;
  for (const EglDevice& device : EnumerateDevices()) {
    EglDeviceReport& report = reports.emplace_back(EglDeviceReport{device, {}, ""});
    try {
      report.opengl = EglContext(device).info();
    } catch (const MissingResource& e) {
      report.failure = e.what();
    }
  }
  return reports;
}

EglContext::EglContext(const RendererChoice& choice) {
  const AskedRenderer asked = Asked(choice);
  const std::vector<EglDevice> devices = EnumerateDevices();
  bool made = false;
  switch (asked.choice.kind) {
    case RendererChoice::Kind::kAuto: made = TryDevices(devices, false) || TryDevices(devices, true); break;
    case RendererChoice::Kind::kGpu: made = TryDevices(devices, false); break;
    case RendererChoice::Kind::kSoftware: made = TryDevices(devices, true); break;
    case RendererChoice::Kind::kDevice:
      made = asked.choice.device < int(devices.size()) && Open(devices[size_t(asked.choice.device)]).empty();
  }
  if (!made && !TrySurfaceless(asked.choice)) Refuse(asked, devices.size());
}

EglContext::EglContext(const EglDevice& device) {
  const std::string failure = Open(device);
  if (!failure.empty()) throw MissingResource(failure);
}

EglContext::~EglContext() { Close(); }

void EglContext::MakeCurrent() const {
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
    throw MissingResource("the OpenGL context cannot be made current on this thread");
  }
}

/// The first device that says it is of this kind, and whose driver is: a GPU's may fall back to software.
bool EglContext::TryDevices(const std::vector<EglDevice>& devices, bool software) {
  for (const EglDevice& device : devices) {
    if (device.is_software != software || !Open(device).empty()) continue;
    if (info_.is_software == software) return true;
    Close();
  }
  return false;
}

/// For an EGL that lists no devices: Mesa's platform without one.
bool EglContext::TrySurfaceless(const RendererChoice& choice) {
  const auto get_display = Load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (choice.kind == RendererChoice::Kind::kDevice || get_display == nullptr ||
      !HasWord(extensions, "EGL_MESA_platform_surfaceless"))
    return false;
  if (!Open(get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr)).empty()) return false;
  if (choice.Permits(info_.is_software)) return true;
  Close();
  return false;
}

/// @returns why it gives no context; empty if it does.
std::string EglContext::Open(const EglDevice& device) {
  const auto get_display = Load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr) return "EGL has no eglGetPlatformDisplayEXT";
  const std::string failure = Open(get_display(EGL_PLATFORM_DEVICE_EXT, device.handle, nullptr));
  if (failure.empty()) info_.egl_device = device.index;
  return failure;
}

std::string EglContext::Open(void* display) {
  if (display == EGL_NO_DISPLAY) return Failed("eglGetPlatformDisplayEXT");
  if (!eglInitialize(display, nullptr, nullptr)) return Failed("eglInitialize");
  const EGLConfig config = ChooseConfig(display);
  if (config == nullptr) return "no configuration with desktop OpenGL, 24 bits of depth and 8 of stencil";
  if (!eglBindAPI(EGL_OPENGL_API)) return Failed("eglBindAPI");
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, nullptr);
  if (context == EGL_NO_CONTEXT) return Failed("eglCreateContext");
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    const std::string failure = Failed("eglMakeCurrent");
    eglDestroyContext(display, context);
    return failure;
  }
  display_ = display;
  context_ = context;
  Describe();
  return {};
}

void EglContext::Close() {
  if (context_ == nullptr) return;
  // The display is not terminated: EGL displays belong to the process, and another context may live on this one.
  if (eglGetCurrentContext() == context_) eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  display_ = context_ = nullptr;
  info_ = {};
}

void EglContext::Describe() {
  using GetString = const unsigned char* (*)(unsigned);
  const auto get_string = Load<GetString>("glGetString");
  const auto text = [&](unsigned name) {
    const unsigned char* value = get_string == nullptr ? nullptr : get_string(name);
    return value == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(value));
  };
  info_.vendor = text(kGlVendor);
  info_.name = text(kGlRenderer);
  info_.version = text(kGlVersion);
  info_.is_software = LooksLikeSoftware(info_.name);
}

std::string RendererKey(const RendererChoice& choice) {
  static std::mutex mutex;
  static std::map<std::string, std::string> keys;  // by the choice; a machine's devices do not change while it runs
  const std::string asked = Asked(choice).choice.ToText();
  const std::lock_guard lock(mutex);
  const auto known = keys.find(asked);
  return known != keys.end() ? known->second : keys.emplace(asked, EglContext(choice).info().Key()).first->second;
}

}  // namespace gaitcam
