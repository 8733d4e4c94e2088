#include "scenarios/code/runs/tracking.h"

namespace gaitcam {

namespace {

void WalkAndAsk(Simulation& simulation, TrackingThread& tracker, const LiveTrackingOptions& options) {
  for (int64_t frames = 0; !options.interrupted(); ++frames) {
    std::optional<SimulatedFrame> frame = simulation.Next(options.wanted_truth(frames));
    if (!frame) return;
    options.on_filmed(frame->truth.stamp_ns);
    options.on_frame(*frame);
    simulation.Command(tracker.Ask(std::move(frame->observation)));
  }
}

void WalkAhead(Simulation& simulation, TrackingThread& tracker, const LiveTrackingOptions& options) {
  FilmedWalk walk(simulation, options.wanted_truth, options.on_filmed);
  while (std::optional<SimulatedFrame> frame = walk.Next(!options.interrupted())) {
    options.on_frame(*frame);
    tracker.Push(std::move(frame->observation));
  }
}

}  // namespace

Estimate TrackLive(Simulation& simulation, TrackingThread& tracker, const LiveTrackingOptions& options) {
  (tracker.acts() ? WalkAndAsk : WalkAhead)(simulation, tracker, options);
  return tracker.Finish();
}

Estimate TrackRecorded(DatasetReader& reader, TrackingThread& tracker, const std::function<bool()>& interrupted,
                       const std::function<void(int64_t)>& on_frame) {
  for (int64_t frames = 0; !interrupted();) {
    std::optional<Observation> observation = reader.Next();
    if (!observation) break;
    tracker.Push(std::move(*observation));
    on_frame(++frames);
  }
  return tracker.Finish();
}

}  // namespace gaitcam
