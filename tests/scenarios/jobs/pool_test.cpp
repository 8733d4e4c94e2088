// The pool of processes, on small shell commands.

#include "scenarios/code/jobs/pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <thread>

#include "algorithms/core/errors.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using Kind = TaskEnd::Kind;
using testing::ElementsAre;
using testing::HasSubstr;

class PoolTest : public testing::Test {
 protected:
  PoolTest() {
    options_.on_start = [this](const PoolTask& task) {
      started_.push_back(task.name);
      at_once_ = std::max(at_once_, started_.size() - ends_.size());
    };
    options_.on_end = [this](const PoolTask& task, const TaskEnd& end) { ends_[task.name] = end; };
  }

  PoolTask Shell(const std::string& name, const std::string& script, const std::string& resource = "") const {
    return {name, {"sh", "-c", script}, temporary_.path() / (name + ".log"), resource};
  }

  const TemporaryFolder temporary_;
  PoolOptions options_;
  std::vector<std::string> started_;
  std::map<std::string, TaskEnd> ends_;
  size_t at_once_ = 0;
};

TEST_F(PoolTest, StartsInOrderNeverMoreThanAllowedAndKeepsEachLog) {
  options_.at_once = 2;
  std::vector<PoolTask> tasks;
  for (const char* name : {"a", "b", "c", "d", "e"}) tasks.push_back(Shell(name, std::string("echo I am ") + name));
  EXPECT_TRUE(RunPool(tasks, options_));
  EXPECT_THAT(started_, ElementsAre("a", "b", "c", "d", "e"));
  EXPECT_EQ(at_once_, 2U);
  for (const PoolTask& task : tasks) {
    EXPECT_EQ(ends_.at(task.name).kind, Kind::kDone);
    EXPECT_EQ(ReadText(task.log), "I am " + task.name + "\n");
  }
}

TEST_F(PoolTest, TasksSideBySideShareTheCoresUnlessTheEnvironmentSaysOtherwise) {
  const std::string show = "echo ${LP_NUM_THREADS-none} ${OPENCV_FOR_THREADS_NUM-none}";
  unsetenv("LP_NUM_THREADS");
  setenv("OPENCV_FOR_THREADS_NUM", "5", 1);
  options_.at_once = int(std::max(2U, std::thread::hardware_concurrency()));  // a core for each
  std::vector<PoolTask> tasks;
  for (int i = 0; i < options_.at_once; ++i) tasks.push_back(Shell(std::to_string(i), show));
  EXPECT_TRUE(RunPool(tasks, options_));
  if (std::thread::hardware_concurrency() > 1) {
    EXPECT_EQ(ReadText(tasks.back().log), "0 5\n");
  }
  options_.at_once = 1;
  EXPECT_TRUE(RunPool({Shell("alone", show)}, options_));
  EXPECT_EQ(ReadText(Shell("alone", show).log), "none 5\n");
  unsetenv("OPENCV_FOR_THREADS_NUM");
}

TEST_F(PoolTest, AFailureIsTheLastLineOfTheLogAndADeathIsTheSignal) {
  EXPECT_TRUE(RunPool({Shell("bad", "echo first; echo gaitcam: no such robot >&2; exit 2"), Shell("mute", "exit 3"),
                       Shell("dead", "echo busy; kill -9 $$"), Shell("good", "true")},
                      options_));
  EXPECT_EQ(ends_.at("bad").kind, Kind::kFailed);
  EXPECT_EQ(ends_.at("bad").reason, "no such robot");
  EXPECT_EQ(ends_.at("mute").reason, "the process exited with 3");
  EXPECT_THAT(ends_.at("dead").reason, HasSubstr("signal 9"));
  EXPECT_EQ(ends_.at("good").kind, Kind::kDone);
}

TEST_F(PoolTest, WhatTheMachineLacksStopsThePoolAndKillsWhatRuns) {
  options_.at_once = 2;
  try {
    RunPool({Shell("long", "sleep 60"), Shell("lacks", "echo gaitcam: no EGL device; exit 4"), Shell("later", "true")},
            options_);
    FAIL() << "nothing was thrown";
  } catch (const MissingResource& e) {
    EXPECT_STREQ(e.what(), "no EGL device");
  }
  EXPECT_EQ(ends_.at("long").kind, Kind::kKilled);
  EXPECT_EQ(ends_.count("later"), 0U);
}

TEST_F(PoolTest, AnInterruptKillsWhatRunsAndStartsNothingElse) {
  options_.at_once = 1;
  int asked = 0;
  options_.interrupted = [&asked] { return ++asked > 10; };
  const PoolTask first = Shell("first", "sleep 60; echo woke up");
  EXPECT_FALSE(RunPool({first, Shell("second", "true")}, options_));
  EXPECT_THAT(started_, ElementsAre("first"));
  EXPECT_EQ(ends_.at("first").kind, Kind::kKilled);
  EXPECT_EQ(ReadText(first.log), "");
}

// The first task of a resource makes it; if it fails, the next one tries; the others run beside each other.
TEST_F(PoolTest, TasksOfOneResourceWaitUntilOneOfThemHasSucceeded) {
  options_.at_once = 4;
  const std::string made = (temporary_.path() / "made").string();
  const auto use = [&](const std::string& name) { return Shell(name, "test -e " + made, "film"); };
  EXPECT_TRUE(RunPool({Shell("fails", "sleep 0.2; exit 1", "film"), Shell("makes", "sleep 0.2; touch " + made, "film"),
                       use("uses"), use("uses_too"), Shell("other", "true")},
                      options_));
  EXPECT_THAT(started_, ElementsAre("fails", "other", "makes", "uses", "uses_too"));
  EXPECT_EQ(ends_.at("fails").kind, Kind::kFailed);
  for (const char* name : {"makes", "uses", "uses_too", "other"}) EXPECT_EQ(ends_.at(name).kind, Kind::kDone) << name;
}

}  // namespace
}  // namespace gaitcam
