// What writing a data set costs beside rendering it, measured in the same run.
//
// Counters, each of a walk that is simulated, rendered with all its truth and written, against the same without
// writing: `recording_speed` by the clock on the wall, all images on the disk at the end (1: writing costs nothing);
// `in_add` likewise, the writer having no threads of its own; `own_thread` by the processor time of the thread that
// renders, which is what remains of the speed where the writer's threads find cores of their own. `encode_ms` is the
// processor time that one frame's images take to be encoded, `render_cpu_ms` that it takes to be rendered: a software
// renderer that has all cores to itself loses to the writer about encode / (render + encode) of its speed, whatever
// the threads. LP_NUM_THREADS=0 keeps Mesa's software renderer on the one thread that own_thread is about.

#include <benchmark/benchmark.h>
#include <time.h>

#include <thread>

#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/recorder.h"
#include "tests/benchmarks/stopwatch.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

double ProcessorTime(clockid_t of) {
  timespec time;
  clock_gettime(of, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// Begins when it is made.
struct Cost {
  double wall_s = -Now(), cpu_s = -ProcessorTime(CLOCK_PROCESS_CPUTIME_ID),
         thread_s = -ProcessorTime(CLOCK_THREAD_CPUTIME_ID);
  int64_t frames = 0;

  void End() {
    wall_s += Now();
    cpu_s += ProcessorTime(CLOCK_PROCESS_CPUTIME_ID);
    thread_s += ProcessorTime(CLOCK_THREAD_CPUTIME_ID);
  }
};

struct Sum {
  double wall_s = 0, cpu_s = 0, thread_s = 0;
  int64_t frames = 0;

  void operator+=(const Cost& cost) {
    wall_s += cost.wall_s;
    cpu_s += cost.cpu_s;
    thread_s += cost.thread_s;
    frames += cost.frames;
  }
};

/// From the first frame's end to the last one's.
Cost RenderAlone(const ResolvedScenario& resolved) {
  Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), resolved.scenario.seed);
  simulation.Next();
  Cost cost;
  while (simulation.Next()) ++cost.frames;
  cost.End();
  return cost;
}

/// From the first frame's end until all files have their names. @param threads of the writer.
Cost Record(const ResolvedScenario& resolved, int threads) {
  const TemporaryFolder folder;
  RecordOptions options;
  options.format.threads = threads;
  Cost cost;
  options.progress = [&cost](int64_t frames, int64_t) {
    if (frames == 1) cost = Cost();
  };
  const int64_t frames = RecordScenario(resolved, DatasetFolders::In(folder.path(), "walk"), options).frames - 1;
  cost.End();
  cost.frames = frames;
  return cost;
}

void BM_RecordWhileRendering(benchmark::State& state) {
  const ResolvedScenario resolved = ReadScenario(
      GAITCAM_SOURCE_DIR "/scenarios/lab_loop.yaml",
      {"duration_s=2", "gait.preset=brisk", "camera.exposure_ms=" + std::to_string(state.range(2)),
       "camera.width_px=" + std::to_string(state.range(0)), "camera.height_px=" + std::to_string(state.range(1))});
  Sum alone, with_threads, in_add;
  for (auto _ : state) {  // in turn, so that whatever else runs on the machine slows all three
    alone += RenderAlone(resolved);
    const Cost recorded = Record(resolved, DatasetWriterOptions().threads);
    in_add += Record(resolved, 0);
    with_threads += recorded;
    state.SetIterationTime(recorded.wall_s);
  }
  const double frames = double(alone.frames);
  state.counters["recording_speed"] = alone.wall_s / with_threads.wall_s;
  state.counters["own_thread"] = alone.thread_s / with_threads.thread_s;
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
    ->Iterations(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
