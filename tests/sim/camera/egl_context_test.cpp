#include "sim/camera/egl_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

#include "algorithms/core/errors.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

/// Sets GAITCAM_EGL for the length of a test.
class Environment {
 public:
  explicit Environment(const char* value) {
    if (const char* before = std::getenv("GAITCAM_EGL")) before_ = before;
    setenv("GAITCAM_EGL", value, 1);
  }
  ~Environment() {
    if (before_.empty()) {
      unsetenv("GAITCAM_EGL");
    } else {
      setenv("GAITCAM_EGL", before_.c_str(), 1);
    }
  }

 private:
  std::string before_;
};

TEST(EglContext, NamesWhoDraws) {
  const EglContext gl;
  EXPECT_FALSE(gl.vendor().empty());
  EXPECT_FALSE(gl.renderer().empty());
  EXPECT_NE(gl.renderer(), "unknown");
  EXPECT_NE(gl.version(), "unknown");
}

TEST(EglContext, SoftwareOnDemandSaysThatItIsSoftware) {
  const Environment software("software");
  const EglContext gl;
  EXPECT_TRUE(gl.is_software()) << gl.renderer();
}

TEST(EglContext, ADeviceThatIsNotThereIsAMissingResource) {
  const Environment none("device:63");
  EXPECT_THROW(EglContext(), MissingResource);
}

TEST(EglContext, AnUnknownChoiceIsTheUsersMistake) {
  for (const char* choice : {"fast", "device:", "device:x", "device:-1"}) {
    const Environment unknown(choice);
    EXPECT_THROW(EglContext(), BadInput) << choice;
  }
}

TEST(EglContext, ANewOneWorksAfterAnOldOneIsGone) {
  const MjModelPtr model = FlyerModel("<geom type='sphere' pos='1 0 0' size='0.1'/>");
  for (int i = 0; i < 3; ++i) {
    const EglContext gl;
    Renderer renderer(model.get());
    const MjDataPtr data(mj_makeData(model.get()));
    mj_forward(model.get(), data.get());
    const cv::Mat picture =
        renderer.Picture(*data, LookingAlongX({0, 0, 0}), CameraModel::FromHorizontalFov(32, 24, 60));
    EXPECT_GT(cv::sum(picture)[0], 0);
  }
}

TEST(EglContext, EachThreadHasItsOwn) {
  const EglContext here;
  std::string there;
  std::thread([&] { there = EglContext().renderer(); }).join();
  EXPECT_EQ(here.renderer(), there);
}

}  // namespace
}  // namespace gaitcam
