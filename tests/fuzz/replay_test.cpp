// The corpora of the fuzzer, and what a few thousand deterministic mishaps make of each: every reader answers with a
// value or with what errors.h knows, never with a crash or another exception.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "algorithms/core/random.h"
#include "tests/fuzz/readers.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> CorpusOf(const std::string& reader) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(GAITCAM_SOURCE_DIR) / "tests/fuzz/corpus" / reader))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::string BytesIn(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Cut off, overwritten, doubled, or with something in it that a reader may stumble over.
std::string Mishap(const std::string& bytes, RandomStream& random) {
  static const std::vector<std::string> stumbles = {"nan",
                                                    "inf",
                                                    "-1",
                                                    "1e308",
                                                    "99999999999999999999",
                                                    "0x7f",
                                                    "\n",
                                                    "\n\n",
                                                    ",",
                                                    ",,",
                                                    "\"",
                                                    "{",
                                                    "}",
                                                    "[",
                                                    "]",
                                                    ": ",
                                                    "&a *a",
                                                    "---\n",
                                                    "#",
                                                    std::string(1, '\0'),
                                                    "\xff\xfe",
                                                    "\xc3\x28",
                                                    "%s%n",
                                                    std::string(2000, '['),
                                                    std::string(2000, '9'),
                                                    "<",
                                                    "</",
                                                    "<!--",
                                                    "&lt;",
                                                    "18446744073709551616",
                                                    "-9223372036854775809"};
  std::string worse = bytes;
  const size_t at = worse.empty() ? 0 : size_t(random.Index(int(worse.size())));
  const size_t length = std::min(size_t(1 + random.Index(16)), worse.size() - at);
  switch (random.Index(5)) {
    case 0: return worse.substr(0, at);
    case 1: return worse.insert(at, stumbles[size_t(random.Index(int(stumbles.size())))]);
    case 2: return worse.replace(at, length, stumbles[size_t(random.Index(int(stumbles.size())))]);
    case 3: return worse.insert(at, worse.substr(at, length));
    default:
      for (size_t i = 0; i < length; ++i) worse[at + i] = char(random.Index(256));
      return worse;
  }
}

std::vector<FuzzReader> AllFuzzReaders() {
  std::vector<FuzzReader> readers = FuzzReaders();
  for (FuzzReader& reader : ScenarioFuzzReaders()) readers.push_back(std::move(reader));
  return readers;
}

class FuzzReplay : public testing::TestWithParam<FuzzReader> {};

TEST_P(FuzzReplay, AnswersItsCorpus) {
  const std::vector<fs::path> corpus = CorpusOf(GetParam().name);
  ASSERT_FALSE(corpus.empty());
  for (const fs::path& file : corpus) EXPECT_NO_THROW(GetParam().read(BytesIn(file))) << file;
}

TEST_P(FuzzReplay, AnswersMishaps) {
  constexpr int kMishaps = 400, kAtOnce = 4;
  RandomStream random(1, "mishaps of " + GetParam().name);
  for (const fs::path& file : CorpusOf(GetParam().name)) {
    const std::string bytes = BytesIn(file);
    for (int i = 0; i < kMishaps; ++i) {
      std::string worse = bytes;
      for (int k = random.Index(kAtOnce); k >= 0; --k) worse = Mishap(worse, random);
      ASSERT_NO_THROW(GetParam().read(worse)) << file << ", mishap " << i << ":\n" << worse.substr(0, 500);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Of, FuzzReplay, testing::ValuesIn(AllFuzzReaders()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace gaitcam
