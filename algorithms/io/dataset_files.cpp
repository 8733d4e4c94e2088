#include "algorithms/io/dataset_files.h"

#include <algorithm>
#include <cerrno>
#include <limits>
#include <system_error>

#include "algorithms/core/errors.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {

namespace fs = std::filesystem;

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw MissingResource(folder.string() + ": cannot make this folder: " + error.message());
}

void WriteText(const fs::path& file, const std::string& text) {
  MakeFolder(file.parent_path());
  WriteWholeFile(file, text);
}

std::string PoseCells(const Pose& X) {
  const Eigen::Vector3d& t = X.translation;
  const Eigen::Quaterniond& q = X.rotation;
  std::string text;
  for (const double number : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) text += ',' + ExactText(number);
  return text;
}

std::string PoseColumns(const std::string& of) {
  std::string text;
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) text += "," + of + "_" + name;
  return text;
}

std::string TumHeader(const std::string& what, const std::string& columns) {
  return "# " + what + "\n# times in s, by the clock of all sensors; an image's is the middle of its exposure\n# " +
         columns;
}

PendingFolder::PendingFolder(fs::path wanted) : wanted_(std::move(wanted)), path_(UnfinishedNameFor(wanted_)) {
  if (fs::exists(wanted_)) throw BadInput(wanted_.string() + ": exists already; remove it or choose another name");
  RemoveAbandoned(wanted_);
  for (fs::path above = wanted_.parent_path(); !above.empty() && !fs::exists(above); above = above.parent_path()) {
    made_above_.push_back(above);
  }
  try {
    MakeFolder(path_);
  } catch (...) {
    Remove();
    throw;
  }
}

PendingFolder::~PendingFolder() {
  if (!kept_) Remove();
}

void PendingFolder::Remove() {
  std::error_code error;
  fs::remove_all(named_ ? wanted_ : path_, error);
  for (const fs::path& above : made_above_) fs::remove(above, error);  // a folder with something in it stays
}

void PendingFolder::Name() {
  std::error_code error;
  fs::rename(path_, wanted_, error);
  if (error == std::errc::directory_not_empty || error == std::errc::file_exists) {
    throw BadInput(wanted_.string() + ": another process has made it meanwhile; remove it or choose another name");
  }
  if (error) throw MissingResource(wanted_.string() + ": cannot name this folder: " + error.message());
  named_ = true;
}

RowFile::RowFile(fs::path file, const std::optional<std::string>& header) : file_(std::move(file)) {
  MakeFolder(file_.parent_path());
  stream_.open(file_, std::ios::binary);
  if (!stream_) FailToWrite(file_, errno);
  if (header) Row(*header);
}

void RowFile::Row(const std::string& row) {
  stream_ << row << '\n';
  if (!stream_) FailToWrite(file_, errno);
}

void RowFile::Close() {
  stream_.close();
  if (!stream_) FailToWrite(file_, errno);
}

ImageFiles::ImageFiles(const ImageListing& listing, const std::string& what) : listing_(listing) {
  MakeFolder(listing.folder);
  if (listing.names_columns()) return;
  table_.emplace(listing.table,
                 listing.in_seconds ? TumHeader(what, "timestamp filename") : std::string("#timestamp [ns],filename"));
}

fs::path ImageFiles::Add(int64_t stamp_ns) {
  if (table_) table_->Row(Entry(stamp_ns));
  return listing_.folder / listing_.FileName(stamp_ns);
}

std::string ImageFiles::Entry(int64_t stamp_ns) const {
  const std::string stamp = listing_.in_seconds ? SecondsText(stamp_ns) : std::to_string(stamp_ns);
  const fs::path file = (listing_.folder / listing_.FileName(stamp_ns)).lexically_relative(listing_.base);
  return stamp + listing_.separator + file.string();
}

void ImageFiles::Close() {
  if (table_) table_->Close();
}

namespace {

bool TooFarForPng(const cv::Mat& depth) {
  double farthest = 0;
  cv::minMaxLoc(depth, nullptr, &farthest);
  return farthest > std::numeric_limits<uint16_t>::max() / kDepthUnitsPerMetre;
}

}  // namespace

ImageJobs::ImageJobs(int png_compression, int threads) : level_(png_compression), pool_(std::clamp(threads, 0, 64)) {}

void ImageJobs::Png(const fs::path& file, const cv::Mat& image) {
  pool_.Do([=, level = level_] { WritePng(file, image, level); });
}

void ImageJobs::Vectors(const fs::path& file, const cv::Mat& vectors) {
  pool_.Do([=, level = level_] { WriteVectorsPng(file, vectors, level); });
}

void ImageJobs::PlainDepth(const fs::path& file, const cv::Mat& depth) {
  pool_.Do([=, level = level_] { WriteDepthPng(file, depth, level); });
}

void ImageJobs::Depth(const fs::path& root, const fs::path& file, int64_t stamp_ns, const cv::Mat& depth,
                      bool measured) {
  pool_.Do([=, level = level_] {
    const bool exact = WriteDepthPng(file, depth, level);
    if (measured ? exact : !TooFarForPng(depth)) return;
    MakeFolder(root / "depth_exact");
    WriteDepthTiff(root / "depth_exact" / (std::to_string(stamp_ns) + ".tiff"), depth);
  });
}

}  // namespace gaitcam
