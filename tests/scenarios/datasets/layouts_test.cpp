// What is recorded in each layout, read by a program that knows nothing of ours.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "algorithms/io/dataset_layout.h"
#include "algorithms/io/dataset_reader.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class Layouts : public testing::TestWithParam<DatasetFormat> {};

INSTANTIATE_TEST_SUITE_P(Format, Layouts,
                         testing::Values(DatasetFormat::kTum, DatasetFormat::kEuroc, DatasetFormat::kVslamlab),
                         [](const auto& info) { return ToString(info.param); });

/// 12 s: a clock that began at 0 would shuffle the film from the tenth second on.
TEST_P(Layouts, AStrangersReaderFindsEveryFrameInItsPlace) {
  const TemporaryFolder temporary;
  temporary.Write("walk.yaml", kTinyWalk);
  const std::string record =
      "record walk.yaml --out data --set duration_s=12 --set camera.rate_hz=2 --set camera.width_px=64 "
      "--set camera.height_px=48 --set camera.stereo.baseline_m=0.06 --format " +
      ToString(GetParam());
  const ProgramResult recorded = RunProgram(record, temporary.path());
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const ProgramResult valid = RunProgram("validate data", temporary.path());
  EXPECT_EQ(valid.exit_code, 0) << valid.err;
  const ProgramResult read =
      RunShell("python3 " GAITCAM_SOURCE_DIR "/tests/scenarios/small_reader.py data/walk", temporary.path());
  EXPECT_EQ(read.exit_code, 0) << read.out << read.err;
  EXPECT_THAT(read.out, StartsWith("24 frames, 11.5"));
  DatasetReader reader(temporary.path() / "data");
  EXPECT_EQ(reader.format(), GetParam());
  EXPECT_EQ(reader.frames(), 24);
  EXPECT_THAT(ReadText(temporary.path() / "data/walk/about.txt"),
              AllOf(HasSubstr("dso_dataset files=DATASET/"), HasSubstr("settings/orbslam3.yaml (ORB-SLAM3)")));
}

}  // namespace
}  // namespace gaitcam
