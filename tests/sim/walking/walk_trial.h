/// Walks of the shipped robots without cameras.

#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "scenarios/code/experiments/walk_trial.h"
#include "tests/data_folder.h"

namespace gaitcam {

inline Robot ReadShippedRobot(const std::string& name) { return ReadRobot(name, kModels); }

/// @param values at least one.
inline double Worst(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

struct ShippedWalkOptions : WalkTrialOptions {
  std::string robot = "khr1hv";
  std::string preset = "normal";
};

inline WalkTrialResult RunWalkTrial(const ShippedWalkOptions& options) {
  const Robot robot = ReadShippedRobot(options.robot);
  return RunWalkTrial(robot, robot.gaits.at(options.preset), options);
}

}  // namespace gaitcam
