/// Images of a MuJoCo model by a pinhole camera: MuJoCo's OpenGL renderer with exact intrinsics.
///
/// A sub-frame of an exposure costs one call of Move and one of Draw. Geometry that does not move is copied once, and
/// geometry outside the view frustum, or hidden by geometry with a solid core (kCoreNumbers), is culled before it
/// reaches OpenGL; MuJoCo's own loop does neither.
///
/// Anti-aliasing is the caller's: it averages finer pictures, or such as are shifted by parts of a pixel, in linear
/// light. OpenGL's own multisampling averages display values, which makes thin bright things too dark, and costs as
/// much in software.

#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"
#include "sim/world/world.h"

namespace gaitcam {

struct RendererOptions {
  bool shadows = false;  ///< Shadows of the lights that cast them; several times the cost in software.
  double near_m = 0.01;  ///< Nothing nearer than this along the optical axis is seen.
  double far_m = 200.0;  ///< Nor farther.
};

/// Needs the thread's EglContext (sim/egl_context.h) and must not outlive it, nor the model.
class Renderer {
 public:
  /// @throws MissingResource if OpenGL lacks frame buffers; BadInput if the model has more textures than MuJoCo can
  /// draw.
  /// @param pictures of the model's textures: made, handed to OpenGL one by one, and forgotten.
  explicit Renderer(const mjModel* model, const RendererOptions& options = {},
                    const std::vector<TexturePicture>& pictures = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  const mjModel* model() const { return model_; }
  const RendererOptions& options() const { return options_; }

  /// Makes room for pictures of up to this size at once.
  void Reserve(int width_px, int height_px);
  /// Copies all visible geometry, in the configuration of `data` (its kinematics must be up to date).
  void Update(mjData& data);
  /// Copies the poses of moving geometry. @pre Update was called before.
  void Move(const mjData& data);

  /// Draws the picture of a camera with square pixels and no distortion.
  /// @param shift_px offset of the sampling point from the pixel centre, for anti-aliasing.
  /// @param finer how many pixels of this picture make one of the image, in a row: textures are then filtered for the
  /// image's pixels.
  /// @param labelled if bodies are to be told apart: see Bodies().
  /// @pre camera.fx == camera.fy, no distortion, Update was called before.
  void Draw(mjData& data, const Pose& X_WC, const CameraModel& camera,
            const Eigen::Vector2d& shift_px = Eigen::Vector2d::Zero(), int finer = 1, bool labelled = false);
  /// The picture just drawn: CV_8UC4, BGR and an unused byte, display (sRGB) values, BOTTOM row first as OpenGL has it.
  void ReadColor(cv::Mat& bgrx_bottom_up);

  /// Reciprocal depth of the picture just drawn, along the optical axis: CV_32FC1, 1/m, row 0 on top; 0 where nothing
  /// is.
  cv::Mat ReadNearness();
  /// Of how many pieces of people a picture would consist. @pre Update was called before.
  int CountPeople(const Pose& X_WC, const CameraModel& camera);
  /// Of how many pieces the picture just drawn consists.
  int drawn() const { return scene_.ngeom; }
  /// Whether any geom of a moving body can be in the picture just drawn (by its bounding box, so perhaps hidden).
  bool ShowsMovingBodies() const { return shows_moving_; }
  /// Which body each pixel of the picture just drawn sees, CV_32SC1, row 0 on top; 0 for the world and for nothing.
  /// Costs next to nothing after ReadNearness(). Where more than 254 bodies are in view, those behind the nearest 254
  /// are drawn anew, in place of the picture.
  /// @pre it was drawn labelled.
  cv::Mat Bodies(mjData& data);

  /// One instant as a picture, CV_8UC3 (BGR), row 0 on top; a pixel is the mean of `finer` x `finer` samples. Calls
  /// Update.
  cv::Mat Picture(mjData& data, const Pose& X_WC, const CameraModel& camera, int finer = 1);

 private:
  struct Gl;
  struct Frustum;
  struct GeomExtent;

  /// The first time; then makes another size of buffers for the one that is there.
  void MakeContext(int width_px, int height_px);
  void MakeLabels();
  void ResizeBuffers(int width_px, int height_px);
  void SetCamera(const Pose& X_WC, const CameraModel& camera, const Eigen::Vector2d& shift_px);
  void SelectVisible(const Pose& X_WC, const CameraModel& camera, bool labelled);
  void AddLabel(int body);
  void SortByBodies();
  cv::Mat DrawBodies(mjData& data, int label);
  void ReadDepth();
  void LeaveOutHidden(const Pose& X_WC, const CameraModel& camera);

  const mjModel* model_;
  RendererOptions options_;
  std::unique_ptr<const Gl> gl_;
  mjvOption visual_;
  mjvScene scene_;
  mjrContext context_;
  std::vector<GeomExtent> extents_;  ///< By geom of the model.
  bool has_cores_ = false;
  std::vector<mjvGeom> geoms_;  ///< All that is visible from somewhere; scene_.geoms holds what is in the picture.
  std::vector<std::pair<float, int>> order_;  ///< What is in the picture: how far it reaches, and its index.
  std::vector<int> moving_;                   ///< Indices into geoms_.
  bool follows_camera_ = false;               ///< An infinite plane is centred anew under each camera.
  unsigned label_lists_ = 0;                  ///< The first of OpenGL's display lists that set a label.
  std::vector<int> labels_;      ///< Which body each label means in the picture last drawn; the first, the world.
  std::vector<int> label_of_;    ///< By body; 0: none yet.
  std::vector<float> reach_of_;  ///< By body: scratch of SortByBodies.
  bool shows_moving_ = false;
  struct Shot {
    Pose X_WC;
    CameraModel camera;
    Eigen::Vector2d shift_px{0, 0};
    bool labelled = false;
  } shot_;  ///< Last drawn.
  mjrRect viewport_{0, 0, 0, 0};
  bool depth_is_read_ = false;  ///< Of the picture last drawn.
  cv::Mat depth_stencil_;       ///< Last read; the stencil is the label.
};

/// Puts pictures in the place of the pixels that the model's textures have. @pre the context is current.
void UploadPictures(const mjModel* model, const mjrContext& context, const std::vector<TexturePicture>& pictures);

/// The camera whose picture shows what `camera`'s image does and `margin_px` pixels more on each side, with `finer`
/// pixels in the place of one. @pre no distortion.
CameraModel Finer(const CameraModel& camera, int finer, int margin_px);

/// Pose of a camera of the model: optical frame, x right, y down, z forward.
Pose CameraPose(const mjData& data, int camera_id);

/// Pose of a virtual camera that looks at a point.
/// @param azimuth_rad the direction in which the viewer looks, about the world's z; @param elevation_rad negative looks
/// down.
Pose LookAt(const Eigen::Vector3d& point, double distance_m, double azimuth_rad, double elevation_rad);

/// @returns the camera's number. @throws BadInput if the model has no camera of that name.
int FindCamera(const mjModel* model, const std::string& name);

}  // namespace gaitcam
