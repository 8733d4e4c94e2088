#include "scenarios/code/datasets/record_matrix.h"
#include "scenarios/code/files/scenario.h"
#include "scenarios/code/jobs/study.h"
#include "scenarios/code/jobs/suite.h"
#include "tests/fuzz/readers.h"

namespace gaitcam {

namespace fs = std::filesystem;

std::vector<FuzzReader> ScenarioFuzzReaders() {
  return {
      FuzzReaderOfFile("scenario", ".yaml", [](const fs::path& file) { ReadScenario(file, {}); }),
      FuzzReaderOfFile("suite", ".yaml", [](const fs::path& file) { ReadSuite(file.string()); }),
      FuzzReaderOfFile("study", ".yaml", [](const fs::path& file) { ReadStudy(file, false); }),
      FuzzReaderOfFile("matrix", ".yaml", [](const fs::path& file) { ReadMatrix(file, {}, false); }),
  };
}

}  // namespace gaitcam
