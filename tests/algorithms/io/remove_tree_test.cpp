#include "algorithms/io/remove_tree.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "tests/few_descriptors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

/// Folders in one another, a file in each; their path is longer than any that the system takes at once.
void MakeDeep(const fs::path& folder, int levels) {
  const fs::path here = fs::current_path();
  fs::create_directories(folder);
  fs::current_path(folder);
  for (int i = 0; i < levels; ++i) {
    std::ofstream("file") << i;
    ASSERT_EQ(mkdir("one_inside_another", 0700), 0);
    ASSERT_EQ(chdir("one_inside_another"), 0);
  }
  fs::current_path(here);
}

TEST(RemoveTree, GoesDeeperThanAProcessMayOpenFolders) {
  const TemporaryFolder temporary;
  MakeDeep(temporary.path() / "deep", 300);
  const FewDescriptors few(64);
  std::error_code error;
  fs::remove_all(temporary.path() / "deep", error);
  EXPECT_TRUE(error) << "the library's own would do";
  EXPECT_TRUE(RemoveTree(temporary.path() / "deep"));
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(RemoveTree, NamesThatItWouldHaveChosenAreNoHindrance) {
  const TemporaryFolder temporary;
  for (int i = 1; i < 40; ++i) temporary.Write("gone/.removed-" + std::to_string(i) + "/inner/inner/file", "text");
  temporary.Write("gone/.removed-40", "a file");
  temporary.Write("gone/a/inner/.removed-1/file", "text");
  EXPECT_TRUE(RemoveTree(temporary.path() / "gone"));
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(RemoveTree, TakesLinksAndNotWhatTheyName) {
  const TemporaryFolder temporary;
  const fs::path kept = temporary.Write("kept/file", "text");
  fs::create_directories(temporary.path() / "gone/inner");
  fs::create_directory_symlink(kept.parent_path(), temporary.path() / "gone/inner/folder");
  fs::create_symlink(kept, temporary.path() / "gone/file");
  fs::create_symlink(kept.parent_path(), temporary.path() / "link");
  EXPECT_TRUE(RemoveTree(temporary.path() / "gone"));
  EXPECT_TRUE(RemoveTree(temporary.path() / "link"));
  EXPECT_EQ(ReadText(kept), "text");
  EXPECT_EQ(std::distance(fs::directory_iterator(temporary.path()), {}), 1);
}

// Of root no permission is asked: this shows something where another user runs it.
TEST(RemoveTree, LooksIntoWhatItsOwnerMayNotRead) {
  const TemporaryFolder temporary;
  temporary.Write("gone/locked/inner/file", "text");
  temporary.Write("gone/readable/file", "text");
  fs::permissions(temporary.path() / "gone/locked/inner", fs::perms::none);
  fs::permissions(temporary.path() / "gone/locked", fs::perms::none);
  fs::permissions(temporary.path() / "gone/readable", fs::perms::owner_read);
  fs::permissions(temporary.path() / "gone", fs::perms::none);
  EXPECT_TRUE(RemoveTree(temporary.path() / "gone"));
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(RemoveTree, AFileOrWhatIsNotThereIsNoMatter) {
  const TemporaryFolder temporary;
  const fs::path file = temporary.Write("file", "text");
  EXPECT_TRUE(RemoveTree(file));
  EXPECT_FALSE(fs::exists(file));
  EXPECT_TRUE(RemoveTree(file)) << "nothing of it stays";
}

}  // namespace
}  // namespace gaitcam
