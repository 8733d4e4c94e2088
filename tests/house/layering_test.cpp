// The house's arrows: which folder may include which. Reads the include lines of the sources themselves.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;
using Folders = std::set<std::string>;

const Folders kAlgorithmsButIo = {"algorithms/core",      "algorithms/features", "algorithms/geometry",
                                  "algorithms/odometry",  "algorithms/planes",   "algorithms/places",
                                  "algorithms/estimation"};

Folders With(Folders folders, const Folders& more) {
  folders.insert(more.begin(), more.end());
  return folders;
}

const Folders kAllBelowScenarios =
    With(kAlgorithmsButIo, {"algorithms/io", "algorithms/slam", "models", "sim", "results"});

// Folder to the folders it may include, besides itself.
const std::map<std::string, Folders> kArrows = {
    {"algorithms/core", {}},
    {"algorithms/io", {"algorithms/core"}},
    {"algorithms/features", {"algorithms/core"}},
    {"algorithms/geometry", {"algorithms/core"}},
    {"algorithms/odometry", {"algorithms/core", "algorithms/features", "algorithms/geometry"}},
    {"algorithms/planes", {"algorithms/core", "algorithms/features", "algorithms/geometry", "algorithms/estimation"}},
    {"algorithms/places", {"algorithms/core", "algorithms/features", "algorithms/geometry"}},
    {"algorithms/estimation", {"algorithms/core"}},
    {"algorithms/slam", kAlgorithmsButIo},
    {"models", {"algorithms/core"}},
    {"sim", {"algorithms/core", "models"}},
    {"results", {"algorithms/core"}},
    {"scenarios", kAllBelowScenarios},
    {"scenarios/runs", With(kAllBelowScenarios, {"scenarios"})},
    {"scenarios/jobs", With(kAllBelowScenarios, {"scenarios", "scenarios/runs"})},
    {"scenarios/datasets", With(kAllBelowScenarios, {"scenarios", "scenarios/runs"})},
    {"scenarios/commands",
     With(kAllBelowScenarios, {"scenarios", "scenarios/runs", "scenarios/jobs", "scenarios/datasets"})},
};

// Third-party headers that only these folders may see.
const std::map<std::string, Folders> kReserved = {
    {"mujoco/", {"sim"}},
    {"EGL/", {"sim"}},
    {"urdf_", {"models"}},
    {"CLI/", {"scenarios/commands"}},
    {"openssl/", {"algorithms/io"}},
};

std::string FolderOf(const fs::path& relative) { return relative.parent_path().generic_string(); }

struct Include {
  std::string from_file, from_folder, target;
};

std::vector<Include> AllIncludes(const fs::path& root) {
  const std::regex line_pattern(R"(^\s*#\s*include\s*["<]([^">]+)[">])");
  std::vector<Include> includes;
  for (const std::string top : {"algorithms", "models", "sim", "results", "scenarios"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const fs::path relative = fs::relative(entry.path(), root);
      std::ifstream stream(entry.path());
      std::string line;
      std::smatch match;
      while (std::getline(stream, line)) {
        if (std::regex_search(line, match, line_pattern)) {
          includes.push_back({relative.generic_string(), FolderOf(relative), match[1]});
        }
      }
    }
  }
  return includes;
}

TEST(Layering, EveryIncludeFollowsAnArrowOfTheHouse) {
  const fs::path root = GAITCAM_SOURCE_DIR;
  const std::vector<Include> includes = AllIncludes(root);
  ASSERT_GT(includes.size(), 100u) << "the walk over the sources found next to nothing";
  for (const Include& include : includes) {
    ASSERT_TRUE(kArrows.count(include.from_folder))
        << include.from_file << " lies in a folder that the house has no room for";
    if (!fs::exists(root / include.target)) continue;  // a library's header
    const std::string to = FolderOf(include.target);
    if (to == include.from_folder) continue;
    EXPECT_TRUE(kArrows.at(include.from_folder).count(to)) << include.from_file << " includes " << include.target
                                                           << ", but " << include.from_folder << " may not see " << to;
  }
}

TEST(Layering, LibrariesStayInTheirRooms) {
  for (const Include& include : AllIncludes(GAITCAM_SOURCE_DIR)) {
    for (const auto& [prefix, folders] : kReserved) {
      if (include.target.rfind(prefix, 0) != 0) continue;
      EXPECT_TRUE(folders.count(include.from_folder)) << include.from_file << " includes " << include.target;
    }
  }
}

TEST(Layering, AnObservationHasNoRoomForAPose) {
  std::ifstream stream(fs::path(GAITCAM_SOURCE_DIR) / "algorithms/core/observation.h");
  ASSERT_TRUE(stream);
  std::string line;
  while (std::getline(stream, line)) {
    const std::string code = line.substr(0, line.find("//"));
    EXPECT_EQ(code.find("Pose"), std::string::npos) << line;
    EXPECT_EQ(code.find("core/pose.h"), std::string::npos) << line;
    EXPECT_EQ(code.find("Truth"), std::string::npos) << line;
  }
}

TEST(Layering, NoAlgorithmReadsTheClockOrLeavesTheProgram) {
  // rand, exit, usleep and wall clocks would make an estimate depend on something other than seed and input.
  const std::regex forbidden(
      R"(\b(std::)?(s?rand|exit|abort|usleep|sleep_for|system_clock|steady_clock|random_device)\s*(\(|::))");
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(GAITCAM_SOURCE_DIR) / "algorithms")) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path());
    std::string line;
    while (std::getline(stream, line)) {
      EXPECT_FALSE(std::regex_search(line.substr(0, line.find("//")), forbidden)) << entry.path() << ": " << line;
    }
  }
}

}  // namespace
