// What features of a blurred image cost, measured against OpenCV's SIFT on the sharp image in the same run, one thread.
//
// Counters: `ratio` is the time over SIFT's; `points` how many features there were.

#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include "algorithms/features/features.h"
#include "tests/algorithms/features/psf_fixtures.h"
#include "tests/benchmarks/stopwatch.h"

namespace gaitcam {
namespace {

/// graf1 of Debian's opencv-doc at the size asked for; real blur: light added up, noise of sigma 2.
cv::Mat Film(const cv::Size& size, double extent_px) {
  cv::Mat picture = psf_test::Photograph("graf1.png");
  const double scale = double(size.width + 64) / picture.cols;
  cv::resize(picture, picture, cv::Size(), scale, scale, cv::INTER_AREA);
  const cv::Mat filmed = BlurPhotograph(picture, {extent_px, 0.6}, 2, 1, true, size);
  return filmed;
}

double Time(const std::string& detector, const cv::Mat& image, int* points) {
  const cv::Ptr<cv::Feature2D> feature = MakeFeature2d(detector);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const double begin = Now();
  feature->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  *points = int(keypoints.size());
  return Now() - begin;
}

void TimeFeatures(benchmark::State& state, const std::string& detector) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Size size{int(state.range(0)), int(state.range(1))};
  const cv::Mat sharp = Film(size, 0), blurred = Film(size, double(state.range(2)));
  double own_s = 0, sift_s = 0;
  int points = 0, of_sift = 0;
  Time("sift", sharp, &of_sift);
  for (auto _ : state) {  // in turn, so that whatever else runs on the machine slows both
    const double one_s = Time(detector, blurred, &points);
    sift_s += Time("sift", sharp, &of_sift);
    own_s += one_s;
    state.SetIterationTime(one_s);
  }
  state.counters["ratio"] = own_s / sift_s;
  state.counters["points"] = points;
  cv::setNumThreads(threads);
}

void Sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int extent_px : {0, 10, 20, 40})
    for (const auto& [width, height] : {std::pair(320, 240), std::pair(640, 480)})
      benchmark->Args({width, height, extent_px});
  benchmark->UseManualTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(TimeFeatures, mobif, std::string("mobif"))->Apply(Sizes);
BENCHMARK_CAPTURE(TimeFeatures, mobif_fast, std::string("mobif_fast"))->Apply(Sizes);
BENCHMARK_CAPTURE(TimeFeatures, mobif_adapt, std::string("mobif_adapt"))
    ->Args({640, 480, 20})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(TimeFeatures, akaze, std::string("akaze"))
    ->Args({640, 480, 20})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
