#include "scenarios/code/runs/live_tracking.h"

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

}  // namespace gaitcam
