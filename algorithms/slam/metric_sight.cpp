#include "algorithms/slam/metric_sight.h"

#include "algorithms/core/errors.h"

namespace gaitcam {

MetricSight::MetricSight(const Calibration& calibration, const MetricSightOptions& options, const std::string& system)
    : calibration_(calibration),
      options_(options),
      system_(system),
      detector_(MakeFeature2d(options.feature, options.sensitivity)) {
  if (!calibration.has_depth)
    throw BadInput(system + " needs depth images, which the calibration does not have (has_depth: true)");
}

void MetricSight::Check(const Observation& o) const {
  const std::string stamp = std::to_string(o.stamp_ns) + " ns";
  if (!o.depth) throw BadInput(system_ + ": the frame at " + stamp + " has no depth image");
  if (o.depth->pixels.size() == o.image.pixels.size() && o.depth->pixels.type() == CV_32FC1) return;
  throw BadInput(system_ + ": the depth image at " + stamp + " should have the size of the image, and metres as float");
}

MetricModel MetricSight::See(const Observation& observation) const {
  constexpr int kDetected = 4;  // times as many: features without a depth are no use
  Check(observation);
  const Features features =
      ViewFrame(observation.image.pixels, calibration_.camera, *detector_, kDetected * options_.max_features, {})
          .features;
  MetricModel seen = MakeMetricModel(features, observation.depth->pixels, calibration_, options_.models);
  const size_t kept = size_t(options_.max_features);
  if (seen.p_C.size() <= kept) return seen;
  seen.p_C.resize(kept);
  seen.covariance.resize(kept);
  seen.features.keypoints.resize(kept);
  seen.features.descriptors = seen.features.descriptors.rowRange(0, int(kept));
  return seen;
}

}  // namespace gaitcam
