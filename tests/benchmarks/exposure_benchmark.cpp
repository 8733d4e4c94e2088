// What parts of a frame cost; a whole one beside MuJoCo's bare loop: gaitcam experiment speed.

#include <benchmark/benchmark.h>

#include "sim/camera/image_sensor.h"
#include "sim/camera/light.h"

namespace gaitcam {
namespace {

void BM_SensorNoise(benchmark::State& state) {
  const ImageSensor sensor(ExposureOptions(), false);
  const cv::Mat light(240, 320, CV_32FC3, cv::Scalar(0.2, 0.4, 0.6));
  uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sensor.Develop(light, RandomStream(++seed, "benchmark")));
}
BENCHMARK(BM_SensorNoise)->Unit(benchmark::kMillisecond);

void BM_AddLight(benchmark::State& state) {
  const cv::Mat picture(240, 320, CV_8UC4, cv::Scalar(20, 100, 200, 255));
  LightAccumulator light(320, 240);
  for (auto _ : state) light.Add(picture, 1e-6f);
}
BENCHMARK(BM_AddLight)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
