#include "results/reports/video.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <system_error>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

const cv::Scalar kBar(30, 26, 24), kText(235, 232, 230), kFaint(165, 158, 152), kAlarm(86, 112, 255);  // BGR

int Even(int size) { return (size + 1) / 2 * 2; }

/// A view in colour at the given height and an even width.
cv::Mat Fit(const cv::Mat& view, int height_px) {
  cv::Mat colour, fitted;
  if (view.channels() == 1) {
    cv::cvtColor(view, colour, cv::COLOR_GRAY2BGR);
  } else {
    colour = view;
  }
  const int width_px = Even(int(std::lround(double(view.cols) * height_px / view.rows)));
  cv::resize(colour, fitted, {width_px, height_px}, 0, 0, height_px < view.rows ? cv::INTER_AREA : cv::INTER_CUBIC);
  return fitted;
}

void DrawCaption(const VideoFrame& frame, cv::Mat bar) {
  bar.setTo(kBar);
  const double size = bar.rows / 56.0;
  const int baseline = int(bar.rows * 0.66), margin = bar.rows / 3;
  const auto put = [&](const std::string& text, int x, const cv::Scalar& colour) {
    cv::putText(bar, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
    return x + cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width;
  };
  const int after_time = put(fmt::format("{:7.2f} s", frame.time_s), margin, kText);
  put(fmt::format("exposure {:g} ms", frame.exposure_ms), after_time + margin, kFaint);
  const int width = cv::getTextSize(frame.status, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width;
  put(frame.status, bar.cols - margin - width, frame.alarm ? kAlarm : kText);
}

}  // namespace

cv::Mat ComposeVideoFrame(const VideoFrame& frame, int height_px) {
  GAITCAM_ASSERT(!frame.camera.empty());
  const int height = Even(height_px), gap = 2;
  const cv::Mat camera = Fit(frame.camera, height);
  const cv::Mat bystander = frame.bystander.empty() ? cv::Mat() : Fit(frame.bystander, height);
  const int width = camera.cols + (bystander.empty() ? 0 : gap + bystander.cols);
  const int bar_height = Even(height / 12);
  cv::Mat canvas(height + bar_height, width, CV_8UC3, kBar);
  camera.copyTo(canvas(cv::Rect(0, 0, camera.cols, height)));
  if (!bystander.empty()) bystander.copyTo(canvas(cv::Rect(camera.cols + gap, 0, bystander.cols, height)));
  DrawCaption(frame, canvas.rowRange(height, canvas.rows));
  return canvas;
}

struct VideoWriter::Implementation {
  std::filesystem::path path, temporary;
  VideoOptions options;
  cv::VideoWriter writer;
  cv::Size size;
  int frames = 0;
  bool finished = false;

  void Open(const cv::Size& new_size) {
    size = new_size;
    const int fourcc = cv::VideoWriter::fourcc('a', 'v', 'c', '1');
    bool opened = false;
    try {
      opened = writer.open(temporary.string(), cv::CAP_FFMPEG, fourcc, options.frame_rate_hz, size, true);
    } catch (const cv::Exception&) {  // told below in our own words
    }
    if (opened) return;
    throw MissingResource(fmt::format(
        "{}: cannot write an H.264 film; the folder must be writable, and OpenCV needs FFmpeg with libx264 (Debian: "
        "libopencv-videoio406, libavcodec59)",
        path.string()));
  }
  void Discard() {
    writer.release();
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
  }
};

VideoWriter::VideoWriter(std::filesystem::path path, VideoOptions options) {
  if (!(options.frame_rate_hz > 0 && options.frame_rate_hz <= 1000)) {
    throw BadInput(
        fmt::format("video: frame_rate_hz {:g} is not permitted; expected a number greater than 0 and at most 1000",
                    options.frame_rate_hz));
  }
  if (options.height_px < 64 || options.height_px > 4320) {
    throw BadInput(
        fmt::format("video: height_px {} is not permitted; expected a number from 64 to 4320", options.height_px));
  }
  implementation_ = std::make_unique<Implementation>();
  implementation_->temporary = path.parent_path() / ("." + path.stem().string() + ".partial.mp4");
  implementation_->path = std::move(path);
  implementation_->options = options;
}

VideoWriter::~VideoWriter() {
  if (implementation_ && implementation_->writer.isOpened()) implementation_->Discard();
}

VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;

VideoWriter& VideoWriter::operator=(VideoWriter&& other) noexcept {
  std::swap(implementation_, other.implementation_);
  return *this;
}

void VideoWriter::Add(const VideoFrame& frame) {
  GAITCAM_ASSERT(!implementation_->finished);
  const cv::Mat composed = ComposeVideoFrame(frame, implementation_->options.height_px);
  if (!implementation_->writer.isOpened()) implementation_->Open(composed.size());
  GAITCAM_ASSERT(composed.size() == implementation_->size);
  implementation_->writer.write(composed);
  ++implementation_->frames;
}

void VideoWriter::Finish() {
  implementation_->finished = true;
  if (!implementation_->writer.isOpened()) return;
  implementation_->writer.release();
  std::error_code error;
  std::filesystem::rename(implementation_->temporary, implementation_->path, error);
  if (error) throw MissingResource(implementation_->path.string() + ": cannot be written: " + error.message());
}

int VideoWriter::frames() const { return implementation_->frames; }

}  // namespace gaitcam
