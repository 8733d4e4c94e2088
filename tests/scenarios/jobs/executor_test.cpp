// Runs in processes of their own, and the cache of recorded walks that they share: real walks, real processes.

#include "scenarios/code/jobs/executor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "algorithms/core/errors.h"
#include "scenarios/code/runs/cache_entry.h"
#include "sim/camera/egl_context.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ExecutorTest : public testing::Test {
 protected:
  ExecutorTest() {
    setenv("GAITCAM_DATA", TestData().c_str(), 1);
    options_.runs = temporary_.path() / "runs";
    options_.cache.folder = temporary_.path() / "cache";
    options_.program = Program();
    options_.quiet = true;
  }

  ResolvedScenario Scenario(const std::string& more) {
    std::ofstream(temporary_.path() / "s.yaml")
        << "scene: plain\nduration_s: 2\npath: {kind: circle, diameter_m: 4}\n"
           "score: {min_coverage_ratio: 0, min_pairs: 3}\n"
           "camera: {exposure_ms: 0, rate_hz: 10, width_px: 160, height_px: 120}\nsystem: orb_vo\n"
        << more;
    return ReadScenario(temporary_.path() / "s.yaml", {});
  }
  WorkItem Item(const std::string& more) { return WorkItemOf(Scenario(more), "", options_.program); }
  std::optional<JobRecord> Find(const WorkItem& item) { return FindJob(options_.runs, item.hash, item.programs); }
  int CachedSequences() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(options_.cache.folder)) count += entry.is_directory() ? 1 : 0;
    return count;
  }

  const TemporaryFolder temporary_;
  ExecutorOptions options_;
};

TEST_F(ExecutorTest, RunsOfTheSameFramesShareOneRenderingAndFinishedOnesAreReused) {
  const std::vector<WorkItem> items{Item("seed: 1\n"), Item("seed: 1\nsystem_seed: 7\n"), Item("seed: 2\n")};
  ExecutorOutcome outcome = ExecuteLocally(items, options_);
  EXPECT_EQ(outcome.done, 3);
  EXPECT_THAT(outcome.failures, testing::IsEmpty());
  EXPECT_EQ(CachedSequences(), 2);
  for (const WorkItem& item : items) {
    const std::optional<JobRecord> record = Find(item);
    ASSERT_TRUE(record.has_value());
    EXPECT_EQ(record->status, "finished");
    EXPECT_EQ(record->frames, 20);
    EXPECT_TRUE(record->scores.count("coverage_ratio"));
  }
  outcome = ExecuteLocally(items, options_);
  EXPECT_EQ(outcome.reused, 3);
  EXPECT_EQ(outcome.done, 0);
  EXPECT_FALSE(FindJob(options_.runs, items[0].hash, "another program").has_value());
}

// What a film from the cache gives must be what the simulation gives while it walks, to the byte.
TEST_F(ExecutorTest, ARunFromTheCacheEqualsARunFromTheSimulation) {
  const WorkItem item = Item("seed: 3\n");
  ASSERT_EQ(ExecuteLocally({item}, options_).done, 1);
  const ProgramResult result = RunProgram("run s.yaml --out direct -q", temporary_.path());
  ASSERT_THAT(result.exit_code, testing::AnyOf(0, 3)) << result.err;
  for (const char* name : {"estimate.txt", "truth.txt"}) {
    EXPECT_EQ(ReadText(options_.runs / item.hash / name), ReadText(temporary_.path() / "direct" / name)) << name;
  }
}

TEST_F(ExecutorTest, ARunThatCannotBeIsAFailureWithItsReasonAndTheOthersGoOn) {
  const WorkItem impossible = Item("gait: {step_length_m: 0.9}\n"), good = Item("seed: 4\n");
  const ExecutorOutcome outcome = ExecuteLocally({impossible, good}, options_);
  EXPECT_EQ(outcome.done, 1);
  ASSERT_EQ(outcome.failures.size(), 1U);
  EXPECT_THAT(outcome.failures.at(impossible.hash), HasSubstr("step_length_m"));
  EXPECT_FALSE(Find(impossible).has_value());
  EXPECT_TRUE(Find(good).has_value());
}

TEST_F(ExecutorTest, AnInterruptLeavesNothingHalfWritten) {
  int asked = 0;
  options_.interrupted = [&asked] { return ++asked > 10; };  // some 0.05 s: within the first recording
  const ExecutorOutcome outcome = ExecuteLocally({Item("seed: 5\n"), Item("seed: 6\n")}, options_);
  EXPECT_TRUE(outcome.interrupted);
  for (const auto& entry : fs::directory_iterator(options_.runs)) {
    EXPECT_THAT(entry.path().filename().string(), testing::AnyOf("plan", "log", "lock"));
  }
  options_.interrupted = [] { return false; };
  EXPECT_EQ(ExecuteLocally({Item("seed: 5\n")}, options_).done, 1);
}

uintmax_t BytesBelow(const fs::path& folder) {
  uintmax_t sum = 0;
  for (const auto& e : fs::recursive_directory_iterator(folder)) sum += e.is_regular_file() ? e.file_size() : 0;
  return sum;
}

TEST_F(ExecutorTest, TheCacheForgetsWhatWasUsedLongestAgoWhenItIsFull) {
  const auto never = [] { return false; };
  const SequenceCache large(options_.cache);
  const fs::path first = large.Get(Scenario("seed: 1\n"), true, never)->folders.sensors;
  const fs::path second = large.Get(Scenario("seed: 2\n"), true, never)->folders.sensors;
  EXPECT_TRUE(large.Get(Scenario("seed: 1\n"), true, never)->was_there);  // the second is the older one now
  SequenceCacheOptions small = options_.cache;
  const uintmax_t bytes = BytesBelow(first.parent_path());
  small.max_gb = 1.5e-9 * double(bytes);
  EXPECT_FALSE(SequenceCache(small).Get(Scenario("seed: 3\n"), true, never)->was_there);
  EXPECT_TRUE(fs::exists(first));
  EXPECT_FALSE(fs::exists(second));
}

/// A study of thousands of walks did little else than look at the files of those that were there.
TEST_F(ExecutorTest, WhatAnEntryOfTheCacheTakesIsNotedInItOnce) {
  const auto never = [] { return false; };
  const fs::path entry =
      SequenceCache(options_.cache).Get(Scenario("seed: 1\n"), true, never)->folders.sensors.parent_path();
  const uintmax_t about_and_note = fs::file_size(entry / kCacheEntryAbout) + fs::file_size(entry / "bytes");
  EXPECT_EQ(CacheEntrySize(entry), BytesBelow(entry) - about_and_note);
  std::ofstream(entry / "more") << std::string(1000, ' ');
  EXPECT_EQ(CacheEntrySize(entry), BytesBelow(entry) - about_and_note - 1000) << "files are not looked at again";
  std::ofstream(entry / "bytes") << "none";
  EXPECT_EQ(CacheEntrySize(entry), BytesBelow(entry)) << "nor was there a note in those of older programs";
}

TEST_F(ExecutorTest, HowARendererWasChosenIsNoReasonToRenderAgain) {
  const auto never = [] { return false; };
  const SequenceCache cache(options_.cache);
  Scenario("");
  const auto film = [&](const std::string& choice) {
    return cache.Get(ReadScenario(temporary_.path() / "s.yaml", {"camera.renderer=" + choice}), true, never);
  };
  const std::optional<CachedSequence> first = film("software");
  EXPECT_FALSE(first->was_there);
  EXPECT_TRUE(first->renderer.is_software);
  for (const EglDeviceReport& report : ListEglDevices()) {
    if (report.opengl.Key() != first->renderer.Key()) continue;
    EXPECT_TRUE(film("device:" + std::to_string(report.device.index))->was_there) << report.ToText();
  }
  film("auto");
  EXPECT_EQ(CachedSequences(), RendererKey({}) == first->renderer.Key() ? 1 : 2);
}

TEST_F(ExecutorTest, ASequenceInUseIsNotRemoved) {
  const auto never = [] { return false; };
  const std::optional<CachedSequence> held = SequenceCache(options_.cache).Get(Scenario("seed: 1\n"), true, never);
  SequenceCacheOptions none = options_.cache;
  none.max_gb = 1e-9;
  SequenceCache(none).Get(Scenario("seed: 2\n"), true, never);
  EXPECT_TRUE(fs::exists(held->folders.sensors));
}

}  // namespace
}  // namespace gaitcam
