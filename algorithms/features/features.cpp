#include "algorithms/features/features.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/features/blur_aware_feature.h"
#include "algorithms/features/corner_feature.h"
#include "algorithms/features/mobif.h"
#include "algorithms/features/mobif_adapt.h"
#include "algorithms/features/mobif_restore.h"
#include "algorithms/features/surf.h"

namespace gaitcam {
namespace {

struct Entry {
  FeatureInfo info;
  std::function<cv::Ptr<cv::Feature2D>(double sensitivity)> make;
};

cv::Ptr<cv::Feature2D> MakeSift(double sensitivity) {
  return cv::SIFT::create(0, 3, 0.04 / sensitivity, 10, 1.6, CV_32F);  // but for the threshold OpenCV's own defaults
}

cv::Ptr<cv::Feature2D> MakeAkaze(double sensitivity) {
  return cv::AKAZE::create(cv::AKAZE::DESCRIPTOR_MLDB, 0, 3, float(0.001 / sensitivity));
}

cv::Ptr<cv::Feature2D> MakeOrb(double sensitivity) {
  constexpr int kMaxPoints = 5000;  // callers keep the strongest they want
  const int fast_threshold = std::max(1, int(20 / sensitivity));
  return cv::ORB::create(kMaxPoints, 1.2f, 8, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, fast_threshold);
}

cv::Ptr<cv::Feature2D> MakeFast(double sensitivity) {
  return CornerFeature::create(CornerKind::kFast, std::max(1.0, 20 / sensitivity));
}

cv::Ptr<cv::Feature2D> MakeHarris(double sensitivity) {
  return CornerFeature::create(CornerKind::kHarris, 0.01 / sensitivity);  // OpenCV's own default
}

MobifOptions Sensitive(MobifOptions options, double sensitivity) {
  options.hessian.threshold /= sensitivity;
  return options;
}

cv::Ptr<cv::Feature2D> MakeMobifQuality(double sensitivity) { return MakeMobif(Sensitive({}, sensitivity)); }

cv::Ptr<cv::Feature2D> MakeMobifBlobs(double sensitivity) {
  return MakeMobif(Sensitive(MobifBlobsOptions(), sensitivity));
}

cv::Ptr<cv::Feature2D> MakeMobifFast(double sensitivity) {
  return MakeMobif(Sensitive(MobifFastOptions(), sensitivity));
}

cv::Ptr<cv::Feature2D> MakeMobifPath(double sensitivity) {
  return MakeMobif(Sensitive(MobifPathOptions(), sensitivity));
}

cv::Ptr<cv::Feature2D> MakeThesisRestore(double sensitivity) {
  MobifRestoreOptions options;
  options.hessian.threshold /= sensitivity;
  return MakeMobifRestore(options);
}

cv::Ptr<cv::Feature2D> MakeThesisAdapt(double sensitivity) {
  MobifAdaptOptions options;
  options.hessian.threshold /= sensitivity;
  return MakeMobifAdapt(options);
}

cv::Ptr<cv::Feature2D> MakeSurf(double sensitivity) {
  return Surf::create(30 / sensitivity);  // dlib's own default
}

/// Every detector there is: a new one is one more line here.
std::vector<Entry> AllFeatures() {
  return {
      {{"akaze", "AKAZE (Alcantarilla 2013), OpenCV's"}, MakeAkaze},
      {{"fast", "FAST corners (Rosten 2006) of one scale, described as SIFT does"}, MakeFast},
      {{"harris", "Harris corners (1988) of one scale, described as SIFT does"}, MakeHarris},
      {{"mobif", "restores, adapts or leaves alone, by how the image is blurred"}, MakeMobifQuality},
      {{"mobif_adapt", "MoBIF, second approach (thesis, section 5.3): adapted scale space"}, MakeThesisAdapt},
      {{"mobif_blobs", "mobif without saddle points: fewer points"}, MakeMobifBlobs},
      {{"mobif_fast", "mobif in less time, with fewer points"}, MakeMobifFast},
      {{"mobif_path", "mobif that also finds bent and uneven blur; a second or two more"}, MakeMobifPath},
      {{"mobif_restore", "MoBIF, first approach (thesis, section 5.2): restored image"}, MakeThesisRestore},
      {{"orb", "ORB (Rublee 2011), OpenCV's"}, MakeOrb},
      {{"sift", "SIFT (Lowe 2004), OpenCV's"}, MakeSift},
      {{"surf", "SURF-64 (Bay 2008), dlib's"}, MakeSurf},
  };
}

/// The strongest, and maybe others: our own detectors describe none in vain.
Features FeaturesOf(cv::Feature2D& detector, const cv::Mat& grey, int max_features) {
  auto* const own = dynamic_cast<BlurAwareFeature*>(&detector);
  if (own && !grey.empty()) return own->ExtractStrongest(grey, max_features);
  Features features;
  detector.detectAndCompute(grey, cv::noArray(), features.keypoints, features.descriptors);
  return features;
}

auto SortKey(const cv::KeyPoint& k) { return std::make_tuple(-k.response, k.pt.y, k.pt.x, k.size, k.angle, k.octave); }

}  // namespace

std::vector<FeatureInfo> ListFeatures() {
  std::vector<FeatureInfo> infos;
  for (const Entry& entry : AllFeatures()) infos.push_back(entry.info);
  return infos;
}

cv::Ptr<cv::Feature2D> MakeFeature2d(const std::string& name, double sensitivity) {
  GAITCAM_ASSERT(sensitivity > 0);
  std::vector<std::string> names;
  for (const Entry& entry : AllFeatures()) {
    if (entry.info.name == name) return entry.make(sensitivity);
    names.push_back(entry.info.name);
  }
  throw BadInput("feature " + name + ": there is no such detector; " + DidYouMean(name, names));
}

Features DetectFeatures(cv::Feature2D& detector, const cv::Mat& image, int max_features) {
  GAITCAM_ASSERT(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  const Features found = FeaturesOf(detector, grey, max_features);
  const std::vector<cv::KeyPoint>& keypoints = found.keypoints;
  // OpenCV keeps ties at the limit and promises no order: choose and order by value.
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return SortKey(keypoints[size_t(a)]) < SortKey(keypoints[size_t(b)]); });
  if (order.size() > size_t(max_features)) order.resize(size_t(max_features));
  Features features;
  features.descriptors.create(int(order.size()), detector.descriptorSize(), detector.descriptorType());
  for (size_t i = 0; i < order.size(); ++i) {
    features.keypoints.push_back(keypoints[size_t(order[i])]);
    found.descriptors.row(order[i]).copyTo(features.descriptors.row(int(i)));
  }
  return features;
}

}  // namespace gaitcam
