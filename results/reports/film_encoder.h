/// H.264 in an MP4 file, by FFmpeg. The same pictures give the same bytes.

#pragma once

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

namespace gaitcam {

/// One thread, which is the caller's: x264 with several shares its bits out by who is done first, and runs as many as
/// the machine has cores.
class FilmEncoder {
 public:
  /// @param name of the file in what is thrown, as its reader knows it. @param size_px even in both directions.
  /// @throws MissingResource if this machine's FFmpeg has no x264, or the file cannot be written.
  FilmEncoder(const std::filesystem::path& file, const std::string& name, cv::Size size_px, double frame_rate_hz);
  /// Without Finish() the file is not playable.
  ~FilmEncoder();
  FilmEncoder(const FilmEncoder&) = delete;
  FilmEncoder& operator=(const FilmEncoder&) = delete;

  /// @param bgr CV_8UC3 of the film's size. @throws MissingResource if the disk is full.
  void Add(const cv::Mat& bgr);
  /// No picture may follow. @throws MissingResource if the disk is full.
  void Finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gaitcam
