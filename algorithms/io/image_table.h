/// A table of images, read row by row.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "algorithms/io/dataset_layout.h"
#include "algorithms/io/text_table.h"

namespace gaitcam {

/// One row.
struct ListedImage {
  int64_t stamp_ns = 0;
  std::filesystem::path file;
  std::string listed_at;  ///< "table:line"
};

class ImageTable {
 public:
  /// @throws BadInput if the table cannot be read, or its first row does not name the columns where it should.
  explicit ImageTable(const ImageListing& listing);

  /// In time order; nothing after the last.
  /// @throws BadInput naming file and line: a row that is not what the layout says, stamps that do not increase.
  std::optional<ListedImage> Next();

 private:
  ImageListing listing_;
  TextTable table_;
  size_t stamp_ = 0, file_ = 1;  ///< Columns.
  std::optional<int64_t> last_stamp_ns_;
};

}  // namespace gaitcam
