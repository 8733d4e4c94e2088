/// Walks of the shipped robots without cameras.

#pragma once

#include <string>

#include "scenarios/code/experiments/walk_trial.h"
#include "tests/data_folder.h"

namespace gaitcam {

inline Robot ReadShippedRobot(const std::string& name) { return ReadRobot(name, TestData() / "models"); }

struct ShippedWalkOptions : WalkTrialOptions {
  std::string robot = "khr1hv";
  std::string preset = "normal";
};

inline WalkTrialResult RunWalkTrial(const ShippedWalkOptions& options) {
  const Robot robot = ReadShippedRobot(options.robot);
  return RunWalkTrial(robot, robot.gaits.at(options.preset), options);
}

}  // namespace gaitcam
