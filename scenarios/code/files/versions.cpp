#include "scenarios/code/files/versions.h"

#include <ceres/version.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <opencv2/core/version.hpp>

#include "algorithms/io/checksum.h"
#include "frames_fingerprint.h"
#include "sim/world/world.h"

namespace gaitcam {

Facts LibraryVersions() {
  return {{"gaitcam", GAITCAM_VERSION},
          {"MuJoCo", mj_versionString()},
          {"OpenCV", CV_VERSION},
          {"Eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"Ceres", CERES_VERSION_STRING},
          {"compiler", __VERSION__}};
}

Facts RunFacts(uint64_t seed) {
  Facts facts = LibraryVersions();
  facts.insert(facts.begin(), {"seed", std::to_string(seed)});
  return facts;
}

std::string ProgramVersion() { return GAITCAM_VERSION; }

std::string FramesFingerprint() { return std::string(GAITCAM_FRAMES_FINGERPRINT) + "-" + mj_versionString(); }

std::string ProgramFingerprint() {
  static const std::string fingerprint = Sha256OfFile("/proc/self/exe");  // some 10 MB: read once
  return fingerprint;
}

}  // namespace gaitcam
