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

// The names in backticks of one cell of a table.
Folders NamesIn(const std::string& cell) {
  static const std::regex name(R"(`([a-z_/]+)`)");
  Folders names;
  for (std::sregex_iterator i(cell.begin(), cell.end(), name), end; i != end; ++i) names.insert((*i)[1]);
  return names;
}

// The table of rooms in CONTRIBUTING.md: each room and the rooms that it may include besides itself.
std::map<std::string, Folders> ReadRooms(const fs::path& root) {
  const std::regex row(R"(^\| ([^|]*) \| [^|]* \|([^|]*)\|$)");
  std::map<std::string, Folders> rooms;
  std::ifstream stream(root / "CONTRIBUTING.md");
  std::string line;
  bool in_table = false;
  std::smatch match;
  while (std::getline(stream, line)) {
    if (line.rfind("| room |", 0) == 0) in_table = true;
    if (in_table && line.empty()) break;
    if (!in_table || !std::regex_match(line, match, row)) continue;
    const std::string may_include = match[2];
    for (const std::string& room : NamesIn(match[1])) rooms[room] = NamesIn(may_include);
  }
  return rooms;
}

// `folders` and all rooms below them: `sim` stands for `sim/camera` too.
bool Allows(const Folders& folders, const std::string& room) {
  for (const std::string& folder : folders) {
    if (room == folder || room.rfind(folder + "/", 0) == 0) return true;
  }
  return false;
}

// Third-party headers that only these folders may see; and truth, which no estimator may.
const std::map<std::string, Folders> kReserved = {
    {"mujoco/", {"sim"}},
    {"EGL/", {"sim/camera"}},
    {"urdf_", {"models/code/robots"}},
    {"CLI/", {"scenarios/code/commands", "scenarios/code/experiments"}},
    {"openssl/", {"algorithms/io", "results/reports"}},
    {"algorithms/core/frame_truth.h", {"algorithms/io", "sim", "results", "scenarios"}},
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

TEST(Layering, EveryIncludeFollowsTheTableOfRooms) {
  const fs::path root = GAITCAM_SOURCE_DIR;
  const std::map<std::string, Folders> rooms = ReadRooms(root);
  ASSERT_GT(rooms.size(), 20u) << "the table of rooms was not found in CONTRIBUTING.md";
  const std::vector<Include> includes = AllIncludes(root);
  ASSERT_GT(includes.size(), 1000u) << "the walk over the sources found next to nothing";
  for (const Include& include : includes) {
    ASSERT_TRUE(rooms.count(include.from_folder))
        << include.from_file << " lies in a folder that CONTRIBUTING's table does not list";
    if (!fs::exists(root / include.target)) continue;  // a library's header
    const std::string to = FolderOf(include.target);
    if (to == include.from_folder) continue;
    EXPECT_TRUE(Allows(rooms.at(include.from_folder), to)) << include.from_file << " includes " << include.target
                                                           << ", but " << include.from_folder << " may not see " << to;
  }
}

TEST(Layering, EveryRoomOfTheTableExistsAndNoTwoIncludeEachOther) {
  const fs::path root = GAITCAM_SOURCE_DIR;
  const std::map<std::string, Folders> rooms = ReadRooms(root);
  for (const auto& [room, may_include] : rooms) {
    EXPECT_TRUE(fs::is_directory(root / room)) << room;
    for (const std::string& other : may_include) {
      EXPECT_TRUE(fs::is_directory(root / other)) << room << " may include " << other << ", which does not exist";
      if (rooms.count(other)) {
        EXPECT_FALSE(Allows(rooms.at(other), room)) << room << " and " << other;
      }
    }
  }
}

TEST(Layering, LibrariesStayInTheirRooms) {
  for (const Include& include : AllIncludes(GAITCAM_SOURCE_DIR)) {
    for (const auto& [prefix, folders] : kReserved) {
      if (include.target.rfind(prefix, 0) != 0) continue;
      EXPECT_TRUE(Allows(folders, include.from_folder)) << include.from_file << " includes " << include.target;
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

TEST(Layering, FilesAreReadWhereABrokenReadIsToldFromTheEnd) {
  // Each of these takes what was read before a disk failed for the whole file; FileContent does not.
  const std::regex forbidden(R"(\brdbuf\(\)|\bistreambuf_iterator\b|\bYAML::LoadFile\b)");
  for (const char* top : {"algorithms", "models", "sim", "results", "scenarios"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(GAITCAM_SOURCE_DIR) / top)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
      std::ifstream stream(entry.path());
      std::string line;
      while (std::getline(stream, line)) {
        EXPECT_FALSE(std::regex_search(line.substr(0, line.find("//")), forbidden)) << entry.path() << ": " << line;
      }
    }
  }
}

}  // namespace
