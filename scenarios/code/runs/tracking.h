/// How frames reach a system: from a walk that is simulated meanwhile, or from a recorded one. Every verb goes by these
/// two functions.

#pragma once

#include <functional>

#include "algorithms/core/estimate.h"
#include "algorithms/io/dataset_reader.h"
#include "scenarios/code/runs/filmed_walk.h"
#include "scenarios/code/runs/tracking_thread.h"
#include "sim/simulation.h"

namespace gaitcam {

struct LiveTrackingOptions {
  std::function<bool()> interrupted = [] { return false; };
  FilmedWalk::WantedTruth wanted_truth = [](int64_t) { return TruthOptions(); };
  FilmedWalk::OnFilmed on_filmed = [](int64_t) {};
  /// Shown each frame before the system is.
  std::function<void(const SimulatedFrame&)> on_frame = [](const SimulatedFrame&) {};
};

/// Simulates to the end and hands every observation to the system; truth stays on this side. A system that acts is
/// waited for at each frame and the body does what it asks; any other one tracks while the next frames are made
/// (FilmedWalk).
/// @throws what the simulation or the system throws; BadInput if the system commands what the robot cannot
/// do (Simulation::Command).
Estimate TrackLive(Simulation& simulation, TrackingThread& tracker, const LiveTrackingOptions& options);

/// Hands every frame of a dataset to the system, until it is interrupted.
/// @param on_frame told how many frames were handed over.
/// @throws what the reader or the system throws.
Estimate TrackRecorded(
    DatasetReader& reader, TrackingThread& tracker, const std::function<bool()>& interrupted,
    const std::function<void(int64_t)>& on_frame = [](int64_t) {});

}  // namespace gaitcam
