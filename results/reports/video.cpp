#include "results/reports/video.h"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <system_error>
#include <thread>

#include "algorithms/core/bounded_queue.h"
#include "algorithms/core/errors.h"
#include "results/reports/film_encoder.h"

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
  if (frame.exposure_ms > 0) put(fmt::format("exposure {:g} ms", frame.exposure_ms), after_time + margin, kFaint);
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

/// Pictures are composed and encoded on a thread of their own, while the next ones are rendered.
struct VideoWriter::Implementation {
  std::filesystem::path path, temporary;
  VideoOptions options;
  std::optional<FilmEncoder> encoder;
  BoundedQueue<VideoFrame> queue{4};
  std::thread thread;
  std::exception_ptr failure;  ///< Of the thread, which has ended then.
  cv::Size size;
  int frames = 0;
  bool finished = false;

  /// The first frame decides the film's size.
  void Open(const VideoFrame& first) {
    size = ComposeVideoFrame(first, options.height_px).size();
    encoder.emplace(temporary, path.string(), size, options.frame_rate_hz);
    thread = std::thread([this] { Encode(); });
  }
  void Encode() {
    try {
      while (const std::optional<VideoFrame> frame = queue.Pop()) {
        const cv::Mat composed = ComposeVideoFrame(*frame, options.height_px);
        GAITCAM_ASSERT(composed.size() == size);
        encoder->Add(composed);
      }
    } catch (...) {
      failure = std::current_exception();
      queue.Close();
    }
  }
  void Join() {
    queue.Close();
    if (thread.joinable()) thread.join();
  }
  void Push(const VideoFrame& frame) {
    if (queue.Push(frame)) return;
    Join();
    std::rethrow_exception(failure);
  }
  void Discard() {
    Join();
    encoder.reset();
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
  if (implementation_ && implementation_->encoder) implementation_->Discard();
}

VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;

VideoWriter& VideoWriter::operator=(VideoWriter&& other) noexcept {
  std::swap(implementation_, other.implementation_);
  return *this;
}

void VideoWriter::Add(const VideoFrame& frame) {
  GAITCAM_ASSERT(!implementation_->finished);
  if (!implementation_->encoder) implementation_->Open(frame);
  implementation_->Push(frame);
  ++implementation_->frames;
}

void VideoWriter::Finish() {
  implementation_->finished = true;
  if (!implementation_->encoder) return;
  implementation_->Join();
  if (implementation_->failure) std::rethrow_exception(implementation_->failure);
  implementation_->encoder->Finish();
  implementation_->encoder.reset();
  std::error_code error;
  std::filesystem::rename(implementation_->temporary, implementation_->path, error);
  if (error) throw MissingResource(implementation_->path.string() + ": cannot be written: " + error.message());
}

int VideoWriter::frames() const { return implementation_->frames; }

}  // namespace gaitcam
