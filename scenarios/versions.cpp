#include "scenarios/versions.h"

#include <ceres/version.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <opencv2/core/version.hpp>

#include "sim/world.h"

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

}  // namespace gaitcam
