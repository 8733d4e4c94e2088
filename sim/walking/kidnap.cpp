#include "sim/walking/kidnap.h"

#include <algorithm>
#include <cmath>

#include "algorithms/core/pose.h"
#include "algorithms/core/units.h"

namespace gaitcam {

PlanarPose CarriedTo(const KidnapOptions& kidnap, const PlanarPose& from, double time_s) {
  const double u = std::clamp((time_s - kidnap.at_s) / kidnap.over_s, 0.0, 1.0);
  const double part = 0.5 - 0.5 * std::cos(M_PI * u);
  const double turn = WrapAngle(kidnap.to.z() * kRadPerDeg - from.heading);
  return {from.position + part * (kidnap.to.head<2>() - from.position), from.heading + part * turn};
}

}  // namespace gaitcam
