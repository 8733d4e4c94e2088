/// Metric models: a view's features with their coordinates in space, and the motion between two of them.
///
/// Source: Hua, section 6.1.1.1: "we obtain a set of robust vision features and these features' corresponding 3D
/// coordinates, called a metric model"; two models are matched, and RANSAC over rigid motions gives their relative
/// pose.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/random.h"
#include "algorithms/core/route_map.h"
#include "algorithms/core/se3.h"
#include "algorithms/features/features.h"
#include "algorithms/features/match_filter.h"
#include "algorithms/geometry/rigid_motion.h"

namespace gaitcam {

struct MetricModelOptions {
  using DescribedTag = void;
  double max_depth_m = 20;
  double sigma_px = 0.4;
  double sigma_per_size = 0.01;
};

template <class Visitor>
void VisitFields(Visitor& visit, MetricModelOptions& o) {
  visit("max_depth_m", o.max_depth_m, Positive(), "features farther away than this are left out");
  visit("sigma_px", o.sigma_px, Between(0.001, 100.0), "standard deviation of the smallest key point's position, px");
  visit("sigma_per_size", o.sigma_per_size, Between(0.0, 10.0), "what each px of a key point's diameter adds");
}

struct MetricModel {
  Features features;
  std::vector<Eigen::Vector3d> p_C;         ///< Of each feature, in the camera's frame.
  std::vector<Eigen::Matrix3d> covariance;  ///< Of p_C, m^2.
};

/// Of those features that have a depth, in their order. A depth that is measured between two surfaces is none
/// (DepthAt). Beside the depth camera's own error, a surface that is seen aslant has at a feature that lies elsewhere
/// another depth: at 45 deg by as much as the feature is off sideways.
/// @param depth CV_32FC1, m, of the camera's size.
MetricModel MakeMetricModel(const Features& features, const cv::Mat& depth, const Calibration& calibration,
                            const MetricModelOptions& options);

/// The same of features whose depths are known: those beyond max_depth_m are left out. @param depth_m of each feature.
MetricModel MakeMetricModel(const Features& features, const std::vector<double>& depth_m,
                            const Calibration& calibration, const MetricModelOptions& options);

/// What a map keeps of a model, and the model again.
MappedView ToMappedView(const MetricModel& model);
MetricModel FromMappedView(const MappedView& view, const Calibration& calibration, const MetricModelOptions& options);

/// Of all views of a map. @throws BadInput in one line if the map is of another camera or feature, or shows nothing.
std::vector<MetricModel> ModelsOf(const RouteMap& map, const Calibration& calibration, const std::string& feature,
                                  const MetricModelOptions& options);

struct ModelLinkOptions {
  using DescribedTag = void;
  double ratio = 0.8;
  MatchFilterOptions filter;
  RigidMotionMethod method = RigidMotionMethod::kMaximumLikelihood;
  double inlier_sigmas = 3;
  int min_inliers = 12;
  double min_inlier_pct = 25;
  double points_per_error = 4;
};

template <class Visitor>
void VisitFields(Visitor& visit, ModelLinkOptions& o) {
  visit("ratio", o.ratio, Between(0.1, 1.0), "ratio test between two models: nearest over second nearest distance");
  VisitFields(visit, o.filter);
  visit("method", o.method, EnumWords<RigidMotionMethod>(), "how a rigid motion is fitted to matched points");
  visit("inlier_sigmas", o.inlier_sigmas, Between(0.1, 100.0), "largest error of an inlier, in standard deviations");
  visit("min_inliers", o.min_inliers, Between(6, 100000), "two models with fewer inliers are not linked ...");
  visit("min_inlier_pct", o.min_inlier_pct, Between(0, 100), "... nor those with a smaller part of their matches");
  visit("points_per_error", o.points_per_error, Between(1.0, 1e4),
        "points whose errors hang together so that they count as one");
}

/// X_FT, from one model to another.
struct ModelLink {
  Pose X_FT;
  Matrix6d covariance;
  int inliers = 0, matches = 0;
};

/// By descriptors, the filter of matches, and RANSAC.
std::optional<ModelLink> LinkModels(const MetricModel& from, const MetricModel& to, const ModelLinkOptions& options,
                                    RandomStream& random);

}  // namespace gaitcam
