/// Where a camera with depth is in a map that was learned before, frame by frame.
///
/// Source: Hua, section 6.1.2: in navigation the map's models are met again as loop closures, alpha = 1: what they say
/// is believed in full.
///
/// Ours: between frames the wheels carry the pose on. The views of the map nearest to it, facing the same way, are
/// compared with the frame; the one with the most inliers corrects the pose, each counting by its covariance. Nothing
/// is asked of the whole map unless there is no pose yet, or nothing has confirmed it for a while: so a robot that was
/// carried off finds itself again.
///
/// The same picture may hang in several places, and one frame then fits each of them. So the whole map may answer with
/// several places. All are carried on and compared with the frames that follow; one that explains less than half of
/// what another one does is given up. Until one place alone is left, where the robot is is not known for sure.
/// A single view may fit where it was not taken. So where the wheels have carried the robot stays the first of the
/// places when a view says otherwise, and counts as much as that view until others follow.

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/core/route_map.h"
#include "algorithms/core/se3.h"
#include "algorithms/odometry/body_track.h"
#include "algorithms/slam/hybrid_loops.h"
#include "algorithms/slam/metric_model.h"

namespace gaitcam {

struct MapLocalizerOptions {
  using DescribedTag = void;
  ModelLinkOptions links;
  PassSearchOptions search{{}, 8};
  int neighbours = 3;
  double near_m = 1.5;
  double near_deg = 45;
  int unconfirmed_frames = 12;
  int relocalise_inliers = 25;
  double map_sigma_m = 0.01;
  double map_sigma_deg = 0.2;
};

template <class Visitor>
void VisitFields(Visitor& visit, MapLocalizerOptions& o) {
  VisitFields(visit, o.links);
  visit("search", o.search, Nested(), "which views of the whole map are tried");
  visit("neighbours", o.neighbours, Between(1, 100), "nearest views of the map that a frame is compared with ...");
  visit("near_m", o.near_m, Between(0.01, 100), "... no farther away than this ...");
  visit("near_deg", o.near_deg, Between(1, 180), "... and turned by no more than this");
  visit("unconfirmed_frames", o.unconfirmed_frames, Between(1, 1000000),
        "after so many frames that no view has confirmed the whole map is searched");
  visit("relocalise_inliers", o.relocalise_inliers, Between(6, 100000),
        "points that must agree with a view that is found in the whole map; half of them with each other place");
  visit("map_sigma_m", o.map_sigma_m, Between(0, 10), "how wrong the map is about a view's position, per axis");
  visit("map_sigma_deg", o.map_sigma_deg, Between(0, 90), "likewise about how it is turned");
}

class MapLocalizer {
 public:
  struct Fix {
    Pose X_WC;                               ///< In the map's world.
    Matrix6d covariance = Matrix6d::Zero();  ///< Of X_WC, the map taken as right but for map_sigma.
    int view = -1;                           ///< Of the map, that confirmed it; -1: carried on by the wheels alone.
    bool found = false;  ///< Another place than before: of the whole map, or of those where it might have been.
    int inliers = 0, matches = 0;
    int places = 1;  ///< Where it may be as well as there, that place included.

    /// A view says so, and no other place does.
    bool Sure() const { return view >= 0 && places == 1; }
  };

  /// @param models how points are taken from the map's features. @throws BadInput in one line if the map is of another
  /// camera or feature, or shows nothing; BadOption.
  MapLocalizer(const Calibration& calibration, std::shared_ptr<const RouteMap> map, const std::string& feature,
               const MetricModelOptions& models, const MapLocalizerOptions& options, uint64_t seed);

  /// The next frame. @param body with all samples up to it.
  /// @returns nothing as long as the map was not met, or where the wheels do not reach.
  std::optional<Fix> Locate(int64_t stamp_ns, const MetricModel& seen, const BodyTrack& body);

  /// The other places where it may be, of the last frame.
  std::vector<Pose> Elsewhere() const;
  /// In how many frames in a row no view has confirmed any place.
  int unconfirmed_frames() const { return unconfirmed_; }

 private:
  /// Where it may be.
  struct Place {
    Fix fix;
    double explained = 0;    ///< Inliers per frame, those of the last bit of way and of turning counting most.
    bool was_alone = false;  ///< No other place was left once, and the wheels have carried it on from there.
  };

  Fix CarriedOn(const Fix& last, const RelativePose& moved) const;
  std::vector<int> ViewsNear(const Pose& X_WC) const;
  std::optional<Fix> LinkWith(int view, const MetricModel& seen);
  std::optional<Fix> Confirmed(const Fix& expected, const std::vector<int>& views, const MetricModel& seen);
  bool AnyConfirmed() const;
  std::vector<Place> FindInWholeMap(const MetricModel& seen);
  bool WeighAgainstTheWheels(std::vector<Place> found);
  bool Near(const Fix& a, const Fix& b) const;
  void CarryOnAndConfirm(int64_t stamp_ns, const MetricModel& seen, const BodyTrack& body);
  bool GiveUpTheWorse();

  std::shared_ptr<const RouteMap> map_;
  MapLocalizerOptions options_;
  Matrix6d map_covariance_;
  RandomStream random_;
  std::vector<MetricModel> models_;
  std::optional<PassSearch> search_;  ///< Learned when it is first needed: it takes seconds.
  std::vector<Place> places_;         ///< The first is taken for the true one as long as it is not given up.
  int64_t last_stamp_ns_ = 0;
  int unconfirmed_ = 0;
};

}  // namespace gaitcam
