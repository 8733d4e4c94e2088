/// The length of the path that was walked: what errors are per cent of.
///
/// A walking robot's camera sways, bobs and is shaken; its own path is one and a half to three times as long as the one
/// it walks, and an error in per cent of that looks as much smaller. So the sway is smoothed away first.

#pragma once

#include <vector>

#include "results/scoring/association.h"

namespace gaitcam {

/// Half width of the window over which the sway is averaged, s: longer than a gait cycle (two steps) of a small robot.
constexpr double kSwayWindow_s = 1.0;

/// Metres gone along the true path up to each pair, 0 at the first. Positions are smoothed by a line that is fitted to
/// all pairs within `window_s` of each, with the weights of a Hann window, whose response is zero at 1 / window_s and
/// its multiples. A straight walk at a steady speed keeps its length. Window 0: the camera's own path.
std::vector<double> WalkedPath(const std::vector<PosePair>& pairs, double window_s = kSwayWindow_s);

}  // namespace gaitcam
