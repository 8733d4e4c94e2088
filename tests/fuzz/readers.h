// Everything that reads what others wrote, for the fuzzer and for its replay in the tests. A new reader is one line in
// readers.cpp (scenario_readers.cpp, if it needs the simulator) and a file or two in corpus/NAME.

#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "algorithms/core/errors.h"
#include "tests/fuzz/fuzz_folder.h"

namespace gaitcam {

struct FuzzReader {
  std::string name;  ///< Of its folder in corpus/, too.
  /// Reads the bytes. What a reader may throw at bad input is caught; all else is a fault of ours and comes out.
  std::function<void(const std::string& bytes)> read;
};

/// For the names of tests.
inline void PrintTo(const FuzzReader& reader, std::ostream* out) { *out << reader.name; }

/// What the rooms below the simulator read, and what running systems say.
std::vector<FuzzReader> FuzzReaders();
/// Scenarios, suites, studies and matrices, which only the whole program can read.
std::vector<FuzzReader> ScenarioFuzzReaders();

/// Those are the answers to bad input that errors.h knows; anything else is not caught.
template <class Read>
void AnswerOrRefuse(const Read& read) {
  try {
    read();
  } catch (const BadInput&) {
  } catch (const TooLittleData&) {
  }
}

/// @param read is given a file with the bytes in it.
template <class Read>
FuzzReader FuzzReaderOfFile(const std::string& name, const std::string& suffix, Read read) {
  return {name, [suffix, read](const std::string& bytes) {
            AnswerOrRefuse([&] { read(FuzzFile(bytes, "input" + suffix)); });
          }};
}

/// @param read is given the bytes.
template <class Read>
FuzzReader FuzzReaderOfText(const std::string& name, Read read) {
  return {name, [read](const std::string& bytes) { AnswerOrRefuse([&] { read(bytes); }); }};
}

}  // namespace gaitcam
