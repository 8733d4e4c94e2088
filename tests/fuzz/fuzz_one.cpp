// What libFuzzer calls. GAITCAM_FUZZ names the reader: GAITCAM_FUZZ=route_map build/fuzz/tests/gaitcam_fuzz FOLDER.
// gaitcam_fuzz_all knows the readers of scenarios, too.

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/readers.h"

namespace {

std::vector<gaitcam::FuzzReader> Known() {
  std::vector<gaitcam::FuzzReader> readers = gaitcam::FuzzReaders();
#ifdef GAITCAM_FUZZ_ALL
  for (gaitcam::FuzzReader& reader : gaitcam::ScenarioFuzzReaders()) readers.push_back(std::move(reader));
#endif
  return readers;
}

gaitcam::FuzzReader Chosen() {
  const char* name = std::getenv("GAITCAM_FUZZ");
  for (const gaitcam::FuzzReader& reader : Known()) {
    if (name != nullptr && reader.name == name) return reader;
  }
  std::fprintf(stderr, "set GAITCAM_FUZZ to one of\n");
  for (const gaitcam::FuzzReader& reader : Known()) std::printf("%s ", reader.name.c_str());
  std::printf("\n");
  std::fflush(stdout);
  std::_Exit(2);  // libFuzzer would keep an input of one that exits
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const gaitcam::FuzzReader reader = Chosen();
  reader.read(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
