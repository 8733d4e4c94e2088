// What writing a data set costs beside rendering it, measured in the same run.
//
// Counters: `recording_speed` is the time of simulating and rendering a walk with all its truth, over the time of doing
// so and writing it (all images on the disk at the end): 1 means that writing costs nothing. `in_add` is the same
// without threads of the writer's own. `encode_ms` is the processor time that one frame's images take to be encoded,
// `render_ms` the time that one frame takes to be rendered: where all cores render, the writer's threads take their
// time from the renderer, and the speed cannot be more than about render / (render + encode / cores).

#include <benchmark/benchmark.h>
#include <stdlib.h>
#include <time.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "scenarios/recorder.h"
#include "scenarios/scenario.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double ProcessorTime() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

struct Cost {
  double wall_s = 0, cpu_s = 0;
  int64_t frames = 0;

  void operator+=(const Cost& other) {
    wall_s += other.wall_s;
    cpu_s += other.cpu_s;
    frames += other.frames;
  }
};

/// From the first frame's end to the last one's.
Cost RenderAlone(const ResolvedScenario& resolved) {
  Simulation simulation(resolved.robot, resolved.place, SimulationOptionsOf(resolved.scenario), resolved.scenario.seed);
  if (!simulation.Next()) return {};
  Cost cost{-Now(), -ProcessorTime(), 0};
  while (simulation.Next()) ++cost.frames;
  cost.wall_s += Now();
  cost.cpu_s += ProcessorTime();
  return cost;
}

/// From the first frame's end until all files have their names. @param threads of the writer.
Cost Record(const ResolvedScenario& resolved, int threads) {
  std::string name = (fs::temp_directory_path() / "gaitcam-benchmark-XXXXXX").string();
  const fs::path folder = mkdtemp(name.data());
  RecordOptions options;
  options.format.threads = threads;
  Cost cost;
  options.progress = [&cost](int64_t frames, int64_t) {
    if (frames == 1) cost = {-Now(), -ProcessorTime(), 0};
  };
  cost.frames = RecordScenario(resolved, DatasetFolders::In(folder, "walk"), options).frames - 1;
  cost.wall_s += Now();
  cost.cpu_s += ProcessorTime();
  fs::remove_all(folder);
  return cost;
}

void BM_RecordWhileRendering(benchmark::State& state) {
  const ResolvedScenario resolved = ReadScenario(
      GAITCAM_SOURCE_DIR "/scenarios/lab_loop.yaml",
      {"duration_s=3", "gait.preset=brisk", "camera.exposure_ms=" + std::to_string(state.range(2)),
       "camera.width_px=" + std::to_string(state.range(0)), "camera.height_px=" + std::to_string(state.range(1))});
  Cost alone, with_threads, in_add;
  for (auto _ : state) {  // in turn, so that whatever else runs on the machine slows all three
    alone += RenderAlone(resolved);
    const Cost recorded = Record(resolved, DatasetWriterOptions().threads);
    in_add += Record(resolved, 0);
    with_threads += recorded;
    state.SetIterationTime(recorded.wall_s);
  }
  const double frames = double(alone.frames);
  state.counters["recording_speed"] = alone.wall_s / with_threads.wall_s;
  state.counters["in_add"] = alone.wall_s / in_add.wall_s;
  state.counters["render_ms"] = 1e3 * alone.wall_s / frames;
  state.counters["render_cpu_ms"] = 1e3 * alone.cpu_s / frames;
  state.counters["encode_ms"] = 1e3 * (with_threads.cpu_s - alone.cpu_s) / frames;
  state.SetLabel(std::to_string(std::thread::hardware_concurrency()) + " cores");
}
BENCHMARK(BM_RecordWhileRendering)
    ->Args({320, 240, 10})
    ->Args({320, 240, 30})
    ->Args({640, 480, 20})
    ->Iterations(3)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
