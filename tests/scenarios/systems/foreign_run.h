/// Short runs with somebody else's system.

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {

/// A program of Python that answers the start and then does `body` for each later line, the message being `m`, the
/// lines numbered from 0 by `n`; say() answers an object, raw() bytes.
inline std::string Answering(const std::string& body) {
  return "#!/usr/bin/env python3\n"
         "import json, os, sys, time\n"
         "def say(answer): print(json.dumps(answer), flush=True)\n"
         "def raw(said): sys.stdout.buffer.write(said); sys.stdout.buffer.flush()\n"
         "for n, line in enumerate(sys.stdin):\n"
         "  m = json.loads(line)\n"
         "  if m['event'] == 'start':\n"
         "    start = m\n"
         "    say({'ready': True})\n"
         "    continue\n" +
         body;
}

class ForeignRun : public testing::Test {
 protected:
  /// Two seconds of a small film where no texture needs painting, tracked by `system` (YAML).
  ProgramResult Run(const std::string& system, const std::string& out = "run") const {
    WriteScenario(system);
    return RunProgram("run s.yaml --out " + out, folder());
  }
  void WriteScenario(const std::string& system) const {
    temporary_.Write("s.yaml",
                     "scene: plain\n"
                     "duration_s: 2\n"
                     "path: {kind: circle, diameter_m: 4}\n"
                     "camera: {exposure_ms: 4, rate_hz: 10, width_px: 160, height_px: 120}\n"
                     "system: " +
                         system + "\nvideo: {enabled: false}\n");
  }
  void WriteProgram(const std::string& name, const std::string& text) const {
    std::filesystem::permissions(temporary_.Write(name, text), std::filesystem::perms::owner_all);
  }
  nlohmann::json ScoresOf(const std::string& out = "run") const {
    return nlohmann::json::parse(ReadText(folder() / out / "scores.json"));
  }
  const std::filesystem::path& folder() const { return temporary_.path(); }

  const TemporaryFolder temporary_;
};

}  // namespace gaitcam
