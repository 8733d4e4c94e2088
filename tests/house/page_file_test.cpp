#include "results/reports/page_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace gaitcam::internal {
namespace {

TEST(PageFile, HoldsEachFileOfTheFolderAsItIs) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(GAITCAM_SOURCE_DIR) / "results/reports/page")) {
    if (entry.path().extension() != ".css" && entry.path().extension() != ".js") continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    EXPECT_EQ(PageFile(entry.path().filename().string()), text.str()) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 9);
}

}  // namespace
}  // namespace gaitcam::internal
