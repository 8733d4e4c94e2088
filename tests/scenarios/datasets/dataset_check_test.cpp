// Each kind of damage that a data set can suffer is planted into a real recording, and must be told with its place.

#include "scenarios/code/datasets/dataset_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/checksum.h"
#include "scenarios/code/datasets/frame_pairs.h"
#include "scenarios/code/runs/output_folder.h"
#include "tests/scenarios/program.h"
#include "tests/scenarios/tiny_walk.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// Walks recorded once for all tests: an RGB-D one in TUM's layout with pairs, stereo ones in EuRoC's and VSLAM-LAB's.
const fs::path& Recorded(const std::string& format) {
  static const TemporaryFolder temporary;
  static std::map<std::string, fs::path> folders;
  fs::path& folder = folders[format];
  if (!folder.empty()) return folder;
  folder = temporary.path() / format;
  const std::string more = format == "tum" ? "camera.depth=true" : "camera.stereo.baseline_m=0.06";
  const RecordedWalk walk = ReadRecordedWalk(RecordTinyWalk(folder, format, {more}));
  PairOptions pairs;
  pairs.every = 10;
  WriteFramePairs(walk, pairs);
  return folder;
}

std::vector<std::string> Lines(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

void WriteLines(const fs::path& file, const std::vector<std::string>& lines) {
  std::ofstream stream(file);
  for (const std::string& line : lines) stream << line << "\n";
}

/// The text of one field of a row, replaced. Separators are ',' or ' '.
void SetField(const fs::path& file, size_t line, size_t field, const std::string& to) {
  std::vector<std::string> lines = Lines(file);
  std::string& row = lines.at(line - 1);
  const char separator = row.find(',') == std::string::npos ? ' ' : ',';
  size_t begin = 0;
  for (size_t i = 0; i < field; ++i) begin = row.find(separator, begin) + 1;
  row.replace(begin, std::min(row.find(separator, begin), row.size()) - begin, to);
  WriteLines(file, lines);
}

void Replace(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = ReadText(file);
  const size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << file << " has no " << from;
  std::ofstream(file, std::ios::binary) << text.replace(at, from.size(), to);
}

class DatasetCheck : public testing::Test {
 protected:
  /// A copy of a recording to be damaged.
  void Copy(const std::string& format) {
    fs::remove_all(out());
    fs::copy(Recorded(format), out(), fs::copy_options::recursive);
  }
  fs::path out() const { return temporary_.path() / "data"; }
  fs::path walk() const { return out() / "walk"; }
  fs::path truth() const { return out() / "walk-truth"; }
  fs::path Image(size_t number) const {  // counted from 1, by rgb.txt, which has three lines of comment
    const std::string row = Lines(walk() / "rgb.txt").at(number + 2);
    return walk() / row.substr(row.find(' ') + 1);
  }

  std::vector<std::string> Faults() const {
    std::vector<std::string> faults;
    for (const Problem& problem : CheckDataset(out()).problems) {
      std::string text = problem.ToText();
      for (size_t at; (at = text.find(temporary_.path().string() + "/")) != std::string::npos;)
        text.erase(at, temporary_.path().string().size() + 1);
      faults.push_back(text);
    }
    return faults;
  }
  void ExpectFault(const std::string& text) const { EXPECT_THAT(Faults(), Contains(HasSubstr(text))); }

  const TemporaryFolder temporary_;
};

TEST_F(DatasetCheck, WhatWasRecordedHasNoFault) {
  for (const std::string format : {"tum", "euroc", "vslamlab"}) {
    Copy(format);
    const DatasetReport report = CheckDataset(out());
    EXPECT_THAT(Faults(), IsEmpty()) << format;
    EXPECT_EQ(report.frames, 20);
    // Left, the other camera or depth, sharp, true depth, blur.
    EXPECT_EQ(report.images, 20 * 5);
    ASSERT_EQ(report.sequences.size(), 1u);
    ASSERT_TRUE(report.sequences[0].floor);
    // 160 px over 60 degrees: f = 138.564 px; depth in steps of 0.2 mm leaves 0.1 %.
    EXPECT_NEAR(report.sequences[0].floor->fx, 138.564, 0.14);
    EXPECT_NEAR(report.sequences[0].floor->fy, 138.564, 0.14);
    fs::remove_all(truth());  // a SLAM system's folder alone is a data set as well
    EXPECT_THAT(Faults(), IsEmpty()) << format;
  }
}

TEST_F(DatasetCheck, MissingImage) {
  Copy("tum");
  fs::remove(Image(5));
  ExpectFault("data/walk/rgb.txt:8: data/walk/rgb/1700000000.405000000.png: there is no such file");
}

TEST_F(DatasetCheck, TruncatedImage) {
  Copy("tum");
  fs::resize_file(Image(5), fs::file_size(Image(5)) * 2 / 3);
  ExpectFault("data/walk/rgb.txt:8: data/walk/rgb/1700000000.405000000.png: is cut off");
}

TEST_F(DatasetCheck, ImageOfAnotherSize) {
  Copy("tum");
  cv::imwrite(Image(3).string(), cv::imread(Image(3).string())(cv::Rect(0, 0, 80, 60)));
  ExpectFault("rgb.txt:6: data/walk/rgb/1700000000.205000000.png: has 80 x 60 pixels, the calibration says 160 x 120");
}

TEST_F(DatasetCheck, BlackImage) {
  Copy("tum");
  cv::imwrite(Image(3).string(), cv::Mat::zeros(120, 160, CV_8UC3));
  ExpectFault("rgb.txt:6: data/walk/rgb/1700000000.205000000.png: is all of one colour");
}

TEST_F(DatasetCheck, ImageInThePlaceOfAnother) {
  Copy("tum");
  fs::copy_file(Image(3), Image(15), fs::copy_options::overwrite_existing);
  ExpectFault("rgb.txt:18: data/walk/rgb/1700000001.405000000.png: holds the very pixels of 1700000000.205000000.png");
}

TEST_F(DatasetCheck, StampsInTheWrongOrder) {
  Copy("tum");
  std::vector<std::string> lines = Lines(walk() / "rgb.txt");
  std::swap(lines[9], lines[10]);
  WriteLines(walk() / "rgb.txt", lines);
  ExpectFault("rgb.txt:11: time 1700000000.605000000 s comes before that of the row above, 1700000000.705000000 s");
}

TEST_F(DatasetCheck, RowThatIsThereTwice) {
  Copy("tum");
  std::vector<std::string> lines = Lines(walk() / "rgb.txt");
  lines.insert(lines.begin() + 10, lines[9]);
  WriteLines(walk() / "rgb.txt", lines);
  ExpectFault("rgb.txt:11: time 1700000000.605000000 s is there twice");
  ExpectFault("rgb.txt:11: rgb/1700000000.605000000.png is listed twice");
}

TEST_F(DatasetCheck, RowThatIsMissing) {
  Copy("tum");
  std::vector<std::string> lines = Lines(walk() / "rgb.txt");
  lines.erase(lines.begin() + 10);
  WriteLines(walk() / "rgb.txt", lines);
  ExpectFault("data/walk/rgb/1700000000.705000000.png: is not listed in data/walk/rgb.txt");
  ExpectFault("times.txt: has 20 rows, rgb.txt has 19 frames");
  ExpectFault("walk-truth/frames.csv:9: walk has no frame at 1700000000.705000000 s");
}

TEST_F(DatasetCheck, QuaternionThatIsNoRotation) {
  Copy("tum");
  SetField(truth() / "groundtruth.txt", 6, 4, "0.9");
  ExpectFault("groundtruth.txt:6: the pose: its quaternion has length");
  Copy("euroc");
  SetField(truth() / "mav0/state_groundtruth_estimate0/data.csv", 4, 4, "0.1");
  ExpectFault("state_groundtruth_estimate0/data.csv:4: the pose: its quaternion has length");
}

TEST_F(DatasetCheck, PoseThatIsNoNumber) {
  Copy("tum");
  SetField(truth() / "groundtruth.txt", 6, 2, "nan");
  ExpectFault("groundtruth.txt:6: the pose: a part of its position is \"nan\", expected a finite number");
}

TEST_F(DatasetCheck, PoseOfAnotherPlace) {
  Copy("tum");
  SetField(truth() / "groundtruth.txt", 6, 2, "7.5");
  ExpectFault("groundtruth.txt:6: the pose is 9.");  // m from the one before it
}

TEST_F(DatasetCheck, PosesOfAnotherHeight) {
  Copy("tum");
  std::vector<std::string> lines = Lines(truth() / "groundtruth.txt");
  for (size_t i = 3; i < lines.size(); ++i) SetField(truth() / "groundtruth.txt", i + 1, 3, "0.33");
  ExpectFault("points of the floor, by true depth and pose, lie in the floor at");  // camera too high or f too short
  Copy("tum");
  SetField(truth() / "groundtruth.txt", 13, 3, "0.33");
  ExpectFault(
      "depth/1700000000.905000000.png: by depth and pose (groundtruth.txt, 1700000000.905000000 s) the floor is ");
}

TEST_F(DatasetCheck, RowOfTheTruthThatIsMissing) {
  Copy("tum");
  std::vector<std::string> lines = Lines(truth() / "groundtruth.txt");
  lines.erase(lines.begin() + 12);
  WriteLines(truth() / "groundtruth.txt", lines);
  ExpectFault("groundtruth.txt: has no row for the frame at 1700000000.905000000 s of walk");
}

/// Nothing but geometry can know: the scenario that says it as well is gone, and both cameras' rows agree.
TEST_F(DatasetCheck, FocalLengthThatIsOffByTwoPercentByTheFloor) {
  for (const auto& [key, wrong] : {std::pair{"fx", "fx: 141.3"}, std::pair{"fy", "fy: 135.8"}}) {
    Copy("tum");
    fs::remove_all(truth() / "pairs");
    fs::remove_all(truth() / "blur");
    fs::remove(truth() / "blur.txt");
    fs::remove(truth() / "scenario.yaml");
    Replace(walk() / "calibration.yaml", std::string(key) + ": 138.564", wrong + std::string(" #"));
    ExpectFault("data/walk/calibration.yaml: camera." + std::string(key) + " is");
    ExpectFault("points of the floor, by true depth and pose, lie in the floor at 138.");
  }
}

TEST_F(DatasetCheck, FocalLengthThatIsOffByTwoPercentByThePoints) {
  Copy("tum");
  Replace(walk() / "calibration.yaml", "fx: 138.564", "fx: 141.3 #");
  ExpectFault("points.csv:2: the point projects");
}

TEST_F(DatasetCheck, FocalLengthThatIsNotTheScenarios) {
  Copy("euroc");
  Replace(walk() / "calibration.yaml", "fx: 138.564", "fx: 141.3 #");
  ExpectFault("camera.fx is 141.3, but the camera of");
  ExpectFault("cam0/sensor.yaml: fx is 138.564, but calibration.yaml says 141.3");
}

TEST_F(DatasetCheck, CalibrationThatCannotBeRead) {
  Copy("tum");
  Replace(walk() / "calibration.yaml", "fy: ", "fy: -");
  ExpectFault("calibration.yaml");
}

TEST_F(DatasetCheck, DepthImageThatIsMissing) {
  Copy("tum");
  fs::remove(truth() / "depth" / "1700000000.405000000.png");
  ExpectFault("depth.txt:8: data/walk-truth/depth/1700000000.405000000.png: there is no such file");
  fs::remove(walk() / "depth" / "1700000000.505000000.png");
  ExpectFault("walk/depth.txt:9: data/walk/depth/1700000000.505000000.png: there is no such file");
  ExpectFault("associations.txt:6: depth/1700000000.505000000.png: there is no such file");
}

TEST_F(DatasetCheck, DepthOfAnotherFrame) {
  Copy("tum");
  fs::remove_all(truth() / "pairs");
  fs::copy_file(truth() / "depth" / "1700000000.005000000.png", truth() / "depth" / "1700000001.805000000.png",
                fs::copy_options::overwrite_existing);
  ExpectFault("blur/1700000001.805000000.png: its vectors");
}

TEST_F(DatasetCheck, RightImageThatIsMissing) {
  Copy("euroc");
  fs::remove(walk() / "mav0/cam1/data/1700000000405000000.png");
  ExpectFault("cam1/data.csv:6: data/walk/mav0/cam1/data/1700000000405000000.png: there is no such file");
}

TEST_F(DatasetCheck, ImuStampsThatRunBackwards) {
  for (const std::string format : {"tum", "euroc"}) {
    Copy(format);
    const fs::path file = walk() / (format == "tum" ? "imu.csv" : "mav0/imu0/data.csv");
    std::vector<std::string> lines = Lines(file);
    std::swap(lines[40], lines[41]);
    WriteLines(file, lines);
    ExpectFault(file.filename().string() + ":42: time 1700000000.156000000 s comes before that of the row above");
  }
}

TEST_F(DatasetCheck, ExposureThatCountsWrong) {
  Copy("tum");
  SetField(walk() / "exposure.csv", 5, 2, "31");
  ExpectFault("exposure.csv: says 483 IMU samples in all, but there are 477");
  ExpectFault("exposure.csv:5: says 31 IMU samples, the last of");
}

TEST_F(DatasetCheck, ExposureThatIsNotThatOfTimesTxt) {
  Copy("tum");
  SetField(walk() / "times.txt", 5, 2, "11");
  ExpectFault("times.txt:5: the exposure is 11 ms, in exposure.csv 10");
}

TEST_F(DatasetCheck, SampleThatIsNoNumber) {
  Copy("tum");
  SetField(walk() / "imu.csv", 12, 5, "inf");
  SetField(walk() / "joints.csv", 9, 6, "x");
  ExpectFault("imu.csv:12: a specific force is \"inf\", expected a finite number");
  ExpectFault("joints.csv:9: a joint's position is \"x\", expected a finite number");
}

TEST_F(DatasetCheck, BlurThatIsNotWhatThePosesImply) {
  Copy("tum");
  SetField(truth() / "frames.csv", 18, 8, "0.2");  // x at shutter close
  ExpectFault("its vectors");
  SetField(truth() / "frames.csv", 18, 15, "99");
  ExpectFault("frames.csv:18: blur of median 99, 90 %");
}

TEST_F(DatasetCheck, WeightsThatDoNotAddUp) {
  Copy("tum");
  SetField(truth() / "subposes.csv", 7, 2, "0.5");
  ExpectFault("subposes.csv: the weights of the frame at 1700000000.105000000 s add up to 1.");
}

TEST_F(DatasetCheck, HomographyOfAnotherPair) {
  Copy("tum");
  SetField(truth() / "pairs/000010_000013/H_floor.txt", 2, 0, "0.05");
  ExpectFault("pairs/000010_000013/H_floor.txt: maps the floor point of");
}

TEST_F(DatasetCheck, AllFaultsAreToldNotOnlyTheFirst) {
  Copy("tum");
  fs::remove(Image(5));
  fs::remove(Image(9));
  SetField(walk() / "imu.csv", 12, 5, "inf");
  SetField(truth() / "groundtruth.txt", 6, 2, "nan");
  for (const char* text : {"rgb.txt:8:", "rgb.txt:12:", "imu.csv:12:", "groundtruth.txt:6:"}) ExpectFault(text);
}

TEST_F(DatasetCheck, FoldersOfOthersAreHeldToTheirLayoutAlone) {
  Copy("euroc");
  fs::remove_all(truth());
  fs::rename(walk() / "mav0", out() / "mav0");
  fs::remove_all(walk());
  EXPECT_THAT(Faults(), IsEmpty());
  fs::remove(out() / "mav0/cam0/data/1700000000405000000.png");
  ExpectFault("data/mav0/cam0/data.csv:6: data/mav0/cam0/data/1700000000405000000.png: there is no such file");
}

TEST_F(DatasetCheck, TableWithoutTheLinesThatReadersSkip) {
  Copy("tum");
  std::vector<std::string> lines = Lines(walk() / "rgb.txt");
  lines.erase(lines.begin(), lines.begin() + 2);
  WriteLines(walk() / "rgb.txt", lines);
  ExpectFault("data/walk/rgb.txt: has 1 lines of comment at its top; expected 3, which readers of this layout skip");
  lines = Lines(walk() / "associations.txt");
  lines.insert(lines.begin(), "# time image time depth");
  WriteLines(walk() / "associations.txt", lines);
  ExpectFault("associations.txt: begins with a comment");
}

/// A clock that begins at 0 gives names of growing length.
TEST_F(DatasetCheck, NamesThatDoNotSortByTime) {
  Calibration calibration;
  calibration.camera = CameraModel::FromHorizontalFov(16, 12, 60);
  calibration.frame_rate_hz = 5;
  fs::create_directories(out());
  DatasetWriter writer(DatasetFolders::In(out(), "walk"), calibration, {});
  for (const int64_t stamp_ns : {9'900'000'000, 10'100'000'000}) {
    Observation seen;
    seen.stamp_ns = stamp_ns;
    seen.image = {stamp_ns, cv::Mat::eye(12, 16, CV_8UC1) * (stamp_ns % 251)};
    writer.Add(seen, {});
  }
  writer.Finish("finished");
  ExpectFault("walk/rgb.txt:5: 10.100000000.png is sorted before 9.900000000.png, which is earlier");
  ExpectFault("walk/rgb.txt:4: the clock begins at 9.900000000 s; expected an epoch of ten digits");
}

TEST_F(DatasetCheck, SettingsThatAreNotTheCalibrations) {
  Copy("tum");
  Replace(walk() / "settings/orbslam3.yaml", "Camera1.fx: 138.56", "Camera1.fx: 141.56");
  ExpectFault("data/walk/settings/orbslam3.yaml:5: says \"Camera1.fx: 141.56");
  fs::remove(walk() / "settings/dso_camera.txt");
  ExpectFault("data/walk/settings/dso_camera.txt: there is no such file");
  Copy("euroc");
  std::vector<std::string> lines = Lines(walk() / "settings/euroc_times.txt");
  lines.erase(lines.begin() + 4);
  WriteLines(walk() / "settings/euroc_times.txt", lines);
  ExpectFault("euroc_times.txt: has no row for the frame at 1700000000.405000000 s");
}

TEST_F(DatasetCheck, VslamlabTablesOfAnotherForm) {
  Copy("vslamlab");
  Replace(walk() / "calibration.yaml", "focal_length: [138.56", "focal_length: [141.56");
  ExpectFault("data/walk/calibration.yaml:9: says \"    focal_length: [141.56");
  fs::remove(walk() / "rgb_1/1700000000405000000.png");
  ExpectFault("data/walk/rgb.csv:6: data/walk/rgb_1/1700000000405000000.png: there is no such file");
  Replace(walk() / "rgb.csv", "path_rgb_1", "path_right");
  ExpectFault("data/walk/rgb.csv:1: names no column \"path_rgb_1\"");
  SetField(truth() / "groundtruth.csv", 4, 4, "0.9");
  ExpectFault("groundtruth.csv:4: the pose: its quaternion has length");
}

TEST_F(DatasetCheck, AFolderThatIsNoneIsSaid) {
  fs::create_directories(out());
  EXPECT_THROW(CheckDataset(out()), BadInput);
}

/// The program's own words: one line per fault on standard error, exit 2; a summary and exit 0 if there is none.
TEST_F(DatasetCheck, TheProgramListsFaultsAndExitsWithTwo) {
  Copy("tum");
  ProgramResult result = RunProgram("validate data", temporary_.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("data: no fault found; 1 sequence, 20 frames, 100 images read"));
  EXPECT_EQ(result.err, "");
  fs::remove(truth() / "sharp" / "1700000000.405000000.png");
  SetField(walk() / "times.txt", 5, 2, "11");
  result = RunProgram("validate data", temporary_.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr("data/walk/times.txt:5: the exposure is 11 ms"));
  result = RunProgram("validate data --json", temporary_.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, HasSubstr("\"line\": 8"));
}

}  // namespace
}  // namespace gaitcam
