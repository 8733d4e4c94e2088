/// How the programs under attack are started, what they are given to read, and what they leave.

#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {

namespace fs = std::filesystem;

inline void WriteInputs(const fs::path& folder) {
  std::ofstream truth(folder / "truth.txt"), estimate(folder / "estimate.txt");
  for (int i = 0; i < 40; ++i) {
    truth << 1 + 0.1 * i << " " << 0.1 * i << " " << std::sin(0.2 * i) << " 0 0 0 0 1\n";
    estimate << 1 + 0.1 * i << " " << 0.101 * i << " " << std::sin(0.2 * i) << " 0.01 0 0 0 1\n";
  }
  std::ofstream(folder / "walk.yaml") << "robot: omni_base\nscene: lab\nduration_s: 1.2\n"
                                         "camera: {width_px: 160, height_px: 120, rate_hz: 10, exposure_ms: 5,\n"
                                         "  stereo: {baseline_m: 0.2}}\n"
                                         "video: {enabled: false}\nsystem: stereo_vo\n";
  std::ofstream(folder / "learn.yaml") << "robot: omni_base\nscene: lab\nduration_s: 0.8\n"
                                          "camera: {width_px: 240, height_px: 180, rate_hz: 10, exposure_ms: 5,\n"
                                          "  fixed_subframes: 1, depth: true}\n"
                                          "sensors: {odometry: {rate_hz: 50}}\n"
                                          "video: {enabled: false}\nsystem: hybrid_slam\nscore: {min_pairs: 3}\n";
  std::ofstream(folder / "study.yaml") << "base: walk.yaml\nset: {duration_s: 0.8, score.min_pairs: 3}\n"
                                          "axes: {camera.exposure_ms: [2, 5]}\nseeds: [1]\n"
                                          "metrics: [coverage_ratio]\n";
  std::ofstream(folder / "matrix.yaml") << "base: walk.yaml\nset: {duration_s: 0.5, scene: plain}\n"
                                           "axes: {camera.exposure_ms: [2, 5]}\nseeds: [1]\n";
  std::ofstream(folder / "suite.yaml") << "scenarios:\n  - {name: step, scenario: walk.yaml, set: {duration_s: 0.6,\n"
                                          "     score.min_pairs: 3}}\nsystems: [stereo_vo]\nseeds: 7\n"
                                          "metrics:\n  - {name: rpe_rot_rmse_deg_1f, margin: 0.05}\n";
}

/// Whether what takes hours is wanted, too.
inline bool IsLongPart() { return std::getenv("GAITCAM_LONG_TESTS") != nullptr; }

/// Starts the program in a folder with a folder `tmp` in it, for its temporary files.
/// @param variables of its environment: "NAME=VALUE ..."
/// @param said a file in the folder, for what it prints
inline pid_t StartProgram(const fs::path& folder, const std::string& arguments, const std::string& variables = "",
                          const std::string& said = "/dev/null") {
  const pid_t child = fork();
  if (child != 0) return child;
  const std::string command = "cd " + folder.string() + " && TMPDIR=$PWD/tmp GAITCAM_DATA=" + TestData().string() +
                              " " + variables + " exec " + Program() + " -q " + arguments + " >" + said + " 2>&1";
  execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
  _exit(127);
}

/// @param status as waitpid gives it. @returns as a shell tells it: beyond 128 is a signal.
inline int ExitCode(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

/// Every file below a folder with what is in it, and every folder with nothing in it, by a name that ends with "/".
inline std::map<std::string, std::string> FilesBelow(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& item : fs::recursive_directory_iterator(folder)) {
    const std::string name = item.path().lexically_relative(folder).string();
    if (item.is_regular_file()) files[name] = ReadText(item.path());
    if (item.is_directory() && fs::is_empty(item)) files[name + "/"] = "";
  }
  return files;
}

/// Without what the clock and the machine's memory have their say in, and what a program says while it works.
inline std::map<std::string, std::string> WhatStays(const fs::path& folder) {
  std::map<std::string, std::string> files = FilesBelow(folder);
  static const std::set<std::string> of_time = {"timings.csv", "tracking.csv"};
  for (auto it = files.begin(); it != files.end();) {
    const fs::path name = it->first;
    if (of_time.count(name.filename()) != 0 || name.parent_path().filename() == "log") {
      it = files.erase(it);
      continue;
    }
    std::istringstream lines(it->second);
    std::string kept;
    for (std::string line; std::getline(lines, line);) {
      const auto has = [&](const char* word) { return line.find(word) != std::string::npos; };
      if (!has("track_ms") && !has("peak_memory") && !has("Tracking time")) kept += line + "\n";
    }
    it->second = kept;
    ++it;
  }
  return files;
}

/// Names of files that are not in both as they are in the other, on a line each; the first ten.
inline std::string Changed(const std::map<std::string, std::string>& before,
                           const std::map<std::string, std::string>& after) {
  std::vector<std::string> names;
  for (const auto& [name, content] : before) {
    if (after.count(name) == 0 || after.at(name) != content) names.push_back(name);
  }
  for (const auto& [name, content] : after) {
    if (before.count(name) == 0) names.push_back(name);
  }
  std::string changed;
  for (size_t i = 0; i < std::min<size_t>(names.size(), 10); ++i) changed += names[i] + "\n";
  return changed + (names.size() > 10 ? "and " + std::to_string(names.size() - 10) + " more\n" : "");
}

}  // namespace gaitcam
