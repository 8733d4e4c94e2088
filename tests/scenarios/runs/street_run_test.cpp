// Places known by their looks, from a walk through the street to what a run says and leaves behind.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/data_folder.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(StreetRunTest, AWalkTwiceRoundPrintsRecallAndPrecisionAndDrawsItsMap) {
  const TemporaryFolder temporary;
  // A small round within one street, a view each second, few pixels: whether loops are found, not how well.
  const ProgramResult result = RunProgram(
      "run " + (TestData() / "scenarios/street_loops.yaml").string() +
          " --set scene=street_empty --set 'path.points=[[12, 0], [12, 3], [0, 3], [0, 0], [12, 0], [12, 3], "
          "[0, 3], [0, 0]]' --set path.corner_radius_m=1.2 --set camera.rate_hz=1 --set camera.width_px=240 "
          "--set camera.height_px=160 --set video.enabled=false --set system.name=pirf_nav "
          "--set system.robust=none --out run",
      temporary.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("loop_precision"));
  EXPECT_THAT(result.out, HasSubstr("loop_recall"));
  const fs::path run = temporary.path() / "run";
  const nlohmann::json scores = nlohmann::json::parse(ReadText(run / "scores.json"))["scores"];
  EXPECT_GT(scores["loop_returns"], 20);     // most of the views of a round of 22 s
  EXPECT_GT(scores["loop_recall"], 0.3);     // 0.62 when measured
  EXPECT_GT(scores["loop_precision"], 0.9);  // 1 when measured
  EXPECT_THAT(ReadText(run / "places.graphml"), HasSubstr("<edge"));
  EXPECT_THAT(ReadText(run / "report.html"), HasSubstr("<svg"));

  // What made a loop right is written down, and read again.
  EXPECT_EQ(RunProgram("validate " + (run / "scenario.yaml").string(), temporary.path()).exit_code, 0);
  EXPECT_THAT(ReadText(run / "scenario.yaml"), HasSubstr("same_place_m: 2.5"));
}

}  // namespace
}  // namespace gaitcam
