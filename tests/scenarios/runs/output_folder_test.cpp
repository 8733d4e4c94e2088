#include "scenarios/code/runs/output_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "algorithms/core/errors.h"
#include "algorithms/io/whole_file.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

TEST(OutputFolder, IsNotThereUntilItIsWhole) {
  const TemporaryFolder temporary;
  const fs::path wanted = temporary.path() / "run";
  {
    OutputFolder folder(wanted, "scores.json");
    folder.WriteText("scores.json", "{}");
    EXPECT_FALSE(fs::exists(wanted));
    folder.Commit();
  }
  EXPECT_TRUE(fs::exists(wanted / "scores.json"));
}

TEST(OutputFolder, LeavesNothingBehindWhenItIsAbandoned) {
  const TemporaryFolder temporary;
  { OutputFolder folder(temporary.path() / "runs/today/run", "scores.json"); }
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(OutputFolder, ReplacesAnOlderRunButNothingElse) {
  const TemporaryFolder temporary;
  const fs::path wanted = temporary.path() / "run";
  fs::create_directories(wanted);
  std::ofstream(wanted / "thesis.tex") << "years of work";
  EXPECT_THROW(OutputFolder(wanted, "scores.json"), BadInput);
  EXPECT_TRUE(fs::exists(wanted / "thesis.tex"));
  std::ofstream(wanted / "scores.json") << "old";
  OutputFolder folder(wanted, "scores.json");
  folder.WriteText("scores.json", "new");
  folder.Commit();
  EXPECT_FALSE(fs::exists(wanted / "thesis.tex"));
  std::string text;
  std::ifstream(wanted / "scores.json") >> text;
  EXPECT_EQ(text, "new");
}

TEST(OutputFolder, SaysWhenTheFolderCannotBeMade) {
  EXPECT_THROW(OutputFolder("/proc/nowhere/run", "scores.json"), MissingResource);
  EXPECT_THROW(WriteWholeFile("/proc/nowhere.txt", "text"), MissingResource);
}

}  // namespace
}  // namespace gaitcam
