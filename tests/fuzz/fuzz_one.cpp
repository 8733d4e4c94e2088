// What libFuzzer calls. GAITCAM_FUZZ names the reader: GAITCAM_FUZZ=route_map build/fuzz/tests/gaitcam_fuzz FOLDER.

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/readers.h"

namespace {

const gaitcam::FuzzReader& Chosen() {
  const char* name = std::getenv("GAITCAM_FUZZ");
  for (const gaitcam::FuzzReader& reader : gaitcam::FuzzReaders()) {
    if (name != nullptr && reader.name == name) return reader;
  }
  std::fprintf(stderr, "set GAITCAM_FUZZ to one of");
  for (const gaitcam::FuzzReader& reader : gaitcam::FuzzReaders()) std::fprintf(stderr, " %s", reader.name.c_str());
  std::fprintf(stderr, "\n");
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const gaitcam::FuzzReader& reader = Chosen();
  reader.read(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
