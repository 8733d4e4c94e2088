#include "sim/camera/egl_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/core.hpp>
#include <thread>

#include "algorithms/core/errors.h"
#include "tests/sim/camera/film_scene.h"

namespace gaitcam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

RendererChoice Choice(const std::string& text) { return *RendererChoice::FromText(text); }

/// A lit sphere before walls of speckles, as one renderer draws it.
cv::Mat PictureBy(const RendererChoice& choice) {
  const MjModelPtr model = SpeckledRoom();
  const EglContext gl(choice);
  Renderer renderer(model.get());
  const MjDataPtr data(mj_makeData(model.get()));
  mj_forward(model.get(), data.get());
  return renderer.Picture(*data, LookingAlongX({0, 0, 1}), CameraModel::FromHorizontalFov(160, 120, 60));
}

std::string RefusalOf(const RendererChoice& choice) {
  try {
    const EglContext gl(choice);
  } catch (const MissingResource& e) {
    EXPECT_THAT(e.what(), testing::Not(HasSubstr("\n")));
    return e.what();
  }
  return {};
}

TEST(EglContext, NamesWhoDraws) {
  const RendererInfo info = EglContext().info();
  EXPECT_FALSE(info.vendor.empty());
  EXPECT_FALSE(info.name.empty());
  EXPECT_NE(info.name, "unknown");
  EXPECT_NE(info.version, "unknown");
}

TEST(EglContext, SoftwareOnDemandIsSoftware) {
  const Environment nothing("");
  const RendererInfo info = EglContext(Choice("software")).info();
  EXPECT_TRUE(info.is_software) << info.ToText();
}

TEST(EglContext, AGpuOnDemandIsOneOrIsMissingWithWhatThereIs) {
  const Environment nothing("");
  bool is_there = false;
  for (const EglDeviceReport& report : ListEglDevices())
    is_there = is_there || (report.failure.empty() && !report.opengl.is_software);
  if (is_there) {
    EXPECT_FALSE(EglContext(Choice("gpu")).info().is_software);
    EXPECT_FALSE(EglContext().info().is_software) << "auto prefers a GPU";
  } else {
    EXPECT_THAT(RefusalOf(Choice("gpu")),
                AllOf(HasSubstr("camera.renderer = gpu: no GPU gives an OpenGL context; EGL lists "),
                      HasSubstr(ListEglDevices().front().ToText())));
  }
}

TEST(EglContext, EachListedDeviceIsTheOneOfItsNumberAndTheNextNumberIsMissing) {
  const Environment nothing("");
  const std::vector<EglDeviceReport> reports = ListEglDevices();
  ASSERT_FALSE(reports.empty());
  for (size_t i = 0; i < reports.size(); ++i) {
    EXPECT_EQ(reports[i].device.index, int(i));
    const RendererChoice choice = Choice("device:" + std::to_string(i));
    if (!reports[i].failure.empty()) {
      EXPECT_THAT(RefusalOf(choice), HasSubstr(reports[i].failure));
      continue;
    }
    const RendererInfo info = EglContext(choice).info();
    EXPECT_EQ(info.Key(), reports[i].opengl.Key());
    EXPECT_EQ(info.egl_device, int(i));
  }
  const std::string none = "device:" + std::to_string(reports.size());
  EXPECT_THAT(RefusalOf(Choice(none)),
              AllOf(HasSubstr("camera.renderer = " + none + ": there is no such EGL device; EGL lists device 0: "),
                    HasSubstr(reports.back().ToText())));
}

TEST(EglContext, TheEnvironmentOverridesTheChoice) {
  const Environment software("software");
  EXPECT_TRUE(EglContext(Choice("device:63")).info().is_software);
  EXPECT_EQ(RendererKey(Choice("device:63")), EglContext().info().Key());
}

TEST(EglContext, ADeviceThatIsNotThereIsMissingWhoeverAsksForIt) {
  const Environment none("device:63");
  EXPECT_THAT(RefusalOf({}), HasSubstr("GAITCAM_EGL=device:63: there is no such EGL device; EGL lists "));
}

TEST(EglContext, AnUnknownChoiceIsTheUsersMistake) {
  for (const char* choice : {"fast", "device:", "device:x", "device:-1"}) {
    const Environment unknown(choice);
    EXPECT_THROW(EglContext(), BadInput) << choice;
    EXPECT_THROW(RendererKey({}), BadInput) << choice;
  }
}

/// What the cache of frames relies on.
TEST(EglContext, RenderersOfOneKeyDrawTheSameBytes) {
  const Environment nothing("");
  const cv::Mat expected = PictureBy(Choice("software"));
  cv::Scalar mean, deviation;
  cv::meanStdDev(expected, mean, deviation);
  EXPECT_GT(deviation[0], 10) << "the picture shows something";
  int compared = 0;
  for (const EglDeviceReport& report : ListEglDevices()) {
    if (report.opengl.Key() != RendererKey(Choice("software"))) continue;
    const cv::Mat picture = PictureBy(Choice("device:" + std::to_string(report.device.index)));
    EXPECT_EQ(cv::norm(picture, expected, cv::NORM_INF), 0) << report.ToText();
    ++compared;
  }
  if (compared == 0) GTEST_SKIP() << "no EGL device of this machine renders in software";
}

TEST(EglContext, ListingDevicesLeavesTheContextThatIsThere) {
  const MjModelPtr model = FlyerModel("<geom type='sphere' pos='1 0 0' size='0.1'/>");
  const EglContext gl;
  ListEglDevices();
  EXPECT_NO_THROW(Renderer{model.get()}) << "a renderer needs a current context";
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
  std::thread([&] { there = EglContext().info().name; }).join();
  EXPECT_EQ(here.info().name, there);
}

}  // namespace
}  // namespace gaitcam
