#include "algorithms/slam/metric_model.h"

#include <limits>

#include "algorithms/features/matching.h"
#include "algorithms/geometry/depth_image.h"

namespace gaitcam {
namespace {

/// Of z (x, y, 1), whose ray is known to `sigma` in x and y.
Eigen::Matrix3d PointCovariance(const Eigen::Vector3d& ray, double z, double sigma, double depth_sigma) {
  const double sideways2 = z * sigma * z * sigma;
  Eigen::Matrix3d covariance = Eigen::Vector3d(sideways2, sideways2, 0).asDiagonal();
  return covariance + (depth_sigma * depth_sigma + sideways2) * ray * ray.transpose();
}

std::vector<PointMatch> PointsOf(const std::vector<Match>& matches, const MetricModel& from, const MetricModel& to) {
  std::vector<PointMatch> points;
  for (const Match& match : matches) {
    const size_t a = size_t(match.a), b = size_t(match.b);
    points.push_back({from.p_C[a], to.p_C[b], from.covariance[a], to.covariance[b]});
  }
  return points;
}

}  // namespace

MetricModel MakeMetricModel(const Features& features, const cv::Mat& depth, const Calibration& calibration,
                            const MetricModelOptions& options) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<double> depth_m;
  for (const cv::KeyPoint& keypoint : features.keypoints)
    depth_m.push_back(DepthAt(depth, {keypoint.pt.x, keypoint.pt.y}).value_or(kNone));
  return MakeMetricModel(features, depth_m, calibration, options);
}

MetricModel MakeMetricModel(const Features& features, const std::vector<double>& depth_m,
                            const Calibration& calibration, const MetricModelOptions& options) {
  MetricModel model;
  std::vector<cv::Mat> rows;
  for (int i = 0; i < features.size(); ++i) {
    const cv::KeyPoint& keypoint = features.keypoints[size_t(i)];
    const double z = depth_m[size_t(i)];
    if (z > options.max_depth_m) continue;
    const Eigen::Vector3d ray = calibration.camera.Unproject({keypoint.pt.x, keypoint.pt.y});
    const double sigma = (options.sigma_px + options.sigma_per_size * double(keypoint.size)) / calibration.camera.fx;
    model.features.keypoints.push_back(keypoint);
    model.p_C.emplace_back(z * ray);
    model.covariance.push_back(PointCovariance(ray, z, sigma, calibration.depth.Sigma(z)));
    rows.push_back(features.descriptors.row(i));
  }
  if (!rows.empty()) cv::vconcat(rows, model.features.descriptors);
  return model;
}

MappedView ToMappedView(const MetricModel& model) {
  MappedView view{model.features.keypoints, model.features.descriptors, {}};
  for (const Eigen::Vector3d& p_C : model.p_C) view.depth_m.push_back(p_C.z());
  return view;
}

MetricModel FromMappedView(const MappedView& view, const Calibration& calibration, const MetricModelOptions& options) {
  return MakeMetricModel({view.keypoints, view.descriptors}, view.depth_m, calibration, options);
}

namespace {

bool SameCamera(const CameraModel& a, const CameraModel& b) {
  constexpr double kPart = 0.02;  // a calibration is repeated to better than that
  return a.width_px == b.width_px && a.height_px == b.height_px && std::abs(a.fx / b.fx - 1) < kPart &&
         std::abs(a.fy / b.fy - 1) < kPart;
}

}  // namespace

std::vector<MetricModel> ModelsOf(const RouteMap& map, const Calibration& calibration, const std::string& feature,
                                  const MetricModelOptions& options) {
  const CameraModel &learned = map.camera, &now = calibration.camera;
  if (!SameCamera(learned, now)) {
    throw BadInput("map: it was learned with a camera of " + std::to_string(learned.width_px) + " x " +
                   std::to_string(learned.height_px) + " px, fx " + std::to_string(learned.fx) + "; this one has " +
                   std::to_string(now.width_px) + " x " + std::to_string(now.height_px) + " px, fx " +
                   std::to_string(now.fx));
  }
  if (feature != map.feature)
    throw BadInput("map: it was learned with feature " + map.feature + ", this is " + feature);
  std::vector<MetricModel> models;
  for (const MappedView& view : map.views) models.push_back(FromMappedView(view, calibration, options));
  if (std::all_of(models.begin(), models.end(), [](const MetricModel& m) { return m.p_C.empty(); }))
    throw BadInput("map: it shows nothing");
  return models;
}

std::optional<ModelLink> LinkModels(const MetricModel& from, const MetricModel& to, const ModelLinkOptions& options,
                                    RandomStream& random) {
  MatchingOptions matching;
  matching.ratio = options.ratio;
  const std::vector<Match> matched =
      FilterMatches(MatchDescriptors(from.features.descriptors, to.features.descriptors, matching), from.features,
                    to.features, options.filter, random);
  if (int(matched.size()) < options.min_inliers) return std::nullopt;
  RigidMotionOptions motion;
  motion.method = options.method;
  motion.ransac.threshold = options.inlier_sigmas;
  motion.min_inliers = options.min_inliers;
  const std::vector<PointMatch> points = PointsOf(matched, from, to);
  const RobustRigidMotion found = EstimateRigidMotion(points, motion, random);
  if (!found.motion.ok() || 100 * double(found.inliers.size()) < options.min_inlier_pct * double(points.size()))
    return std::nullopt;
  std::vector<PointMatch> inliers;
  for (const int i : found.inliers) inliers.push_back(points[size_t(i)]);
  const LikelyMotion likely = RefineRigidMotion(inliers, found.motion.X_AB);  // its covariance, whatever the method
  if (!likely.covariance.allFinite()) return std::nullopt;
  return ModelLink{found.motion.X_AB, options.points_per_error * likely.covariance, int(inliers.size()),
                   int(points.size())};
}

}  // namespace gaitcam
