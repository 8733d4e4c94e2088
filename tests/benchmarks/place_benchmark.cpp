// What recognising a place costs: signatures, and a view against 1000 panoramas of 720 x 160 px with all windows and
// sub-shifts, on one core. Pictures are noise of several scales: no method's time but that of ORB depends on them.
// And an incremental dictionary of 10,000 places of 100 features, half of which the next place shows too.
//
// Counters: `bytes` per place; `found`: share of views whose place is the answer; `words` of the dictionary.

#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/random.h"
#include "algorithms/places/pirf_nav.h"
#include "algorithms/places/place_recognition.h"

namespace gaitcam {
namespace {

constexpr int kPlaces = 1000;

cv::Mat Picture(int width_px, uint64_t seed) {
  RandomStream random(seed, "place_benchmark");
  cv::Mat sum = cv::Mat::zeros(160, width_px, CV_32FC1);
  for (const int cell_px : {4, 16, 40}) {
    cv::Mat noise(160 / cell_px + 1, width_px / cell_px + 1, CV_32FC1), large;
    for (int k = 0; k < int(noise.total()); ++k) noise.ptr<float>()[k] = float(random.Normal());
    cv::resize(noise, large, sum.size(), 0, 0, cv::INTER_NEAREST);
    sum += large;
  }
  cv::Mat picture;
  sum.convertTo(picture, CV_8UC1, 30, 128);
  return picture;
}

void BM_WaveletOfView(benchmark::State& state) {
  cv::setNumThreads(1);
  const WaveletEncoder encoder(160);
  const cv::Mat view = Picture(208, 1);
  for (auto _ : state) benchmark::DoNotOptimize(encoder.OfView(view));
}
BENCHMARK(BM_WaveletOfView)->Unit(benchmark::kMillisecond);

void BM_WaveletOfPanorama(benchmark::State& state) {
  cv::setNumThreads(1);
  const WaveletEncoder encoder(160);
  const cv::Mat panorama = Picture(720, 1);
  for (auto _ : state) benchmark::DoNotOptimize(encoder.OfPanorama(panorama));
}
BENCHMARK(BM_WaveletOfPanorama)->Unit(benchmark::kMillisecond);

/// The signature of a view of 208 x 160 px, given, against all places.
void BM_WaveletQuery(benchmark::State& state) {
  const WaveletEncoder encoder(160);
  WaveletMap map;
  for (uint64_t seed = 0; seed < kPlaces; ++seed) map.Add(encoder.OfPanorama(Picture(720, seed)));
  const WaveletView view = encoder.OfView(Picture(int(state.range(0)), 5));
  for (auto _ : state) benchmark::DoNotOptimize(map.Query(view));
  state.counters["bytes"] = double(map.bytes_per_place());
}
BENCHMARK(BM_WaveletQuery)->ArgName("view_px")->Arg(114)->Arg(208)->Unit(benchmark::kMillisecond);

/// From the view's picture to all matches.
void BM_PlaceQuery(benchmark::State& state, const std::string& name) {
  cv::setNumThreads(1);
  PlaceIndexSetup setup;
  setup.view_width_px = 208;
  for (uint64_t seed = 0; seed < 8; ++seed) setup.training.push_back(Picture(720, 5000 + seed));
  const auto index = MakePlaceIndex(name, setup);
  for (uint64_t seed = 0; seed < kPlaces; ++seed) index->Add(Picture(720, seed));
  const cv::Mat view = Picture(208, 5);
  for (auto _ : state) benchmark::DoNotOptimize(index->Query(view));
  state.counters["bytes"] = index->bytes_per_place();
}
BENCHMARK_CAPTURE(BM_PlaceQuery, wavelet, "wavelet")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PlaceQuery, fourier, "fourier")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PlaceQuery, fourier_whole, "fourier_whole")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PlaceQuery, thumbnail, "thumbnail")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_PlaceQuery, orb_words, "orb_words")->Unit(benchmark::kMillisecond);

/// A walk along which things are passed: unit vectors of 64 numbers, seen with noise. Directions drawn evenly are the
/// hardest to search that there are.
class LongWalk {
 public:
  Features See(int place) {
    Features view;
    view.descriptors.create(kFeatures, 64, CV_32FC1);
    for (int k = 0; k < kFeatures; ++k) {
      RandomStream thing(uint64_t(place * kFeatures / 2 + k), "long_walk");
      for (int d = 0; d < 64; ++d)
        view.descriptors.at<float>(k, d) = float((thing.Normal() + 0.1 * noise_.Normal()) / std::sqrt(64.0));
    }
    return view;
  }

 private:
  static constexpr int kFeatures = 100;
  RandomStream noise_{1, "noise"};
};

void BM_PirfNavQuery(benchmark::State& state) {
  cv::setNumThreads(1);
  const int places = int(state.range(0));
  LongWalk walk;
  PirfNav memory;
  for (int place = 0; place < places; ++place) memory.Add(walk.See(place));
  std::vector<Features> views;
  for (int k = 0; k < 50; ++k) views.push_back(walk.See(k * places / 50));
  size_t asked = 0, found = 0;
  for (auto _ : state) {
    const PlaceAnswer answer = memory.Ask(views[asked % views.size()], memory.size());
    found += answer.place == int(asked % views.size()) * places / 50;
    ++asked;
  }
  state.counters["bytes"] = memory.bytes_per_place();
  state.counters["found"] = double(found) / double(asked);
  state.counters["words"] = memory.dictionary().size();
}
BENCHMARK(BM_PirfNavQuery)->ArgName("places")->Arg(1000)->Arg(10000)->Iterations(100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
