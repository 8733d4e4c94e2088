#include "algorithms/core/file_content.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

std::string ReadError(const std::filesystem::path& file) {
  try {
    FileContent(file);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "none";
}

TEST(FileContent, IsEveryByteOfTheFile) {
  const TemporaryFolder folder;
  std::string bytes(200'001, '\0');  // several pieces, the last one short
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = char(i * 7 + i / 251);
  folder.Write("file", bytes);
  EXPECT_TRUE(FileContent(folder.path() / "file") == bytes);
  EXPECT_TRUE(FindFileContent(folder.path() / "file") == bytes);
  folder.Write("empty", "");
  EXPECT_EQ(FileContent(folder.path() / "empty"), "");
  EXPECT_EQ(FindFileContent(folder.path() / "empty"), "");
}

TEST(FileContent, OfNoFileOrAFolderIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path none = folder.path() / "none";
  EXPECT_EQ(ReadError(none), none.string() + ": cannot read this file");
  EXPECT_EQ(ReadError(folder.path()), folder.path().string() + ": cannot read this file");
  EXPECT_EQ(FindFileContent(none), std::nullopt);
  EXPECT_THROW(FindFileContent(folder.path()), BadInput) << "it is there, and is none";
}

TEST(FileContent, AFileThatCannotBeReadToItsEndIsNotTakenForAShortOne) {
  const char* unreadable = "/proc/self/mem";  // opens, and cannot be read: nothing is at address 0
  EXPECT_THAT(ReadError(unreadable), testing::HasSubstr("reading broke off after 0 bytes"));
  EXPECT_THROW(FindFileContent(unreadable), BadInput);
}

}  // namespace
}  // namespace gaitcam
