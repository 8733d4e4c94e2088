#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "algorithms/core/errors.h"
#include "results/reports/report.h"
#include "results/reports/video.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/systems/sandbox.h"
#include "sim/camera/egl_context.h"

namespace gaitcam {
namespace {

struct Finding {
  std::string what, answer;
  bool good = true;
};

/// Runs one check; the text of an exception is its finding.
template <class Check>
Finding Examine(const std::string& what, Check check) {
  try {
    return {what, check(), true};
  } catch (const std::exception& e) {
    return {what, e.what(), false};
  }
}

/// What decides unless a scenario says `camera.renderer`, or says what the scenario does not.
std::string WhoChooses() {
  const char* variable = std::getenv("GAITCAM_EGL");
  return variable == nullptr || *variable == '\0' ? "camera.renderer: auto" : std::string("GAITCAM_EGL=") + variable;
}

std::vector<Finding> Findings() {
  std::vector<Finding> findings;
  for (const auto& [name, version] : LibraryVersions()) findings.push_back({name, version});
  findings.push_back({"processors", std::to_string(std::thread::hardware_concurrency())});
  findings.push_back(Examine("data folder", [] { return DataFolder().string(); }));
  for (const EglDeviceReport& report : ListEglDevices())
    findings.push_back({fmt::format("EGL device {}", report.device.index), report.ToText()});
  findings.push_back(Examine("EGL", [] {
    const RendererInfo renderer = EglContext().info();
    return WhoChooses() + " takes " + renderer.ToText() +
           (renderer.is_software ? " -- SOFTWARE RENDERING: correct, but far slower than a GPU" : "");
  }));
  findings.push_back(Examine("report charts", [] {
    ReportHtml(ReportInput{});
    return std::string("Chart.js found");
  }));
  findings.push_back({"sandbox", WhyNoSandbox().empty() ? "bubblewrap keeps other people's systems from the truth"
                                                        : WhyNoSandbox() + "; other people's systems run without one"});
  findings.push_back(Examine("H.264 film", [] {
    const auto file = std::filesystem::temp_directory_path() / fmt::format("gaitcam-doctor-{}.mp4", getpid());
    VideoWriter writer(file);
    writer.Add({cv::Mat(64, 64, CV_8UC3, cv::Scalar::all(0)), {}, 0, 0, "", false});
    writer.Finish();
    std::filesystem::remove(file);
    return std::string("can be written");
  }));
  return findings;
}

}  // namespace

int DoctorCommand(const CommonOptions& common) {
  bool healthy = true;
  nlohmann::ordered_json json;
  for (const Finding& finding : Findings()) {
    healthy &= finding.good;
    if (common.json) {
      json[finding.what] = {{"ok", finding.good}, {"answer", finding.answer}};
    } else {
      fmt::print("{:<14} {}{}\n", finding.what, finding.good ? "" : "MISSING: ", finding.answer);
    }
  }
  if (common.json) fmt::print("{}\n", json.dump(2));
  return healthy ? 0 : 4;
}

}  // namespace gaitcam
