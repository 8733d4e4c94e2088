/// The frames of a walk, each developed on a second thread while the next one is filmed: what is rendered waits for
/// what was rendered before, and developing needs the processor alone.

#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <optional>

#include "sim/simulation.h"

namespace gaitcam {

class FilmedWalk {
 public:
  /// Which costly parts of the truth are wanted of the n-th frame, from 0.
  using WantedTruth = std::function<TruthOptions(int64_t frame)>;
  /// Told as soon as a frame is filmed, while the simulation stands at its shutter's close. @param stamp_ns the
  /// frame's, of the sensors' clock.
  using OnFilmed = std::function<void(int64_t stamp_ns)>;

  /// Nothing else may walk the simulation on. It must outlive this.
  FilmedWalk(
      Simulation& simulation, WantedTruth wanted, OnFilmed on_filmed = [](int64_t) {});

  /// The same frames as Simulation::Next gives. @param film_on if not, the walk stops where it is, and only a frame
  /// that was filmed already is still given. @returns nothing when there is no frame left.
  /// @throws what filming or developing throws.
  std::optional<SimulatedFrame> Next(bool film_on = true);

 private:
  std::future<SimulatedFrame> Film();

  Simulation& simulation_;
  WantedTruth wanted_;
  OnFilmed on_filmed_;
  int64_t filmed_ = 0;
  std::future<SimulatedFrame> ahead_;  ///< Filmed, in work.
};

}  // namespace gaitcam
