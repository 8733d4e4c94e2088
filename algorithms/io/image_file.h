/// Images on disk without loss.

#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace gaitcam {

constexpr double kDepthUnitsPerMetre = 5000;  ///< TUM RGB-D's 16-bit depth.

/// Each throws MissingResource if the file cannot be written. @param compression as EncodePng has it.
void WritePng(const std::filesystem::path& file, const cv::Mat& image, int compression);
/// CV_32FC1 metres to 16 bit, rounded; what lies beyond 13.107 m becomes 0, "not measured".
/// @returns whether ReadDepthPng gives back the very same image.
bool WriteDepthPng(const std::filesystem::path& file, const cv::Mat& depth, int compression);
/// CV_32FC1 metres, lossless.
void WriteDepthTiff(const std::filesystem::path& file, const cv::Mat& depth);
/// CV_32FC2 vectors in px to 1/64 px, as KITTI stores optical flow; NaN or beyond 511 px: marked unknown.
void WriteVectorsPng(const std::filesystem::path& file, const cv::Mat& vectors, int compression);

/// Each throws BadInput "file: what is wrong (listed_at)"; `listed_at` names the table's file and line, or is empty.
/// 8 bits, one or three channels, as stored.
cv::Mat ReadImage(const std::filesystem::path& file, const std::string& listed_at);
cv::Mat ReadDepthPng(const std::filesystem::path& file, const std::string& listed_at);
cv::Mat ReadDepthTiff(const std::filesystem::path& file, const std::string& listed_at);
/// CV_32FC2, NaN where unknown.
cv::Mat ReadVectorsPng(const std::filesystem::path& file, const std::string& listed_at);

}  // namespace gaitcam
