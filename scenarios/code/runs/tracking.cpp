#include "scenarios/code/runs/tracking.h"

namespace gaitcam {

Estimate TrackLive(Simulation& simulation, TrackingThread& tracker, const LiveTrackingOptions& options) {
  while (!options.interrupted()) {
    std::optional<SimulatedFrame> frame = simulation.Next(options.wanted_truth());
    if (!frame) break;
    options.on_frame(*frame);
    if (!tracker.acts()) {
      tracker.Push(std::move(frame->observation));
    } else {
      simulation.Command(tracker.Ask(std::move(frame->observation)));
    }
  }
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
