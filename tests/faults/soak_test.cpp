// Programs that work for long hold no more at the end than early on: memory, open files, processes, temporary files.
//
// GAITCAM_LONG_TESTS=1: also a walk of GAITCAM_SOAK_LAPS (69, two hours), and a study of GAITCAM_SOAK_RUNS (10,000)
// runs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "algorithms/io/dataset_files.h"
#include "scenarios/code/systems/process_list.h"
#include "tests/faults/inputs.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

/// Whether memory is looked at: sanitizers keep what was given back.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSeesMemory = false;
#else
constexpr bool kSeesMemory = true;
#endif

/// What a program holds at one moment.
struct Held {
  double memory_mb = 0;  ///< Its own.
  int descriptors = 0;   ///< Its own.
  int processes = 0;     ///< It and all that it started.
  int temporary = 0;     ///< Files in the folder for temporary files.
};

int CountIn(const fs::path& folder) {
  std::error_code ended;
  int count = 0;
  for (fs::recursive_directory_iterator item(folder, ended), end; item != end && !ended; item.increment(ended)) ++count;
  return count;
}

/// In the environment of all that a test starts: orphans are found by it.
std::string Mark() { return "GAITCAM_SOAK_OF=" + std::to_string(getpid()); }

Held LookAt(pid_t pid, const fs::path& temporary) {
  Held held;
  held.memory_mb = double(PrivateMemory_bytes(pid)) / 1e6;
  held.descriptors = CountIn("/proc/" + std::to_string(pid) + "/fd");
  held.processes = int(Family(pid, Mark()).size());
  held.temporary = CountIn(temporary);
  return held;
}

struct Soaked {
  int exit_code = -1;
  std::vector<Held> looks;  ///< At equal intervals, while it worked.
};

/// Runs the program, and looks at it until it ends.
Soaked Soak(const std::string& arguments, const fs::path& folder, std::chrono::milliseconds interval) {
  fs::create_directory(folder / "tmp");
  const pid_t child = StartProgram(folder, arguments, Mark(), "said.txt");
  Soaked soaked;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    const Held held = LookAt(child, folder / "tmp");
    if (held.descriptors > 0) soaked.looks.push_back(held);  // else it has just ended
    std::this_thread::sleep_for(interval);
  }
  soaked.exit_code = ExitCode(status);
  return soaked;
}

/// The median of each in one of four equal parts of the time.
Held InQuarter(const std::vector<Held>& looks, int quarter) {
  const size_t begin = looks.size() * size_t(quarter) / 4, end = looks.size() * size_t(quarter + 1) / 4;
  const auto median = [&](auto Held::*what) {
    std::vector<double> values;
    for (size_t i = begin; i < end; ++i) values.push_back(double(looks[i].*what));
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  return {median(&Held::memory_mb), int(median(&Held::descriptors)), int(median(&Held::processes)),
          int(median(&Held::temporary))};
}

/// That no more is open, running or lying about than was at some time before.
void ExpectCountsWithin(const Held& late, const std::vector<Held>& before) {
  const auto most = [&](int Held::*what) {
    int largest = 0;
    for (const Held& held : before) largest = std::max(largest, held.*what);
    return largest;
  };
  EXPECT_LE(late.descriptors, most(&Held::descriptors));
  EXPECT_LE(late.processes, most(&Held::processes));
  EXPECT_LE(late.temporary, most(&Held::temporary));
}

/// That the last quarter holds no more memory than the second, and no more of the others than the first half. @param
/// growth_mb of memory that is permitted
void ExpectFlat(const Soaked& soaked, double growth_mb) {
  ASSERT_GE(soaked.looks.size(), 20U) << "it ended too soon to tell";
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Held held = InQuarter(soaked.looks, quarter);
    std::printf("quarter %d: %.1f MB, %d descriptors, %d processes, %d temporary files\n", quarter + 1, held.memory_mb,
                held.descriptors, held.processes, held.temporary);
  }
  const Held late = InQuarter(soaked.looks, 3);
  if (kSeesMemory) {
    EXPECT_LE(late.memory_mb, InQuarter(soaked.looks, 1).memory_mb + growth_mb);
  }
  ExpectCountsWithin(late, {soaked.looks.begin(), soaked.looks.begin() + std::ptrdiff_t(soaked.looks.size() / 2)});
}

/// @param name of a variable of the environment; @param otherwise where it is not set
int Wanted(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// A walk round a circle of 4 m, filmed and tracked. @param more lines: how long, how many frames, by which system
Soaked SoakWalk(const fs::path& folder, const std::string& name, const std::string& more,
                std::chrono::milliseconds interval) {
  WriteText(folder / (name + ".yaml"), "robot: khr1hv\nscene: lab\nvideo: {enabled: false}\n" + more);
  const Soaked soaked = Soak("run " + name + ".yaml --out " + name, folder, interval);
  EXPECT_THAT(soaked.exit_code, testing::AnyOf(0, 3)) << ReadText(folder / "said.txt");
  return soaked;
}

TEST(SoakTest, AWalkSixTimesAsLongHoldsNoMore) {
  const TemporaryFolder folder;
  const auto walk = [&](const std::string& duration_s) {
    return SoakWalk(folder.path(), "walk_" + duration_s,
                    "duration_s: " + duration_s +
                        "\nsystem: orb_vo\npath: {kind: circle, diameter_m: 4, laps: 1}\n"
                        "camera: {width_px: 320, height_px: 240, rate_hz: 20, exposure_ms: 5, fixed_subframes: 1}\n",
                    std::chrono::milliseconds(20))
        .looks;
  };
  const std::vector<Held> brief = walk("2"), longer = walk("12");
  ASSERT_GE(std::min(brief.size(), longer.size()), 20U) << "they ended too soon to tell";
  const Held late = InQuarter(longer, 3), early = InQuarter(brief, 3);
  std::printf("2 s: %.1f MB, 12 s: %.1f MB\n", early.memory_mb, late.memory_mb);
  // 200 frames more: were one picture of each kept, as floats in colour, that would be 184 MB. Two walks of one length
  // differed by up to 38 MB.
  if (kSeesMemory) {
    EXPECT_LE(late.memory_mb, early.memory_mb + 90);
  }
  ExpectCountsWithin(late, brief);
}

TEST(SoakTest, AWalkOfHoursHoldsNoMoreAtItsEnd) {
  if (!IsLongPart()) GTEST_SKIP() << "set GAITCAM_LONG_TESTS=1: two hours of walk take an hour or more";
  const TemporaryFolder folder;
  const Soaked soaked = SoakWalk(folder.path(), "walk",
                                 "duration_s: 0\nsystem: sift_vo\npath: {kind: circle, diameter_m: 4, laps: " +
                                     std::to_string(Wanted("GAITCAM_SOAK_LAPS", 69)) +
                                     "}\ncamera: {width_px: 160, height_px: 120, rate_hz: 2, exposure_ms: 5, "
                                     "fixed_subframes: 1}\n",
                                 std::chrono::milliseconds(2000));
  // What is known of each frame stays in memory until it is scored, 3.6 kB of it: 26 MB in half of two hours, and as
  // much again while a vector grows.
  ExpectFlat(soaked, 60);
}

TEST(SoakTest, AStudyOfManyRunsHoldsNoMoreAtItsEnd) {
  const TemporaryFolder folder;
  WriteInputs(folder.path());
  const int runs = IsLongPart() ? Wanted("GAITCAM_SOAK_RUNS", 10000) : 8;
  folder.Write("many.yaml",
               "base: walk.yaml\nset: {duration_s: 0.4, scene: plain, camera.fixed_subframes: 1, score.min_pairs: 3}\n"
               "axes: {camera.exposure_ms: [2]}\nseeds: " +
                   std::to_string(runs) + "\nmetrics: [coverage_ratio]\n");
  const Soaked soaked = Soak("study many.yaml --out study --cache cache -j 2", folder.path(),
                             std::chrono::milliseconds(IsLongPart() ? 1000 : 40));
  EXPECT_EQ(soaked.exit_code, 0) << ReadText(folder.path() / "said.txt");
  ExpectFlat(soaked, 2e-3 * runs + 2);  // a line of scores stays of each run: 2 kB
  EXPECT_EQ(CountIn(folder.path() / "tmp"), 0);
  EXPECT_THAT(Marked(Mark()), testing::IsEmpty());
}

}  // namespace
}  // namespace gaitcam
