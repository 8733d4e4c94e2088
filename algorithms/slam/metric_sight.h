/// What a frame of a camera with depth shows: its features that have a depth, in space.

#pragma once

#include <opencv2/features2d.hpp>
#include <string>

#include "algorithms/core/camera.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/observation.h"
#include "algorithms/features/features.h"
#include "algorithms/odometry/frame_view.h"
#include "algorithms/slam/metric_model.h"

namespace gaitcam {

struct MetricSightOptions {
  using DescribedTag = void;
  std::string feature = "surf";
  double sensitivity = 5;
  int max_features = 500;
  MetricModelOptions models;
};

template <class Visitor>
void VisitFields(Visitor& visit, MetricSightOptions& o) {
  visit("feature", o.feature, FeatureNames(), "detector and descriptor");
  visit("sensitivity", o.sensitivity, Between(0.01, 1000.0), "the detector's threshold is divided by this");
  visit("max_features", o.max_features, Between(10, 100000), "strongest features with a depth that are kept per frame");
  VisitFields(visit, o.models);
}

class MetricSight {
 public:
  /// @param system whose it is, for messages. @throws BadInput if the camera has no depth or the feature is unknown.
  MetricSight(const Calibration& calibration, const MetricSightOptions& options, const std::string& system);

  /// The strongest features that have a depth, strongest first.
  /// @throws BadInput if an image has not the calibration's size, or there is no depth image of its size.
  MetricModel See(const Observation& observation) const;

  const MetricSightOptions& options() const { return options_; }

 private:
  void Check(const Observation& observation) const;

  Calibration calibration_;
  MetricSightOptions options_;
  std::string system_;
  cv::Ptr<cv::Feature2D> detector_;
};

}  // namespace gaitcam
