#include "results/reports/video.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <opencv2/videoio.hpp>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

class Video : public testing::Test {
 protected:
  size_t FilesInFolder() const {
    return size_t(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
  }

  const TemporaryFolder folder_;
};

/// Camera blue, bystander red; brightness tells the frame.
VideoFrame Frame(int index) {
  VideoFrame frame;
  frame.camera = cv::Mat(240, 320, CV_8UC3, cv::Scalar(100 + 5 * index, 0, 0));
  frame.bystander = cv::Mat(480, 640, CV_8UC3, cv::Scalar(0, 0, 100 + 5 * index));
  frame.time_s = index / 30.0;
  frame.exposure_ms = 20;
  frame.status = "tracking";
  return frame;
}

TEST_F(Video, ReadsBackAsItWasWritten) {
  const fs::path path = folder_.path() / "walk.mp4";
  VideoWriter writer(path, {.frame_rate_hz = 25, .height_px = 180});
  for (int i = 0; i < 20; ++i) writer.Add(Frame(i));
  writer.Finish();
  EXPECT_EQ(writer.frames(), 20);
  EXPECT_EQ(FilesInFolder(), 1u);

  cv::VideoCapture film(path.string());
  ASSERT_TRUE(film.isOpened());
  EXPECT_EQ(int(film.get(cv::CAP_PROP_FRAME_COUNT)), 20);
  EXPECT_NEAR(film.get(cv::CAP_PROP_FPS), 25, 1e-6);
  EXPECT_EQ(int(film.get(cv::CAP_PROP_FOURCC)), cv::VideoWriter::fourcc('a', 'v', 'c', '1'));
  cv::Mat picture;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(film.read(picture));
    ASSERT_EQ(picture.cols % 2, 0);
    ASSERT_EQ(picture.rows % 2, 0);
    // 12: limited range, chroma at half resolution and a lossy code move flat colours by some levels, frames differ
    // by 5.
    EXPECT_NEAR(picture.at<cv::Vec3b>(90, 120)[0], 100 + 5 * i, 12);
    EXPECT_NEAR(picture.at<cv::Vec3b>(90, 360)[2], 100 + 5 * i, 12);
  }
}

TEST_F(Video, TheSamePicturesGiveTheSameBytes) {
  cv::RNG random(1);
  cv::Mat noise(240, 320, CV_8UC3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  std::vector<std::string> films;
  for (const char* name : {"a.mp4", "b.mp4"}) {
    VideoWriter writer(folder_.path() / name);
    for (int i = 0; i < 60; ++i) {
      VideoFrame frame = Frame(i % 20);
      frame.camera = cv::Mat(noise.size(), CV_8UC3);
      for (int row = 0; row < noise.rows; ++row) noise.row((row + 3 * i) % noise.rows).copyTo(frame.camera.row(row));
      writer.Add(frame);
    }
    writer.Finish();
    films.push_back(ReadText(folder_.path() / name));
  }
  EXPECT_GT(films[0].size(), 10000u);
  EXPECT_TRUE(films[0] == films[1]);
}

TEST_F(Video, HasNoFileUntilItIsFinished) {
  const fs::path path = folder_.path() / "walk.mp4";
  {
    VideoWriter writer(path);
    writer.Add(Frame(0));
    EXPECT_FALSE(fs::exists(path));
  }
  EXPECT_EQ(FilesInFolder(), 0u);  // given up: nothing is left behind
}

TEST_F(Video, WithoutFramesIsNoFileAndNoError) {
  VideoWriter writer(folder_.path() / "walk.mp4");
  EXPECT_NO_THROW(writer.Finish());
  EXPECT_EQ(FilesInFolder(), 0u);
}

TEST_F(Video, AFolderThatIsNotThereIsAMissingResource) {
  VideoWriter writer(folder_.path() / "nowhere" / "walk.mp4");
  try {
    writer.Add(Frame(0));
    FAIL();
  } catch (const MissingResource& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("nowhere/walk.mp4"));
  }
}

TEST_F(Video, AFullDiskIsSaidWithItsReasonAndNothingStays) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto on_signal = std::signal(SIGXFSZ, SIG_IGN);  // the write fails instead, as on a full disk
  const rlimit limited{64, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  std::string said;
  try {
    VideoWriter writer(folder_.path() / "walk.mp4");
    for (int i = 0; i < 20; ++i) writer.Add(Frame(i));
    writer.Finish();
  } catch (const std::runtime_error& error) {
    said = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, on_signal);
  EXPECT_THAT(said, testing::HasSubstr("walk.mp4: cannot write this file: File too large"));
  EXPECT_EQ(FilesInFolder(), 0u);
}

TEST_F(Video, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(VideoWriter(folder_.path() / "a.mp4", {.frame_rate_hz = 0}), BadInput);
  EXPECT_THROW(VideoWriter(folder_.path() / "a.mp4", {.height_px = 10}), BadInput);
}

TEST(VideoFrame, ViewsStandSideBySideAboveTheCaption) {
  const cv::Mat picture = ComposeVideoFrame(Frame(0), 241);  // odd heights become even
  EXPECT_EQ(picture.cols % 2, 0);
  EXPECT_EQ(picture.rows % 2, 0);
  EXPECT_EQ(picture.at<cv::Vec3b>(120, 100), cv::Vec3b(100, 0, 0));
  EXPECT_EQ(picture.at<cv::Vec3b>(120, picture.cols - 100), cv::Vec3b(0, 0, 100));
  EXPECT_GT(picture.rows, 242);
}

TEST(VideoFrame, AGreyCameraAloneIsAPictureToo) {
  VideoFrame frame;
  frame.camera = cv::Mat(240, 320, CV_8UC1, cv::Scalar(77));
  const cv::Mat picture = ComposeVideoFrame(frame, 240);
  EXPECT_EQ(picture.type(), CV_8UC3);
  EXPECT_EQ(picture.cols, 320);
  EXPECT_EQ(picture.at<cv::Vec3b>(120, 160), cv::Vec3b(77, 77, 77));
}

TEST(VideoFrame, AnAlarmIsSeen) {
  VideoFrame calm = Frame(0), alarm = calm;
  alarm.alarm = true;
  EXPECT_GT(cv::norm(ComposeVideoFrame(calm, 240), ComposeVideoFrame(alarm, 240), cv::NORM_INF), 50);
}

}  // namespace
}  // namespace gaitcam
