#include "scenarios/code/datasets/preview.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/io/image_file.h"
#include "results/reports/video.h"

namespace gaitcam {
namespace {

constexpr double kMaxHz = 15;
constexpr int kTiles = 12, kColumns = 3, kGap_px = 12, kCaption_px = 26, kTitle_px = 44;
constexpr int kArrowStep_px = 28;  // between arrows, px of the tile
const cv::Scalar kPaper(250, 250, 250), kLabelInk(40, 36, 32), kLabelFaint(120, 115, 110), kArrow(255, 240, 0);  // BGR

/// One frame, scaled to the common height of tiles.
cv::Mat ReadTile(const std::filesystem::path& file, double scale) {
  cv::Mat image = ReadImage(file, ""), tile;
  if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  cv::resize(image, tile, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return tile;
}

/// From where a point was at shutter open to where it was at the close, at its true length.
void DrawBlur(const cv::Mat& vectors, double scale, cv::Mat& tile) {
  const int step = std::max(1, int(std::lround(kArrowStep_px / scale)));
  for (int y = step / 2; y < vectors.rows; y += step) {
    for (int x = step / 2; x < vectors.cols; x += step) {
      const auto& v = vectors.at<cv::Vec2f>(y, x);
      if (std::isnan(v[0])) continue;
      const cv::Point2d middle((x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5),
          half(v[0] * scale / 2, v[1] * scale / 2);
      const double length = 2 * std::hypot(half.x, half.y);
      if (length < 1) {
        cv::circle(tile, middle, 1, kArrow, -1, cv::LINE_AA);
      } else {
        cv::arrowedLine(tile, middle - half, middle + half, kArrow, 1, cv::LINE_AA, 0, std::min(0.4, 4 / length));
      }
    }
  }
}

void Write(cv::Mat& sheet, const std::string& text, int x, int baseline, double size, const cv::Scalar& colour) {
  cv::putText(sheet, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

/// The blurred frame, and beside it the sharp one with arrows if there is one.
cv::Mat DrawFrame(const RecordedFrame& frame, double scale) {
  const cv::Mat blurred = ReadTile(frame.image, scale);
  if (frame.sharp.empty()) return blurred;
  cv::Mat sharp = ReadTile(frame.sharp, scale), both;
  if (!frame.blur.empty()) DrawBlur(ReadVectorsPng(frame.blur, ""), scale, sharp);
  cv::hconcat(blurred, sharp, both);
  return both;
}

double SecondsIntoFilm(const RecordedWalk& walk, const RecordedFrame& frame) {
  return double(frame.stamp_ns - walk.frames.front().stamp_ns) * 1e-9;
}

std::vector<size_t> EvenlySpread(size_t of, size_t count) {
  std::vector<size_t> chosen;
  for (size_t i = 0; i < std::min(of, count); ++i)
    chosen.push_back(of <= count ? i : size_t(std::llround(double(i) * double(of - 1) / double(count - 1))));
  return chosen;
}

}  // namespace

void WritePreview(const RecordedWalk& walk, const std::filesystem::path& file) {
  const double rate_hz = walk.calibration.frame_rate_hz;
  const int stride = std::max(1, int(std::ceil(rate_hz / kMaxHz)));
  VideoWriter film(file, {rate_hz / stride, std::min(360, std::max(120, walk.calibration.camera.height_px))});
  for (size_t i = 0; i < walk.frames.size(); i += size_t(stride)) {
    const RecordedFrame& frame = walk.frames[i];
    VideoFrame picture;
    picture.camera = ReadImage(frame.image, "");
    if (!frame.sharp.empty()) picture.bystander = ReadImage(frame.sharp, "");
    picture.time_s = SecondsIntoFilm(walk, frame);
    picture.exposure_ms = frame.exposure_ms;
    picture.status = fmt::format("blur {:.1f} px", frame.blur_median_px);
    film.Add(picture);
  }
  film.Finish();
}

void WriteContactSheet(const RecordedWalk& walk, const std::string& title, const std::filesystem::path& file) {
  const std::vector<size_t> chosen = EvenlySpread(walk.frames.size(), kTiles);
  if (chosen.empty()) throw BadInput(walk.folders.sensors.string() + ": has no frame to show");
  const double scale = 240.0 / walk.calibration.camera.height_px;
  const cv::Size tile = DrawFrame(walk.frames[0], scale).size();
  const int columns = std::min(kColumns, int(chosen.size())), rows = (int(chosen.size()) + columns - 1) / columns;
  const int cell_width = tile.width + kGap_px, cell_height = tile.height + kCaption_px + kGap_px;
  cv::Mat sheet(kTitle_px + rows * cell_height, kGap_px + columns * cell_width, CV_8UC3, kPaper);
  Write(sheet, title, kGap_px, 28, 0.6, kLabelInk);
  for (size_t i = 0; i < chosen.size(); ++i) {
    const RecordedFrame& frame = walk.frames[chosen[i]];
    const int x = kGap_px + int(i) % columns * cell_width, y = kTitle_px + int(i) / columns * cell_height;
    Write(sheet,
          fmt::format("{:.2f} s   blur {:.1f} px (90 %: {:.1f}, most {:.1f})", SecondsIntoFilm(walk, frame),
                      frame.blur_median_px, frame.blur_p90_px, frame.blur_max_px),
          x, y + 17, 0.45, kLabelFaint);
    DrawFrame(frame, scale).copyTo(sheet(cv::Rect(x, y + kCaption_px, tile.width, tile.height)));
  }
  WritePng(file, sheet, 6);
}

}  // namespace gaitcam
