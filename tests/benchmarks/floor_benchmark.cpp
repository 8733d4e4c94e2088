// Floor-plane SLAM on a walk of 15 s over the tabletop, 320 x 240 px at 30 Hz, by the number of particles.
//
// Counters: `real_time` is frames per second of one thread's processor time over the camera's 30; above 1 the system
// keeps up. `tracker_ms` and `judge_ms` per frame: aligning with the keyframe, and, in frames that succeed one, judging
// its regions and making the next. `patch_ms` and `filter_ms` per keyframe: rectifying what it shows, moving and
// weighing the particles. Floor seen 20 cm of way ago already counts as seen again, so that most keyframes are
// matched: more work than on a walk.

#include <benchmark/benchmark.h>
#include <time.h>

#include <optional>
#include <vector>

#include "algorithms/planes/floor_filter.h"
#include "algorithms/planes/floor_tracker.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace {

double ThreadTime_ms() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}

struct Walk {
  Calibration calibration;
  std::vector<Observation> frames;
};

const Walk& Tabletop() {
  static const Walk walk = [] {
    const ResolvedScenario resolved =
        ReadScenario(GAITCAM_SOURCE_DIR "/scenarios/tabletop_khr1hv.yaml", {"duration_s=15", "gait.preset=normal"});
    Simulation simulation(resolved.robot, resolved.scene, SimulationOptionsOf(resolved), resolved.scenario.seed);
    Walk made{simulation.calibration(), {}};
    while (std::optional<SimulatedFrame> frame = simulation.Next())
      made.frames.push_back(std::move(frame->observation));
    return made;
  }();
  return walk;
}

void BM_FloorSlam(benchmark::State& state) {
  const Walk& walk = Tabletop();
  FloorFilterOptions options;
  options.particles = int(state.range(0));
  options.loop_m = 0.2;
  double tracker_ms = 0, judge_ms = 0, patch_ms = 0, filter_ms = 0;
  size_t frames = 0, keyframes = 0, matched = 0;
  for (auto _ : state) {
    FloorTracker tracker(walk.calibration, {});
    FloorFilter filter(options, 1);
    PlanarPose last;
    const double begin_ms = tracker_ms + judge_ms + patch_ms + filter_ms;
    for (const Observation& frame : walk.frames) {
      const double start = ThreadTime_ms();
      const FloorTrack track = tracker.Track(frame);
      const double tracked = ThreadTime_ms();
      (track.retired ? judge_ms : tracker_ms) += tracked - start;
      ++frames;
      if (!track.retired) continue;
      const FloorKeyframe& keyframe = *track.retired;
      const FloorPatch patch =
          FloorPatch::Of(keyframe.image, keyframe.floor, tracker.camera(), keyframe.X_WK, options.cell_m,
                         options.range_heights * keyframe.X_WK.translation.z(), options.match_points);
      const double rectified = ThreadTime_ms();
      const PlanarPose here = BelowCamera(keyframe.X_WK);
      filter.Step(last.Inverse() * here, keyframe.covariance, patch);
      last = here;
      patch_ms += rectified - tracked;
      filter_ms += ThreadTime_ms() - rectified;
      ++keyframes;
      matched += filter.corrected() > 0;
    }
    state.SetIterationTime(1e-3 * (tracker_ms + judge_ms + patch_ms + filter_ms - begin_ms));
  }
  const double n = double(frames), k = double(std::max<size_t>(1, keyframes));
  state.counters["tracker_ms"] = tracker_ms / (n - k);
  state.counters["judge_ms"] = judge_ms / k;
  state.counters["patch_ms"] = patch_ms / k;
  state.counters["filter_ms"] = filter_ms / k;
  state.counters["matched"] = double(matched) / k;
  state.counters["real_time"] = 1e3 * n / (tracker_ms + judge_ms + patch_ms + filter_ms) / 30;
}
BENCHMARK(BM_FloorSlam)->Arg(100)->Arg(500)->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
