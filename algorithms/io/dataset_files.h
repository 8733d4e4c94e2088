/// What a recorded folder is made of: a folder that gets its name when it is whole, tables that grow by rows, images
/// that are encoded beside the caller. `dataset_writer.h` and `truth_files.h` put them together.

#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/pose.h"
#include "algorithms/io/dataset_layout.h"
#include "algorithms/io/writer_pool.h"

namespace gaitcam {

/// With all above it. @throws MissingResource.
void MakeFolder(const std::filesystem::path& folder);

/// Makes the folder of the file, too. @throws MissingResource.
void WriteText(const std::filesystem::path& file, const std::string& text);

/// ",x,y,z,qx,qy,qz,qw": metres and a unit quaternion, as short as they come back exactly.
std::string PoseCells(const Pose& X);

/// The names of these columns: ",OF_x" to ",OF_qw".
std::string PoseColumns(const std::string& of);

/// The three lines of comment that begin TUM's tables; its readers skip so many.
std::string TumHeader(const std::string& what, const std::string& columns);

/// A folder that gets its name when it is whole; until then it has one of this process's own, and is removed if
/// abandoned, with the folders above it that were made for it and are empty then.
class PendingFolder {
 public:
  /// @throws BadInput if it exists already; MissingResource if it cannot be made.
  explicit PendingFolder(std::filesystem::path wanted);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& wanted() const { return wanted_; }
  /// @throws BadInput if another process has made it meanwhile; MissingResource.
  void Name();
  /// Until then it is removed again: a folder that belongs to it may not get its own name.
  void Keep() { kept_ = true; }

 private:
  void Remove();

  std::filesystem::path wanted_, path_;
  std::vector<std::filesystem::path> made_above_;  ///< That were not there before, the innermost first.
  bool named_ = false, kept_ = false;
};

/// A table that grows by rows. Its functions throw MissingResource where it cannot be written.
class RowFile {
 public:
  /// @param header without its last line end; nothing: the table begins with its first row.
  explicit RowFile(std::filesystem::path file, const std::optional<std::string>& header = {});
  void Row(const std::string& row);
  void Close();

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
};

/// A folder of images and, unless the layout lists all streams in one, the table of them.
class ImageFiles {
 public:
  ImageFiles(const ImageListing& listing, const std::string& what);

  /// Lists an image and @returns where to write it.
  std::filesystem::path Add(int64_t stamp_ns);
  /// Its stamp and file, as tables say them.
  std::string Entry(int64_t stamp_ns) const;
  /// The names of the two columns, where all streams are in one table.
  std::string Columns() const { return listing_.stamp_column + listing_.separator + listing_.file_column; }
  void Close();

 private:
  ImageListing listing_;
  std::optional<RowFile> table_;
};

/// The images of one recording on their way to the disk. Pixels must not be altered after they were given.
class ImageJobs {
 public:
  /// @param png_compression 0 none, 1 fastest to 9 smallest. @param threads 0: the caller's does it all.
  ImageJobs(int png_compression, int threads);

  void Png(const std::filesystem::path& file, const cv::Mat& image);
  /// @param vectors px; see `WriteVectorsPng`.
  void Vectors(const std::filesystem::path& file, const cv::Mat& vectors);
  /// @param depth metres. Without a lossless twin.
  void PlainDepth(const std::filesystem::path& file, const cv::Mat& depth);
  /// With a lossless twin in ROOT/depth_exact where the PNG does not hold it: of a measured depth, every digit; of a
  /// true one, how far away it is.
  void Depth(const std::filesystem::path& root, const std::filesystem::path& file, int64_t stamp_ns,
             const cv::Mat& depth, bool measured);
  /// Waits for all. @throws what a job threw.
  void Finish() { pool_.Finish(); }

 private:
  int level_;
  WriterPool pool_;
};

}  // namespace gaitcam
