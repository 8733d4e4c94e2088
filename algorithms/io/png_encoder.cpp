#include "algorithms/io/png_encoder.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "algorithms/core/errors.h"

// PNG: Portable Network Graphics, third edition (W3C). A file is a signature and chunks: length, type, data, CRC-32 of
// type and data, numbers with the most significant byte first. Pixels are one zlib stream; each row begins with its
// filter's number. "Up", the difference to the byte above, suits walls and floors as well as libpng's search among all
// filters does, and takes a tenth of the time.

namespace gaitcam {
namespace {

constexpr uint8_t kNone = 0, kUp = 2;               // filters
constexpr uint8_t kGrey = 0, kRgb = 2;              // kinds of colour
constexpr size_t kLength = 4, kType = 4, kCrc = 4;  // parts of a chunk, bytes

void Put32(uint32_t value, uint8_t* to) {
  for (int i = 0; i < 4; ++i) to[i] = uint8_t(value >> (24 - 8 * i));
}

/// Fills in what lies around the data of the chunk that begins at `begin` and ends where `file` does.
void CloseChunk(const char* type, size_t begin, std::vector<uint8_t>& file) {
  uint8_t* chunk = file.data() + begin;
  const size_t data = file.size() - begin - kLength - kType;
  Put32(uint32_t(data), chunk);
  std::memcpy(chunk + kLength, type, kType);
  const uint32_t crc = libdeflate_crc32(0, chunk + kLength, kType + data);
  file.resize(file.size() + kCrc);
  Put32(crc, file.data() + file.size() - kCrc);
}

void AddHeader(const cv::Mat& image, std::vector<uint8_t>& file) {
  const size_t begin = file.size();
  file.resize(begin + kLength + kType + 13, 0);
  uint8_t* data = file.data() + begin + kLength + kType;
  Put32(uint32_t(image.cols), data);
  Put32(uint32_t(image.rows), data + 4);
  data[8] = image.depth() == CV_16U ? 16 : 8;
  data[9] = image.channels() == 3 ? kRgb : kGrey;
  CloseChunk("IHDR", begin, file);
}

uint8_t* Put(uint8_t value, uint8_t* to) {
  *to = value;
  return to + 1;
}

uint8_t* Put(uint16_t value, uint8_t* to) {
  to[0] = uint8_t(value >> 8);
  to[1] = uint8_t(value);
  return to + 2;
}

/// A row as PNG has it: red first, and of 16 bits the upper ones.
template <class T>
void CopyRow(const T* from, int pixels, int channels, uint8_t* to) {
  if (channels == 1) {
    for (int i = 0; i < pixels; ++i) to = Put(from[i], to);
    return;
  }
  for (int i = 0; i < pixels; ++i, from += 3) to = Put(from[0], Put(from[1], Put(from[2], to)));
}

void CopyRow(const cv::Mat& image, int y, uint8_t* to) {
  if (image.depth() == CV_16U) {
    CopyRow(image.ptr<uint16_t>(y), image.cols, image.channels(), to);
  } else {
    CopyRow(image.ptr<uint8_t>(y), image.cols, image.channels(), to);
  }
}

/// to = a - b, byte by byte, each modulo 256; eight at a time in a word, whose highest bits are kept from borrowing.
void Subtract(const uint8_t* a, const uint8_t* b, size_t count, uint8_t* to) {
  constexpr uint64_t kHigh = 0x8080808080808080;
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    uint64_t x = 0, y = 0;
    std::memcpy(&x, a + i, 8);
    std::memcpy(&y, b + i, 8);
    const uint64_t difference = ((x | kHigh) - (y & ~kHigh)) ^ ((x ^ ~y) & kHigh);
    std::memcpy(to + i, &difference, 8);
  }
  for (; i < count; ++i) to[i] = uint8_t(a[i] - b[i]);
}

/// All rows, each after its filter's number.
std::vector<uint8_t> FilteredRows(const cv::Mat& image, uint8_t filter) {
  const size_t width = size_t(image.cols) * image.elemSize();
  std::vector<uint8_t> rows((width + 1) * size_t(image.rows)), above(width, 0), now(width);
  for (int y = 0; y < image.rows; ++y) {
    uint8_t* row = rows.data() + size_t(y) * (width + 1);
    row[0] = filter;
    if (filter == kNone) {
      CopyRow(image, y, row + 1);
      continue;
    }
    CopyRow(image, y, now.data());
    Subtract(now.data(), above.data(), width, row + 1);
    now.swap(above);
  }
  return rows;
}

void AddPixels(const cv::Mat& image, int compression, std::vector<uint8_t>& file) {
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(compression), libdeflate_free_compressor);
  GAITCAM_ASSERT(compressor != nullptr);
  const std::vector<uint8_t> rows = FilteredRows(image, compression == 0 ? kNone : kUp);
  const size_t begin = file.size(), data = begin + kLength + kType;
  file.resize(data + libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  const size_t size =
      libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(), file.data() + data, file.size() - data);
  GAITCAM_ASSERT(size > 0);
  file.resize(data + size);
  CloseChunk("IDAT", begin, file);
}

}  // namespace

std::vector<uint8_t> EncodePng(const cv::Mat& image, int compression) {
  GAITCAM_ASSERT(!image.empty() && (image.depth() == CV_8U || image.depth() == CV_16U));
  GAITCAM_ASSERT(image.channels() == 1 || image.channels() == 3);
  GAITCAM_ASSERT(compression >= 0 && compression <= 9);
  std::vector<uint8_t> file = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  AddHeader(image, file);
  AddPixels(image, compression, file);
  const size_t end = file.size();
  file.resize(end + kLength + kType);
  CloseChunk("IEND", end, file);
  return file;
}

}  // namespace gaitcam
