// Everything that reads what others wrote, for the fuzzer and for its replay in the tests. A new reader is one line in
// readers.cpp and a file or two in corpus/NAME.

#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace gaitcam {

struct FuzzReader {
  std::string name;  ///< Of its folder in corpus/, too.
  /// Reads the bytes. What a reader may throw at bad input is caught; all else is a fault of ours and comes out.
  std::function<void(const std::string& bytes)> read;
};

/// For the names of tests.
inline void PrintTo(const FuzzReader& reader, std::ostream* out) { *out << reader.name; }

const std::vector<FuzzReader>& FuzzReaders();

}  // namespace gaitcam
