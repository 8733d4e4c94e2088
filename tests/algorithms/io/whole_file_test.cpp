#include "algorithms/io/whole_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <sstream>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

std::string ContentOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

size_t EntriesOf(const fs::path& folder) { return size_t(std::distance(fs::directory_iterator(folder), {})); }

TEST(WholeFile, ReplacesAnOlderOneAndLeavesNothingBeside) {
  const TemporaryFolder temporary;
  const fs::path file = temporary.path() / "scores.json";
  WriteWholeFile(file, "old and longer");
  WriteWholeFile(file, "new");
  EXPECT_EQ(ContentOf(file), "new");
  EXPECT_EQ(EntriesOf(temporary.path()), 1u);
}

TEST(WholeFile, ADeviceOrAPipeIsWrittenToAndStaysWhatItIs) {
  WriteWholeFile("/dev/null", "text");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  const TemporaryFolder temporary;
  const fs::path pipe = temporary.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::fstream reader(pipe, std::ios::in | std::ios::out);  // open at both ends, so that nobody waits
  WriteWholeFile(pipe, "text\n");
  std::string said;
  std::getline(reader, said);
  EXPECT_EQ(said, "text");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(WholeFile, AFullDiskIsSaidWithItsReason) {
  try {
    WriteWholeFile("/dev/full", "text");
    FAIL() << "nothing can be written there";
  } catch (const MissingResource& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("/dev/full: cannot write this file: No space left on device"));
  }
}

TEST(WholeFile, ThroughASymbolicLinkTheFileIsReplacedAndTheLinkStays) {
  const TemporaryFolder temporary;
  const fs::path file = temporary.path() / "file", link = temporary.path() / "link";
  WriteWholeFile(file, "old");
  fs::create_symlink("file", link);
  WriteWholeFile(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(ContentOf(file), "new");
}

TEST(WholeFile, AFolderIsRefusedAndStays) {
  const TemporaryFolder temporary;
  EXPECT_THROW(WriteWholeFile(temporary.path(), "text"), BadInput);
  EXPECT_THROW(CheckWritable(temporary.path()), BadInput);
  EXPECT_TRUE(fs::is_directory(temporary.path()));
}

TEST(WholeFile, WhetherItCanBeWrittenIsToldWithoutATrace) {
  const TemporaryFolder temporary;
  CheckWritable(temporary.path() / "file");
  EXPECT_TRUE(fs::is_empty(temporary.path()));
  EXPECT_THROW(CheckWritable(temporary.path() / "no" / "file"), MissingResource);
}

TEST(WholeFile, WhatAProcessLeftThatIsGoneIsRemovedAndWhatOneWritesStays) {
  const TemporaryFolder temporary;
  const fs::path wanted = temporary.path() / "run";
  const std::string ours = UnfinishedNameFor(wanted).string();
  const fs::path of_the_first = ours.substr(0, ours.rfind('-')) + "-1";        // always runs
  const fs::path of_nobody = ours.substr(0, ours.rfind('-')) + "-2147483646";  // above the largest number of a process
  const fs::path of_another_machine = temporary.path() / (UnfinishedPrefix(wanted) + "elsewhere-2147483646");
  const fs::path one_of_nobodys = of_nobody.string() + "-a1";
  for (const fs::path& path : {fs::path(ours), of_the_first, of_nobody, one_of_nobodys, of_another_machine})
    fs::create_directory(path);
  RemoveAbandoned(wanted);
  EXPECT_FALSE(fs::exists(of_nobody));
  EXPECT_FALSE(fs::exists(one_of_nobodys));
  EXPECT_EQ(EntriesOf(temporary.path()), 3u);
}

}  // namespace
}  // namespace gaitcam
