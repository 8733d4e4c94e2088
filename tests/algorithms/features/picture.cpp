#include "tests/algorithms/features/picture.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"
#include "tests/algorithms/features/psf_fixtures.h"

namespace gaitcam {

cv::Mat RandomPicture(const cv::Size& size, uint64_t seed) {
  RandomStream random(seed, "picture");
  cv::Mat picture(size, CV_8UC1, cv::Scalar(random.Uniform(60, 200)));
  const int shapes = size.area() / 700;
  for (int i = 0; i < shapes; ++i) {
    const cv::Scalar grey(random.Uniform(0, 255));
    const cv::Point centre(random.Index(size.width), random.Index(size.height));
    const double radius = random.Uniform(3, 3 + 40 * std::exp(-3.0 * i / shapes));
    if (random.Uniform() < 0.5) {
      cv::circle(picture, centre, int(radius), grey, cv::FILLED, cv::LINE_AA);
      continue;
    }
    const cv::RotatedRect box(centre, cv::Size2f(float(2 * radius), float(random.Uniform(4, 2 * radius))),
                              float(random.Uniform(0, 180)));
    cv::Point2f corners[4];
    box.points(corners);
    std::vector<cv::Point> polygon(corners, corners + 4);
    cv::fillConvexPoly(picture, polygon, grey, cv::LINE_AA);
  }
  return picture;
}

cv::Mat BlurAndCrop(const cv::Mat& grey, const LineBlur& blur, int margin_px) {
  cv::Mat values, cropped;
  grey.convertTo(values, CV_32F);
  if (blur.extent_px > 0)
    cv::filter2D(values.clone(), values, CV_32F, LineBlurKernel(blur), {-1, -1}, 0, cv::BORDER_REFLECT_101);
  values(cv::Rect(margin_px, margin_px, grey.cols - 2 * margin_px, grey.rows - 2 * margin_px))
      .convertTo(cropped, CV_8U);
  return cropped;
}

}  // namespace gaitcam
