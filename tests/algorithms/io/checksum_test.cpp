#include "algorithms/io/checksum.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

// The examples of FIPS 180-4 that everybody's implementation is checked with.
TEST(Checksum, AgreesWithTheStandardsExamples) {
  EXPECT_EQ(Sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Checksum, OfAFileIsThatOfItsBytes) {
  const std::string text(200000, 'x');  // more than one piece
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.Write("text", text);
  EXPECT_EQ(Sha256OfFile(file), Sha256(text));
  std::filesystem::remove(file);
  EXPECT_THROW(Sha256OfFile(file), BadInput);
  EXPECT_THROW(Sha256OfFile(folder.path()), BadInput);
}

}  // namespace
}  // namespace gaitcam
