#include "sim/camera/renderer.h"

#define EGL_NO_X11
#include <EGL/egl.h>
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <type_traits>

#include "algorithms/core/errors.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

constexpr int kSpareGeoms = 64;  // room for decoration that MuJoCo may add of its own

template <class Function>
Function LoadGlFunction(const char* name) {
  const auto function = reinterpret_cast<Function>(eglGetProcAddress(name));
  if (function == nullptr) throw MissingResource(std::string("the OpenGL driver lacks ") + name);
  return function;
}

void SetOnly(mjtByte* flags, int count, std::initializer_list<int> on) {
  std::fill(flags, flags + count, mjtByte{0});
  for (const int flag : on) flags[flag] = 1;
}

/// From a point to the farthest point that a geom's bounding sphere can have. Floor and walls, which reach far, come
/// after what stands before them; an infinite plane comes last.
float ReachFrom(const mjvGeom& geom, const Eigen::Vector3d& point) {
  if (geom.modelrbound <= 0) return std::numeric_limits<float>::max();
  const Eigen::Vector3f offset = point.cast<float>() - Eigen::Vector3f(geom.pos[0], geom.pos[1], geom.pos[2]);
  return offset.norm() + geom.modelrbound;
}

constexpr uint32_t kFarthest = 0xffffff;  // of a depth buffer of 24 bits: nothing is there

/// From depth and stencil, side by side in a word, to `inverse_near` - depth * `step`. Two numbers at once.
void Nearness(const uint32_t* from, double inverse_near, double step, float* to, int count) {
  using Int2 = int32_t __attribute__((vector_size(8)));
  using Double2 = double __attribute__((vector_size(16)));
  const Double2 nearest = {inverse_near, inverse_near}, steps = {step, step};
  int i = 0;
  for (; i + 2 <= count; i += 2) {
    const Int2 depth = {int32_t(from[i] >> 8), int32_t(from[i + 1] >> 8)};
    const Double2 near = nearest - steps * __builtin_convertvector(depth, Double2);
    to[i] = depth[0] == int32_t(kFarthest) ? 0.f : float(near[0]);
    to[i + 1] = depth[1] == int32_t(kFarthest) ? 0.f : float(near[1]);
  }
  for (; i < count; ++i) {
    to[i] = from[i] >> 8 == kFarthest ? 0.f : float(inverse_near - step * double(from[i] >> 8));
  }
}

}  // namespace

/// OpenGL calls that MuJoCo does not wrap, or wraps with extra copies.
struct Renderer::Gl {
  PFNGLREADPIXELSPROC ReadPixels = LoadGlFunction<PFNGLREADPIXELSPROC>("glReadPixels");
  PFNGLPIXELSTOREIPROC PixelStorei = LoadGlFunction<PFNGLPIXELSTOREIPROC>("glPixelStorei");
  PFNGLBINDRENDERBUFFERPROC BindRenderbuffer = LoadGlFunction<PFNGLBINDRENDERBUFFERPROC>("glBindRenderbuffer");
  PFNGLGETRENDERBUFFERPARAMETERIVPROC GetRenderbufferParameteriv =
      LoadGlFunction<PFNGLGETRENDERBUFFERPARAMETERIVPROC>("glGetRenderbufferParameteriv");
  PFNGLRENDERBUFFERSTORAGEPROC RenderbufferStorage =
      LoadGlFunction<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage");
  // Of OpenGL before 3.1, as all that MuJoCo draws with.
  using TexEnvf = void(APIENTRYP)(GLenum, GLenum, GLfloat);
  TexEnvf SetTextureEnvironment = LoadGlFunction<TexEnvf>("glTexEnvf");
};

/// The four side planes of a picture's pyramid and the near plane, in world coordinates: n.p + d >= 0 is inside.
struct Renderer::Frustum {
  std::array<Eigen::Vector3d, 5> normal;
  std::array<double, 5> offset;

  Frustum(const Pose& X_WC, const CameraModel& camera, double near_m) {
    // Half a pixel beyond the centres, and one more as a margin for sub-pixel offsets.
    const double left = (-1.5 - camera.cx) / camera.fx, right = (camera.width_px + 0.5 - camera.cx) / camera.fx;
    const double top = (-1.5 - camera.cy) / camera.fy, bottom = (camera.height_px + 0.5 - camera.cy) / camera.fy;
    const std::array<Eigen::Vector3d, 5> inward = {Eigen::Vector3d(1, 0, -left), Eigen::Vector3d(-1, 0, right),
                                                   Eigen::Vector3d(0, 1, -top), Eigen::Vector3d(0, -1, bottom),
                                                   Eigen::Vector3d(0, 0, 1)};
    const Eigen::Matrix3d R = X_WC.R();
    for (size_t i = 0; i < inward.size(); ++i) {
      normal[i] = R * inward[i].normalized();
      offset[i] = -normal[i].dot(X_WC.translation);
    }
    offset[4] -= near_m;
  }

  bool MaySee(const mjvGeom& geom) const {
    if (geom.type == mjGEOM_PLANE || geom.modelrbound <= 0) return true;
    const Eigen::Vector3d centre(geom.pos[0], geom.pos[1], geom.pos[2]);
    for (size_t i = 0; i < normal.size(); ++i) {
      double reach = geom.modelrbound;
      if (geom.type == mjGEOM_BOX) {
        reach = 0;
        for (int k = 0; k < 3; ++k) {  // columns of the rotation are the box's axes
          const Eigen::Vector3d axis(geom.mat[k], geom.mat[3 + k], geom.mat[6 + k]);
          reach += geom.size[k] * std::abs(normal[i].dot(axis));
        }
      }
      if (normal[i].dot(centre) + offset[i] < -reach - 1e-6) return false;
    }
    return true;
  }
};

Renderer::Renderer(const mjModel* model, const RendererOptions& options, const std::vector<TexturePicture>& pictures)
    : model_(model), options_(options) {
  GAITCAM_ASSERT(model != nullptr);
  if (eglGetCurrentContext() == EGL_NO_CONTEXT) throw MissingResource("a renderer needs an EglContext on its thread");
  constexpr int kMaxTextures = int(std::extent_v<decltype(mjrContext::texture)>);
  if (model->ntex > kMaxTextures) {
    throw BadInput("the model has " + std::to_string(model->ntex) + " textures; MuJoCo's renderer takes at most " +
                   std::to_string(kMaxTextures));
  }
  gl_ = std::make_unique<Gl>();
  mjv_defaultOption(&visual_);
  SetOnly(visual_.flags, mjNVISFLAG, {mjVIS_TEXTURE, mjVIS_STATIC, mjVIS_SKIN});
  mjv_defaultScene(&scene_);
  mjv_makeScene(model, &scene_, model->ngeom + kSpareGeoms);
  SetOnly(scene_.flags, mjNRNDFLAG, {mjRND_CULL_FACE});
  scene_.flags[mjRND_SHADOW] = options.shadows;
  for (int i = 0; i < model->ntex; ++i) {
    if (model->tex_type[i] == mjTEXTURE_SKYBOX) scene_.flags[mjRND_SKYBOX] = 1;
  }
  mjr_defaultContext(&context_);
  MakeContext(640, 480);
  UploadPictures(model, context_, pictures);
}

Renderer::~Renderer() {
  mjr_freeContext(&context_);
  mjv_freeScene(&scene_);
}

void Renderer::MakeContext(int width_px, int height_px) {
  if (context_.offFBO != 0) return ResizeBuffers(width_px, height_px);
  mjModel sized = *model_;  // MuJoCo reads the buffer's size and samples from the model; only this shallow copy changes
  sized.vis.global.offwidth = width_px;
  sized.vis.global.offheight = height_px;
  sized.vis.quality.offsamples = 0;
  if (!options_.shadows) sized.vis.quality.shadowsize = 0;
  mjr_makeContext(&sized, &context_, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  if (context_.currentBuffer != mjFB_OFFSCREEN) throw MissingResource("the OpenGL driver gives no off-screen buffer");
}

/// MuJoCo would make the whole context anew, with all textures and meshes.
void Renderer::ResizeBuffers(int width_px, int height_px) {
  GAITCAM_ASSERT(context_.offSamples == 0);
  for (const unsigned buffer : {context_.offColor, context_.offDepthStencil}) {
    GLint format = 0;
    gl_->BindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl_->GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_INTERNAL_FORMAT, &format);
    gl_->RenderbufferStorage(GL_RENDERBUFFER, GLenum(format), width_px, height_px);
  }
  context_.offWidth = width_px;
  context_.offHeight = height_px;
  if (mjr_getError() != 0) throw MissingResource("the OpenGL driver gives no off-screen buffer of that size");
}

void Renderer::Reserve(int width_px, int height_px) {
  if (width_px <= context_.offWidth && height_px <= context_.offHeight) return;
  MakeContext(std::max(width_px, context_.offWidth), std::max(height_px, context_.offHeight));
}

void Renderer::Update(mjData& data) {
  mjvCamera user;
  mjv_defaultCamera(&user);
  user.type = mjCAMERA_USER;
  mjv_updateScene(model_, &data, &visual_, nullptr, &user, mjCAT_STATIC | mjCAT_DYNAMIC, &scene_);
  geoms_.assign(scene_.geoms, scene_.geoms + scene_.ngeom);
  moving_.clear();
  follows_camera_ = false;
  for (size_t i = 0; i < geoms_.size(); ++i) {
    mjvGeom& geom = geoms_[i];
    geom.segid = 0;
    if (geom.objtype != mjOBJ_GEOM) continue;
    const int body = model_->geom_bodyid[geom.objid];
    if (model_->body_weldid[body] != 0 || model_->body_mocapid[body] >= 0) {
      geom.segid = body;
      moving_.push_back(int(i));
    }
    const mjtNum* size = model_->geom_size + ptrdiff_t{3} * geom.objid;
    if (geom.type == mjGEOM_PLANE && (size[0] <= 0 || size[1] <= 0)) follows_camera_ = true;
  }
}

void Renderer::Move(const mjData& data) {
  for (const int index : moving_) {
    mjvGeom& geom = geoms_[index];
    for (int k = 0; k < 3; ++k) geom.pos[k] = float(data.geom_xpos[3 * geom.objid + k]);
    for (int k = 0; k < 9; ++k) geom.mat[k] = float(data.geom_xmat[9 * geom.objid + k]);
  }
}

void Renderer::SetCamera(const Pose& X_WC, const CameraModel& camera, const Eigen::Vector2d& shift_px) {
  GAITCAM_ASSERT(camera.fx == camera.fy && !camera.IsDistorted());
  const Eigen::Matrix3d R = X_WC.R();
  const double near = options_.near_m, f = camera.fy;
  const double cx = camera.cx - shift_px.x(), cy = camera.cy - shift_px.y();
  mjvGLCamera& gl = scene_.camera[0];
  for (int k = 0; k < 3; ++k) {
    gl.pos[k] = float(X_WC.translation[k]);
    gl.forward[k] = float(R(k, 2));
    gl.up[k] = float(-R(k, 1));
  }
  // The picture reaches half a pixel beyond the centres of its outer pixels. MuJoCo derives the width from the height,
  // the picture's proportions and square pixels.
  gl.frustum_center = float(near * (0.5 * (camera.width_px - 1) - cx) / f);
  gl.frustum_top = float(near * (cy + 0.5) / f);
  gl.frustum_bottom = float(near * (cy + 0.5 - camera.height_px) / f);
  gl.frustum_near = float(near);
  gl.frustum_far = float(options_.far_m);
  scene_.camera[1] = gl;
}

void Renderer::SelectVisible(const Frustum& frustum, const Eigen::Vector3d& eye) {
  order_.clear();
  for (size_t i = 0; i < geoms_.size(); ++i) {
    // Geometry outside the frustum may still cast a shadow into it.
    if (!options_.shadows && !frustum.MaySee(geoms_[i])) continue;
    order_.emplace_back(ReachFrom(geoms_[i], eye), int(i));
  }
  // Roughly front to back: occluded fragments are then rejected by the depth test before shading.
  std::sort(order_.begin(), order_.end());
  scene_.ngeom = 0;
  for (const auto& [reach, index] : order_) scene_.geoms[scene_.ngeom++] = geoms_[index];
}

void Renderer::Draw(mjData& data, const Pose& X_WC, const CameraModel& camera, const Eigen::Vector2d& shift_px,
                    int finer) {
  GAITCAM_ASSERT(!geoms_.empty() || model_->ngeom == 0);
  Reserve(camera.width_px, camera.height_px);
  viewport_ = {0, 0, camera.width_px, camera.height_px};
  SetCamera(X_WC, camera, shift_px);
  if (follows_camera_) Update(data);
  mjv_makeLights(model_, &data, &scene_);
  SelectVisible(Frustum(X_WC, camera, options_.near_m), X_WC.translation);
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  constexpr GLenum kTextureFilterControl = 0x8500;  // OpenGL 1.4
  gl_->SetTextureEnvironment(kTextureFilterControl, GL_TEXTURE_LOD_BIAS, float(std::log2(finer)));
  mjr_render(viewport_, &scene_, &context_);
}

void Renderer::ReadColor(cv::Mat& bgrx_bottom_up) {
  bgrx_bottom_up.create(viewport_.height, viewport_.width, CV_8UC4);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, viewport_.width, viewport_.height, GL_BGRA, GL_UNSIGNED_BYTE, bgrx_bottom_up.data);
}

cv::Mat Renderer::ReadNearness() {
  depth_stencil_.create(viewport_.height, viewport_.width, CV_32SC1);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, viewport_.width, viewport_.height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, depth_stencil_.data);
  // A perspective projection stores d = (1/n - 1/z) / (1/n - 1/f), here in the upper 24 bits.
  cv::Mat nearness(depth_stencil_.size(), CV_32FC1);
  const double inverse_near = 1 / options_.near_m, step = (inverse_near - 1 / options_.far_m) / kFarthest;
  for (int row = 0; row < nearness.rows; ++row) {
    Nearness(depth_stencil_.ptr<uint32_t>(nearness.rows - 1 - row), inverse_near, step, nearness.ptr<float>(row),
             nearness.cols);
  }
  return nearness;
}

cv::Mat Renderer::Bodies(mjData& data, const Pose& X_WC, const CameraModel& camera, const Eigen::Vector2d& shift_px) {
  const mjtByte skybox = scene_.flags[mjRND_SKYBOX];
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 1;
  scene_.flags[mjRND_SKYBOX] = 0;
  Draw(data, X_WC, camera, shift_px);
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 0;
  scene_.flags[mjRND_SKYBOX] = skybox;
  cv::Mat bgrx, bodies(viewport_.height, viewport_.width, CV_32SC1);
  ReadColor(bgrx);
  for (int row = 0; row < bodies.rows; ++row) {
    const uint8_t* from = bgrx.ptr<uint8_t>(bodies.rows - 1 - row);
    int* to = bodies.ptr<int>(row);
    for (int col = 0; col < bodies.cols; ++col, from += 4) {
      to[col] = std::max(0, (from[2] | from[1] << 8 | from[0] << 16) - 1);  // MuJoCo paints segid + 1, red lowest
    }
  }
  return bodies;
}

cv::Mat Renderer::Picture(mjData& data, const Pose& X_WC, const CameraModel& camera, int finer) {
  GAITCAM_ASSERT(finer >= 1);
  Update(data);
  Draw(data, X_WC, Finer(camera, finer, 0), Eigen::Vector2d::Zero(), finer);
  cv::Mat bgrx;
  ReadColor(bgrx);
  return EncodeSrgb(MeanLight(bgrx, finer));
}

bool Renderer::SeesMovingBodies(const Pose& X_WC, const CameraModel& camera) const {
  const Frustum frustum(X_WC, camera, options_.near_m);
  return std::any_of(moving_.begin(), moving_.end(), [&](int i) { return frustum.MaySee(geoms_[i]); });
}

CameraModel Finer(const CameraModel& camera, int finer, int margin_px) {
  CameraModel fine = camera;
  fine.width_px = finer * (camera.width_px + 2 * margin_px);
  fine.height_px = finer * (camera.height_px + 2 * margin_px);
  fine.fx = fine.fy = finer * camera.fx;
  // The first pixel's left edge lies half a pixel before its centre, in either raster.
  fine.cx = finer * (camera.cx + margin_px + 0.5) - 0.5;
  fine.cy = finer * (camera.cy + margin_px + 0.5) - 0.5;
  return fine;
}

Pose LookAt(const Eigen::Vector3d& point, double distance_m, double azimuth_rad, double elevation_rad) {
  const Eigen::Vector3d forward(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << right, forward.cross(right), forward;
  return {R, point - distance_m * forward};
}

void UploadPictures(const mjModel* model, const mjrContext& context, const std::vector<TexturePicture>& pictures) {
  for (const TexturePicture& picture : pictures) {
    const int id = mj_name2id(model, mjOBJ_TEXTURE, picture.texture.c_str());
    GAITCAM_ASSERT(id >= 0 && id < model->ntex);
    cv::Mat rgb;
    cv::cvtColor(picture.make(), rgb, cv::COLOR_BGR2RGB);
    GAITCAM_ASSERT(rgb.type() == CV_8UC3 && rgb.isContinuous());
    // MuJoCo takes pixels from a model; in this shallow copy they are the picture's, at the beginning of the array.
    mjModel pictured = *model;
    std::vector<int> address(size_t(model->ntex), 0), width(address.size(), rgb.cols), height(address.size(), rgb.rows);
    pictured.tex_rgb = rgb.data;
    pictured.tex_adr = address.data();
    pictured.tex_width = width.data();
    pictured.tex_height = height.data();
    mjr_uploadTexture(&pictured, &context, id);
  }
}

Pose CameraPose(const mjData& data, int camera_id) {
  const Eigen::Matrix3d R_gl =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.cam_xmat + ptrdiff_t{9} * camera_id);
  const Eigen::Vector3d flip(1, -1, -1);  // OpenGL's cameras look along -z with y up
  return {Eigen::Matrix3d(R_gl * flip.asDiagonal()),
          Eigen::Map<const Eigen::Vector3d>(data.cam_xpos + ptrdiff_t{3} * camera_id)};
}

int FindCamera(const mjModel* model, const std::string& name) {
  const int id = mj_name2id(model, mjOBJ_CAMERA, name.c_str());
  if (id < 0) throw BadInput("the model has no camera \"" + name + "\"");
  return id;
}

}  // namespace gaitcam
