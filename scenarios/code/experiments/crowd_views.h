/// Pairs of views between which people have walked on, things were put elsewhere and the camera has moved; rendered,
/// with the truth of every pixel.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/pose.h"

namespace gaitcam {

/// What stands where, and how it is filmed. Distances are drawn uniformly, angles and rates normally.
struct CrowdOptions {
  std::string scene = "hall";
  double people_per_100_m2 = 15;                 ///< Of the floor's extent.
  double standing = 0;                           ///< Share of them who stand still over both views.
  int things = 3;                                ///< Boxes with pictures; each is put elsewhere between the views.
  double interval_s = 2;                         ///< Between the views: half a frame per second (Hua, section 5.2).
  double least_step_m = 0.2, most_step_m = 0.6;  ///< Of the camera, ahead within 45 degrees.
  double turn_deg = 5;                           ///< Of the camera between the views, about the vertical.
  double tilt_deg = 2;                           ///< About either other axis.
  double exposure_ms = 20;
  double rate_deg_s = 0;                ///< How fast the camera turns about each of its axes while it exposes.
  int width_px = 480, height_px = 320;  ///< Hua, section 5.2.
  double hfov_deg = 60;
};

/// One rendered view with its truth.
struct CrowdView {
  cv::Mat grey;       ///< CV_8UC1.
  cv::Mat depth;      ///< CV_32FC1, m along the optical axis at mid-exposure; 0 where nothing is.
  cv::Mat on_people;  ///< CV_8UC1: 255 where a person is seen.
  Pose X_WC;
};

/// A box that stands elsewhere in the second view.
struct MovedThing {
  Eigen::Vector3d size;  ///< Full edges, m.
  Pose X_WB_a, X_WB_b;
};

struct CrowdPair {
  CameraModel camera;
  CrowdView a, b;
  std::vector<MovedThing> things;
};

/// What a match between the two views is in truth.
enum class MatchTruth {
  kRight,  ///< A point of what stands still, found again.
  kWrong,  ///< Both ends lie on what stands still, on different points of it.
  kMover,  ///< One end lies on a person, or on a thing that was moved.
};

/// Judges matches by depth, labels and poses. A match is right where a point that is seen within a pixel of its one end
/// is within `right_px` of the other: key points lie on edges, and depth jumps there.
class PairTruth {
 public:
  explicit PairTruth(const CrowdPair& pair, double right_px = 3) : pair_(pair), right_px_(right_px) {}
  MatchTruth Of(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;
  /// Distance between a match's end and where its other end's point is truly seen, px; infinite if it is not.
  double Error(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;

 private:
  bool OnMover(const CrowdView& view, const Eigen::Vector2d& pixel, bool second) const;

  const CrowdPair& pair_;
  const double right_px_;
};

/// A scene with a crowd in it, in which pairs are filmed. Belongs to one thread.
class CrowdStage {
 public:
  /// @throws BadInput as ReadScene does, or if the scene has no room; MissingResource without a renderer.
  CrowdStage(const CrowdOptions& options, uint64_t seed);
  ~CrowdStage();
  CrowdStage(const CrowdStage&) = delete;
  CrowdStage& operator=(const CrowdStage&) = delete;

  /// The pair of that number: the same whatever was filmed before. Places from which half of the picture shows what is
  /// nearer than 1.5 m are drawn anew.
  CrowdPair Film(int number);
  /// Views of a walk from a place drawn by its number, `interval_s` apart; things stand still. Steps and turns are
  /// those between the views of a pair, but it turns aside where it finds no room.
  std::vector<CrowdView> FilmWalk(int number, int views);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gaitcam
