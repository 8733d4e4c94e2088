#include "scenarios/code/runs/filmed_walk.h"

#include <utility>

#include "algorithms/core/clock.h"

namespace gaitcam {

FilmedWalk::FilmedWalk(Simulation& simulation, WantedTruth wanted, OnFilmed on_filmed)
    : simulation_(simulation), wanted_(std::move(wanted)), on_filmed_(std::move(on_filmed)) {}

/// @returns what is no future if the walk is over.
std::future<SimulatedFrame> FilmedWalk::Film() {
  std::optional<LatentSimulatedFrame> latent = simulation_.NextLatent(wanted_(filmed_));
  if (!latent) return {};
  ++filmed_;
  on_filmed_(latent->observation.stamp_ns + kClockStart_ns);
  return std::async(std::launch::async,
                    [this, film = std::move(*latent)]() mutable { return simulation_.Develop(std::move(film)); });
}

std::optional<SimulatedFrame> FilmedWalk::Next(bool film_on) {
  if (film_on && !ahead_.valid()) ahead_ = Film();
  if (!ahead_.valid()) return std::nullopt;
  std::future<SimulatedFrame> frame = std::exchange(ahead_, {});
  if (film_on) ahead_ = Film();
  return frame.get();
}

}  // namespace gaitcam
