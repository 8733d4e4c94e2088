#include "algorithms/features/surf.h"

#include <dlib/array2d.h>
#include <dlib/image_keypoint.h>
#include <dlib/image_transforms.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr double kSizePerScale = 2;  // a keypoint's size is a diameter, dlib's scale a standard deviation

using GreyImage = dlib::array2d<unsigned char>;

GreyImage ToDlib(const cv::Mat& image) {
  cv::Mat grey = image;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  GreyImage pixels(grey.rows, grey.cols);
  for (int v = 0; v < grey.rows; ++v) {
    for (int u = 0; u < grey.cols; ++u) pixels[v][u] = grey.at<uchar>(v, u);
  }
  return pixels;
}

cv::KeyPoint ToKeyPoint(const dlib::surf_point& point) {
  double angle = point.angle * 180 / M_PI;
  if (angle < 0) angle += 360;
  return {float(point.p.center.x()), float(point.p.center.y()), float(kSizePerScale * point.p.scale), float(angle),
          float(point.p.score)};
}

void CopyDescriptor(const dlib::matrix<double, 64, 1>& descriptor, float* row) {
  for (long k = 0; k < 64; ++k) row[k] = float(descriptor(k));
}

/// Describes given keypoints; those too near to the image's edge are dropped.
cv::Mat Describe(const GreyImage& image, std::vector<cv::KeyPoint>& keypoints) {
  dlib::integral_image integral;
  integral.load(image);
  cv::Mat rows(0, 64, CV_32F);
  std::vector<cv::KeyPoint> kept;
  for (const cv::KeyPoint& k : keypoints) {
    const double scale = k.size / kSizePerScale;
    const auto window = static_cast<unsigned long>(32 * scale);
    if (!dlib::get_rect(integral).contains(
            dlib::centered_rect(dlib::point(long(k.pt.x), long(k.pt.y)), window, window))) {
      continue;
    }
    dlib::matrix<double, 64, 1> descriptor;
    dlib::compute_surf_descriptor(integral, dlib::dpoint(k.pt.x, k.pt.y), scale, k.angle * M_PI / 180, descriptor);
    kept.push_back(k);
    rows.push_back(cv::Mat(1, 64, CV_32F));
    CopyDescriptor(descriptor, rows.ptr<float>(rows.rows - 1));
  }
  keypoints = kept;
  return rows;
}

}  // namespace

cv::Ptr<Surf> Surf::create(double threshold) {
  GAITCAM_ASSERT(threshold > 0);
  cv::Ptr<Surf> surf = cv::makePtr<Surf>();
  surf->threshold_ = threshold;
  return surf;
}

void Surf::detectAndCompute(cv::InputArray image, cv::InputArray mask, std::vector<cv::KeyPoint>& keypoints,
                            cv::OutputArray descriptors, bool use_provided_keypoints) {
  const GreyImage pixels = ToDlib(image.getMat());
  cv::Mat rows(0, 64, CV_32F);
  if (use_provided_keypoints) {
    rows = Describe(pixels, keypoints);
  } else {
    constexpr long kMaxPoints = 100000;  // callers keep the strongest they want
    keypoints.clear();
    for (const dlib::surf_point& point : dlib::get_surf_points(pixels, kMaxPoints, threshold_)) {
      const cv::KeyPoint keypoint = ToKeyPoint(point);
      if (!mask.empty() && mask.getMat().at<uchar>(cv::Point(keypoint.pt)) == 0) continue;
      keypoints.push_back(keypoint);
      rows.push_back(cv::Mat(1, 64, CV_32F));
      CopyDescriptor(point.des, rows.ptr<float>(rows.rows - 1));
    }
  }
  if (descriptors.needed()) rows.copyTo(descriptors);
}

}  // namespace gaitcam
