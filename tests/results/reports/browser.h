// Pages opened by a real browser.

#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "tests/temporary_folder.h"

namespace gaitcam {

namespace fs = std::filesystem;

struct Browsed {
  std::string dom, complaints;
};

/// Loads a page in headless Chromium; `more` are further switches.
inline Browsed Browse(const fs::path& page, const std::string& more = "") {
  const TemporaryFolder profile;
  const std::string dom = profile.path() / "dom.html", log = profile.path() / "log.txt";
  const std::string command =
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync --user-data-dir='" +
      profile.path().string() + "/profile' --enable-logging=stderr --virtual-time-budget=2000 --dump-dom " + more +
      " 'file://" + page.string() + "' >'" + dom + "' 2>'" + log + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << ReadText(log);
  Browsed result{ReadText(dom), ""};
  std::istringstream lines(ReadText(log));
  for (std::string line; std::getline(lines, line);) {
    if (line.find("CONSOLE") != std::string::npos) result.complaints += line + "\n";
  }
  return result;
}

inline std::string Attribute(const std::string& dom, const std::string& name) {
  const size_t at = dom.find(" " + name + "=\"");
  if (at == std::string::npos) return "absent";
  const size_t begin = at + name.size() + 3;
  return dom.substr(begin, dom.find('"', begin) - begin);
}

/// A developer who wants to look sets GAITCAM_KEEP_REPORT to a folder.
inline fs::path PageFolder(const TemporaryFolder& temporary) {
  const char* keep = std::getenv("GAITCAM_KEEP_REPORT");
  return keep ? fs::path(keep) : temporary.path();
}

inline bool HaveChromium() { return std::system("command -v chromium >/dev/null") == 0; }

/// Counts of canvases and of those that show data, as the page itself found.
inline void ExpectAllDrawn(const Browsed& browsed, const std::string& charts) {
  EXPECT_EQ(browsed.complaints, "");
  EXPECT_EQ(Attribute(browsed.dom, "data-charts"), charts);
  EXPECT_EQ(Attribute(browsed.dom, "data-charts-drawn"), charts);
}

}  // namespace gaitcam
