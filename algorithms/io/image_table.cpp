#include "algorithms/io/image_table.h"

namespace gaitcam {

ImageTable::ImageTable(const ImageListing& listing) : listing_(listing), table_(listing.table, listing.separator) {
  if (!listing.names_columns()) return;
  table_.Next();
  stamp_ = table_.ColumnNamed(listing.stamp_column);
  file_ = table_.ColumnNamed(listing.file_column);
}

std::optional<ListedImage> ImageTable::Next() {
  if (!table_.Next()) return std::nullopt;
  ListedImage image;
  image.stamp_ns = listing_.in_seconds ? table_.SecondsAsNs(stamp_, "the time in seconds")
                                       : table_.Integer(stamp_, "the time in nanoseconds");
  image.file = listing_.base / std::string(table_.Text(file_, "the name of an image file"));
  image.listed_at = table_.file().string() + ":" + std::to_string(table_.line());
  if (last_stamp_ns_ && image.stamp_ns <= *last_stamp_ns_) {
    table_.Fail("time " + SecondsText(image.stamp_ns) + " s does not come after the row before it (" +
                SecondsText(*last_stamp_ns_) + " s)");
  }
  last_stamp_ns_ = image.stamp_ns;
  return image;
}

}  // namespace gaitcam
