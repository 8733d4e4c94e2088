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
#include "sim/camera/cover.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

constexpr int kSpareGeoms = 64;    // room for decoration that MuJoCo may add of its own
constexpr int kSharedLabel = 255;  // the last that a stencil of 8 bits holds

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
  PFNGLENABLEPROC Enable = LoadGlFunction<PFNGLENABLEPROC>("glEnable");
  PFNGLDISABLEPROC Disable = LoadGlFunction<PFNGLDISABLEPROC>("glDisable");
  PFNGLCLEARPROC Clear = LoadGlFunction<PFNGLCLEARPROC>("glClear");
  PFNGLSTENCILFUNCPROC StencilFunc = LoadGlFunction<PFNGLSTENCILFUNCPROC>("glStencilFunc");
  PFNGLSTENCILOPPROC StencilOp = LoadGlFunction<PFNGLSTENCILOPPROC>("glStencilOp");
  PFNGLRENDERBUFFERSTORAGEPROC RenderbufferStorage =
      LoadGlFunction<PFNGLRENDERBUFFERSTORAGEPROC>("glRenderbufferStorage");
  // Of OpenGL before 3.1, as all that MuJoCo draws with.
  using GenLists = GLuint(APIENTRYP)(GLsizei);
  GenLists MakeLists = LoadGlFunction<GenLists>("glGenLists");
  using NewList = void(APIENTRYP)(GLuint, GLenum);
  NewList BeginList = LoadGlFunction<NewList>("glNewList");
  using EndListCall = void(APIENTRYP)();
  EndListCall EndList = LoadGlFunction<EndListCall>("glEndList");
  using DeleteListsCall = void(APIENTRYP)(GLuint, GLsizei);
  DeleteListsCall DeleteLists = LoadGlFunction<DeleteListsCall>("glDeleteLists");
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

/// What a mesh geom reaches to and what lies within it for certain, in its own frame.
struct Renderer::GeomExtent {
  Eigen::Vector3d low{0, 0, 0}, high{0, 0, 0};  ///< Bounding box; empty of what is no mesh.
  std::array<Cover::Disc, 2> core;
  bool has_core = false;

  GeomExtent(const mjModel* model, int geom) {
    if (model->geom_type[geom] != mjGEOM_MESH) return;
    const int mesh = model->geom_dataid[geom];
    const Eigen::Map<const Eigen::Matrix3Xf> vertices(model->mesh_vert + ptrdiff_t{3} * model->mesh_vertadr[mesh], 3,
                                                      model->mesh_vertnum[mesh]);
    low = vertices.rowwise().minCoeff().cast<double>();
    high = vertices.rowwise().maxCoeff().cast<double>();
    if (model->nuser_geom < kCoreNumbers) return;
    const mjtNum *numbers = model->geom_user + ptrdiff_t{model->nuser_geom} * geom,
                 *p = model->geom_pos + ptrdiff_t{3} * geom, *q = model->geom_quat + ptrdiff_t{4} * geom;
    const Pose X_GB = Pose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]), {p[0], p[1], p[2]}).Inverse();
    for (Cover::Disc& disc : core) {
      const Eigen::Map<const Eigen::Matrix3d> read(numbers);  // by columns
      disc = {X_GB * Eigen::Vector3d(read.col(0)), X_GB.R() * read.col(1), X_GB.R() * read.col(2)};
      numbers += 9;
    }
    has_core = core[0].a.norm() > 0 && core[0].b.norm() > 0 && core[1].a.norm() > 0 && core[1].b.norm() > 0;
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
  mjv_makeScene(model, &scene_, 2 * model->ngeom + kSpareGeoms);  // before each geom there may be a label
  SetOnly(scene_.flags, mjNRNDFLAG, {mjRND_CULL_FACE});
  scene_.flags[mjRND_SHADOW] = options.shadows;
  for (int i = 0; i < model->ntex; ++i) {
    if (model->tex_type[i] == mjTEXTURE_SKYBOX) scene_.flags[mjRND_SKYBOX] = 1;
  }
  for (int i = 0; i < model->ngeom; ++i) {
    extents_.emplace_back(model, i);
    has_cores_ |= extents_.back().has_core;
  }
  mjr_defaultContext(&context_);
  MakeContext(640, 480);
  UploadPictures(model, context_, pictures);
  label_of_.resize(size_t(model->nbody), 0);
  reach_of_.resize(size_t(model->nbody), std::numeric_limits<float>::infinity());
  MakeLabels();
}

/// MuJoCo draws a mesh by calling a display list. One that only sets the value which is written into the stencil makes
/// all that is drawn after it say to which body it belongs.
void Renderer::MakeLabels() {
  constexpr GLenum kCompile = 0x1300;  // GL_COMPILE, of OpenGL 1
  label_lists_ = gl_->MakeLists(kSharedLabel + 1);
  for (int label = 0; label <= kSharedLabel; ++label) {
    gl_->BeginList(label_lists_ + unsigned(label), kCompile);
    gl_->StencilFunc(GL_ALWAYS, label, 0xff);
    gl_->EndList();
  }
}

Renderer::~Renderer() {
  gl_->DeleteLists(label_lists_, kSharedLabel + 1);
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

/// Takes what is hidden out of order_.
void Renderer::LeaveOutHidden(const Pose& X_WC, const CameraModel& camera) {
  const auto rotation = [](const mjvGeom& geom) -> Eigen::Matrix3d {
    return Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(geom.mat).cast<double>();
  };
  const auto position = [](const mjvGeom& geom) -> Eigen::Vector3d {
    return Eigen::Map<const Eigen::Vector3f>(geom.pos).cast<double>();
  };
  Cover cover(X_WC, camera, options_.near_m);
  for (const auto& [reach, index] : order_) {
    const mjvGeom& geom = geoms_[size_t(index)];
    if (geom.objtype != mjOBJ_GEOM || !extents_[size_t(geom.objid)].has_core) continue;
    // From within, or cut open by the near plane, a surface hides nothing.
    if (reach <= 2 * geom.modelrbound + 10 * options_.near_m) continue;
    const Eigen::Matrix3d R = rotation(geom);
    std::array<Cover::Disc, 2> core = extents_[size_t(geom.objid)].core;
    for (Cover::Disc& disc : core) disc = {R * disc.center + position(geom), R * disc.a, R * disc.b};
    cover.Add(core);
  }
  std::erase_if(order_, [&](const std::pair<float, int>& entry) {
    const mjvGeom& geom = geoms_[size_t(entry.second)];
    if (geom.objtype != mjOBJ_GEOM || geom.type != mjGEOM_MESH) return false;
    const GeomExtent& extent = extents_[size_t(geom.objid)];
    return cover.HidesBox(Pose(rotation(geom), position(geom)), extent.low, extent.high);
  });
}

/// Roughly front to back: occluded fragments are then rejected by the depth test before shading. What belongs to one
/// body stays together, to be labelled at once.
void Renderer::SortByBodies() {
  for (const auto& [reach, index] : order_) {
    float& nearest = reach_of_[size_t(geoms_[size_t(index)].segid)];
    nearest = std::min(nearest, reach);
  }
  for (auto& [reach, index] : order_) {
    const int body = geoms_[size_t(index)].segid;
    if (body > 0) reach = reach_of_[size_t(body)];
  }
  for (const auto& [reach, index] : order_) {
    reach_of_[size_t(geoms_[size_t(index)].segid)] = std::numeric_limits<float>::infinity();
  }
  std::sort(order_.begin(), order_.end());
}

/// Bodies beyond those that have labels of their own share the last one.
void Renderer::AddLabel(int body) {
  int& label = label_of_[size_t(body)];
  if (label == 0 && body != 0) {
    label = std::min(int(labels_.size()), kSharedLabel);
    if (label < kSharedLabel) labels_.push_back(body);
  }
  mjvGeom& geom = scene_.geoms[scene_.ngeom++];
  geom = mjvGeom();
  geom.type = mjGEOM_MESH;
  geom.objtype = mjOBJ_UNKNOWN;
  geom.category = mjCAT_DECOR;
  geom.texid = -1;
  geom.dataid = int(label_lists_ - unsigned(context_.baseMesh)) + label;
  std::fill(geom.rgba, geom.rgba + 4, 1.f);
  for (int k = 0; k < 9; k += 4) geom.mat[k] = 1;
}

void Renderer::SelectVisible(const Pose& X_WC, const CameraModel& camera, bool labelled) {
  const Frustum frustum(X_WC, camera, options_.near_m);
  order_.clear();
  for (size_t i = 0; i < geoms_.size(); ++i) {
    // Geometry outside the frustum may still cast a shadow into it.
    if (!options_.shadows && !frustum.MaySee(geoms_[i])) continue;
    order_.emplace_back(ReachFrom(geoms_[i], X_WC.translation), int(i));
  }
  if (has_cores_ && !options_.shadows) LeaveOutHidden(X_WC, camera);
  SortByBodies();
  shows_moving_ =
      std::any_of(order_.begin(), order_.end(), [&](const auto& at) { return geoms_[at.second].segid > 0; });
  std::fill(label_of_.begin(), label_of_.end(), 0);
  labels_.assign(1, 0);
  scene_.ngeom = 0;
  int body = 0;
  for (const auto& [reach, index] : order_) {
    const mjvGeom& geom = geoms_[size_t(index)];
    if (labelled && geom.segid != body) AddLabel(geom.segid);
    body = geom.segid;
    scene_.geoms[scene_.ngeom++] = geom;
  }
}

int Renderer::CountPeople(const Pose& X_WC, const CameraModel& camera) {
  const int first = FirstPersonBody(model_);
  if (first == model_->nbody) return 0;
  SelectVisible(X_WC, camera, false);
  return int(std::count_if(order_.begin(), order_.end(),
                           [&](const auto& at) { return geoms_[size_t(at.second)].segid >= first; }));
}

void Renderer::Draw(mjData& data, const Pose& X_WC, const CameraModel& camera, const Eigen::Vector2d& shift_px,
                    int finer, bool labelled) {
  GAITCAM_ASSERT(!geoms_.empty() || model_->ngeom == 0);
  Reserve(camera.width_px, camera.height_px);
  viewport_ = {0, 0, camera.width_px, camera.height_px};
  SetCamera(X_WC, camera, shift_px);
  if (follows_camera_) Update(data);
  mjv_makeLights(model_, &data, &scene_);
  SelectVisible(X_WC, camera, labelled);
  shot_ = {X_WC, camera, shift_px, labelled};
  depth_is_read_ = false;
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  constexpr GLenum kTextureFilterControl = 0x8500;  // OpenGL 1.4
  gl_->SetTextureEnvironment(kTextureFilterControl, GL_TEXTURE_LOD_BIAS, float(std::log2(finer)));
  if (labelled && shows_moving_) {
    gl_->Enable(GL_STENCIL_TEST);
    gl_->StencilFunc(GL_ALWAYS, 0, 0xff);
    gl_->StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    gl_->Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);  // MuJoCo clears no stencil
  }
  mjr_render(viewport_, &scene_, &context_);
  gl_->Disable(GL_STENCIL_TEST);
}

void Renderer::ReadColor(cv::Mat& bgrx_bottom_up) {
  bgrx_bottom_up.create(viewport_.height, viewport_.width, CV_8UC4);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, viewport_.width, viewport_.height, GL_BGRA, GL_UNSIGNED_BYTE, bgrx_bottom_up.data);
}

void Renderer::ReadDepth() {
  if (depth_is_read_) return;
  depth_stencil_.create(viewport_.height, viewport_.width, CV_32SC1);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, viewport_.width, viewport_.height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, depth_stencil_.data);
  depth_is_read_ = true;
}

cv::Mat Renderer::ReadNearness() {
  ReadDepth();
  // A perspective projection stores d = (1/n - 1/z) / (1/n - 1/f), here in the upper 24 bits.
  cv::Mat nearness(depth_stencil_.size(), CV_32FC1);
  const double inverse_near = 1 / options_.near_m, step = (inverse_near - 1 / options_.far_m) / kFarthest;
  for (int row = 0; row < nearness.rows; ++row) {
    Nearness(depth_stencil_.ptr<uint32_t>(nearness.rows - 1 - row), inverse_near, step, nearness.ptr<float>(row),
             nearness.cols);
  }
  return nearness;
}

cv::Mat Renderer::Bodies(mjData& data) {
  GAITCAM_ASSERT(shot_.labelled);
  if (!shows_moving_) return cv::Mat(viewport_.height, viewport_.width, CV_32SC1, cv::Scalar(0));
  // MuJoCo draws what is transparent last, when all labels were called.
  const bool transparent = std::any_of(scene_.geoms, scene_.geoms + scene_.ngeom,
                                       [](const mjvGeom& geom) { return geom.transparent && geom.segid > 0; });
  if (transparent) return DrawBodies(data, 0);
  ReadDepth();
  cv::Mat bodies(depth_stencil_.size(), CV_32SC1);
  bool shared = false;
  labels_.resize(kSharedLabel + 1, -1);
  for (int row = 0; row < bodies.rows; ++row) {
    const uint32_t* from = depth_stencil_.ptr<uint32_t>(bodies.rows - 1 - row);
    int* to = bodies.ptr<int>(row);
    for (int col = 0; col < bodies.cols; ++col) {
      to[col] = labels_[from[col] & 0xff];
      shared |= to[col] < 0;
    }
  }
  if (shared) DrawBodies(data, kSharedLabel).copyTo(bodies, bodies < 0);
  return bodies;
}

/// As a picture in which every body has a colour of its own. @param label of those that are drawn; 0: all.
cv::Mat Renderer::DrawBodies(mjData& data, int label) {
  const Shot shot = shot_;
  const std::vector<int> labels = label_of_;
  const std::vector<mjvGeom> geoms = geoms_;
  if (label > 0) std::erase_if(geoms_, [&](const mjvGeom& geom) { return labels[size_t(geom.segid)] != label; });
  const mjtByte skybox = scene_.flags[mjRND_SKYBOX];
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 1;
  scene_.flags[mjRND_SKYBOX] = 0;
  Draw(data, shot.X_WC, shot.camera, shot.shift_px);
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 0;
  scene_.flags[mjRND_SKYBOX] = skybox;
  geoms_ = geoms;
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
