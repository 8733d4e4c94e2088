#include "scenarios/code/datasets/image_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// Decoders accept truncated PNG files, so the chunks are followed to the end.
std::string FaultOfPng(const std::string& bytes) {
  const std::string signature = "\x89PNG\r\n\x1a\n";
  if (!bytes.starts_with(signature)) return "is no PNG";
  for (size_t at = signature.size(); at + 12 <= bytes.size();) {
    const auto byte = [&](size_t i) { return size_t(static_cast<unsigned char>(bytes[at + i])); };
    const size_t length = byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3);
    if (bytes.compare(at + 4, 4, "IEND") == 0) return "";
    at += 12 + length;
  }
  return "is cut off";
}

/// FNV-1a.
uint64_t HashOfPixels(const cv::Mat& image) {
  uint64_t hash = 14695981039346656037ull;
  for (int row = 0; row < image.rows; ++row) {
    const uchar* bytes = image.ptr(row);
    for (size_t i = 0; i < size_t(image.cols) * image.elemSize(); ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  }
  return hash | 1;
}

std::string FaultOfPixels(const cv::Mat& image, ImageKind kind, const CameraModel& camera) {
  if (image.empty()) return "cannot be decoded";
  const int type = image.type();
  if (kind == ImageKind::kPicture && type != CV_8UC1 && type != CV_8UC3) return "is no image of 8 bits per channel";
  if (kind == ImageKind::kDepth && type != CV_16UC1) return "is no depth image of 16 bits and one channel";
  if (kind == ImageKind::kVectors && type != CV_16UC3) return "is no image of vectors (16 bits, three channels)";
  if (camera.width_px > 0 && (image.cols != camera.width_px || image.rows != camera.height_px)) {
    return fmt::format("has {} x {} pixels, the calibration says {} x {}", image.cols, image.rows, camera.width_px,
                       camera.height_px);
  }
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  if (kind == ImageKind::kPicture && deviation[0] + deviation[1] + deviation[2] == 0) return "is all of one colour";
  return "";
}

void CheckUnlisted(const fs::path& folder, const fs::path& table, const std::set<fs::path>& listed,
                   Problems& problems) {
  if (!fs::is_directory(folder)) return;
  std::set<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (listed.count(entry.path()) == 0) others.insert(entry.path());
  }
  for (const fs::path& file : others) problems.push_back({file, 0, "is not listed in " + table.string()});
}

/// A table of images with its columns found; none of its rows where these are not there.
struct ListedStamps {
  ListedStamps(const ImageListing& listing, Problems& problems)
      : table(listing.table, listing.separator, 2, problems, listing.names_columns()) {
    size_t stamp = 0;
    if (listing.names_columns()) {
      const auto stamps_at = table.ColumnNamed(listing.stamp_column), files_at = table.ColumnNamed(listing.file_column);
      if (!stamps_at || !files_at) return;
      stamp = *stamps_at;
      file = *files_at;
    }
    for (size_t row = 0; row < table.size(); ++row) {
      if (table.columns(row) > std::max(stamp, file)) continue;
      table.Fail(row,
                 fmt::format("has {} fields, expected at least {}", table.columns(row), std::max(stamp, file) + 1));
      return;
    }
    stamps = table.Stamps(listing.in_seconds, stamp);
  }

  CheckedTable table;
  size_t file = 1;  ///< Column.
  std::vector<std::optional<int64_t>> stamps;
};

}  // namespace

std::string FaultOfImage(const fs::path& file, ImageKind kind, const CameraModel& camera, uint64_t* content) {
  std::string bytes;
  try {
    bytes = FileContent(file);
  } catch (const BadInput&) {
    return fs::is_regular_file(file) ? "cannot be read" : "there is no such file";
  }
  if (bytes.empty()) return "is empty";
  if (file.extension() == ".png") {
    const std::string fault = FaultOfPng(bytes);
    if (!fault.empty()) return fault;
  }
  cv::Mat image;
  try {
    image = cv::imdecode(cv::Mat(1, int(bytes.size()), CV_8U, const_cast<char*>(bytes.data())), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    image.release();
  }
  const std::string fault = FaultOfPixels(image, kind, camera);
  if (content != nullptr && fault.empty()) *content = HashOfPixels(image);
  return fault;
}

void CheckTumHeader(CheckedTable& table) {
  constexpr int kSkipped = 3;
  if (!table.was_read() || table.leading_comments() == kSkipped) return;
  table.FailWhole(fmt::format("has {} lines of comment at its top; expected {}, which readers of this layout skip",
                              table.leading_comments(), kSkipped));
}

std::vector<CheckedImage> CheckImages(const ImageListing& listing, ImageKind kind, const CameraModel& camera,
                                      bool by_ours, Problems& problems) {
  ListedStamps listed(listing, problems);
  CheckedTable& table = listed.table;
  if (by_ours && listing.in_seconds) CheckTumHeader(table);
  std::vector<CheckedImage> images;
  std::set<fs::path> files;
  std::string last;
  int64_t last_ns = 0;
  for (size_t row = 0; row < listed.stamps.size(); ++row) {
    const std::string& name = table.Text(row, listed.file);
    const fs::path file = listing.base / name;
    if (!files.insert(file).second) table.Fail(row, name + " is listed twice");
    CheckedImage image{listed.stamps[row].value_or(0), table.line(row), file, 0};
    const std::string fault = FaultOfImage(file, kind, camera, &image.content);
    if (!fault.empty()) table.Fail(row, file.string() + ": " + fault);
    if (!listed.stamps[row]) continue;
    const std::string named = listing.FileName(image.stamp_ns);
    if (by_ours && file.filename() != named)
      table.Fail(row, fmt::format("{} is not the image of its time; expected {}", name, named));
    if (by_ours && named < last && image.stamp_ns > last_ns)
      table.Fail(row, fmt::format("{} is sorted before {}, which is earlier", named, last));
    last = named;
    last_ns = image.stamp_ns;
    images.push_back(image);
  }
  if (table.was_read() && table.size() == 0) table.FailWhole("lists no image");
  CheckUnlisted(listing.folder, table.file(), files, problems);
  return images;
}

void CompareImages(const ImageListing& listing, const std::vector<int64_t>& frames, const std::string& named,
                   Problems& problems) {
  Problems told;  // when the images were checked
  ListedStamps listed(listing, told);
  told.clear();
  CompareStamps(listed.stamps, listed.table, frames, named);
  problems.insert(problems.end(), told.begin(), told.end());
}

}  // namespace gaitcam
