#include "scenarios/code/experiments/loop_groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gaitcam {
namespace {

using testing::HasSubstr;

LoopOutcome Walk(const std::string& people, const std::string& exposure_ms, int accepted, int right) {
  LoopOutcome outcome;
  outcome.walk = "walk";
  outcome.method = "method";
  outcome.accepted = accepted;
  outcome.right = right;
  outcome.curve.possible = 10;
  outcome.levels = {people, exposure_ms};
  return outcome;
}

const std::vector<std::string> kKeys{"people", "ms"};

TEST(LoopGroups, AWalkWithoutAnAcceptedLoopHasARecallAndNoPrecision) {
  const std::string table =
      LoopGroupTable(kKeys, {Walk("40", "1", 4, 2), Walk("40", "1", 0, 0), Walk("40", "1", 8, 8)});
  EXPECT_THAT(table, HasSubstr("| method | 3 | 75.0 (50.0 to 100.0) | 20.0 (0.0 to 80.0) |"));
  EXPECT_THAT(LoopGroupTable(kKeys, {Walk("40", "1", 0, 0)}), HasSubstr("| method | 1 | - | 0.0 (0.0 to 0.0) |"));
}

TEST(LoopGroups, RowsGoByTheSizeOfNumbersAndNotByTheirLetters) {
  const std::string table =
      LoopGroupTable(kKeys, {Walk("100", "1", 1, 1), Walk("20", "33", 1, 1), Walk("20", "5", 1, 1)});
  const size_t first = table.find("| 20 | 5 |"), second = table.find("| 20 | 33 |"), last = table.find("| 100 | 1 |");
  ASSERT_NE(last, std::string::npos);
  EXPECT_LT(first, second);
  EXPECT_LT(second, last);
}

TEST(LoopGroups, ThePictureShowsWhatIsRecalled) {
  const auto draw = [](int right) {
    return DrawLoopGroups(kKeys, {Walk("0", "1", 10, right), Walk("40", "1", 10, 5)});
  };
  EXPECT_EQ(cv::norm(draw(5), draw(5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(draw(5), draw(9), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gaitcam
