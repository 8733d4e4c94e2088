#include "scenarios/code/systems/process_list.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace gaitcam {
namespace {

// Two that begin and end some thousand processes a second: many end while they are looked at.
class ShortLives {
 public:
  ShortLives() {
    for (pid_t& parent : parents_) {
      parent = fork();
      if (parent == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (;;) {
          const pid_t child = fork();
          if (child == 0) _exit(0);
          if (child > 0) waitpid(child, nullptr, 0);
        }
      }
    }
  }
  ~ShortLives() {
    for (const pid_t parent : parents_) {
      kill(parent, SIGKILL);
      waitpid(parent, nullptr, 0);
    }
  }
  const std::vector<pid_t>& parents() const { return parents_; }

 private:
  std::vector<pid_t> parents_ = std::vector<pid_t>(2);
};

TEST(ProcessList, ProcessesMayEndWhileItLooks) {
  const ShortLives lives;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  int looks = 0;
  for (; std::chrono::steady_clock::now() < end; ++looks) {
    std::vector<pid_t> children;
    ASSERT_NO_THROW(children = Children()) << "look " << looks;
    ASSERT_NO_THROW(Family(getpid(), "no such mark")) << "look " << looks;
    for (const pid_t parent : lives.parents()) EXPECT_EQ(std::count(children.begin(), children.end(), parent), 1);
  }
  EXPECT_GT(looks, 10);
}

}  // namespace
}  // namespace gaitcam
