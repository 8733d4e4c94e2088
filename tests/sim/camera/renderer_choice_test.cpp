#include "sim/camera/renderer_choice.h"

#include <gtest/gtest.h>

namespace gaitcam {
namespace {

TEST(RendererChoice, EveryTextThatIsOneIsWrittenAsItWasRead) {
  for (const char* text : {"auto", "gpu", "software", "device:0", "device:12"}) {
    const std::optional<RendererChoice> choice = RendererChoice::FromText(text);
    ASSERT_TRUE(choice) << text;
    EXPECT_EQ(choice->ToText(), text);
  }
}

TEST(RendererChoice, NothingElseIsOne) {
  for (const char* text : {"", "Auto", "gpu ", "fast", "device", "device:", "device:x", "device:-1", "device:+1",
                           "device:1.5", "device:99999999999", "device: 1"})
    EXPECT_FALSE(RendererChoice::FromText(text)) << text;
}

TEST(RendererChoice, OnlyGpuAndSoftwareRuleARendererOut) {
  for (const bool software : {false, true}) {
    EXPECT_TRUE(RendererChoice::FromText("auto")->Permits(software));
    EXPECT_TRUE(RendererChoice::FromText("device:1")->Permits(software));
    EXPECT_EQ(RendererChoice::FromText("gpu")->Permits(software), !software);
    EXPECT_EQ(RendererChoice::FromText("software")->Permits(software), software);
  }
}

TEST(RendererInfo, TheKeyIsThatOfTheDriverAndNotOfTheDevice) {
  RendererInfo first{"A GPU", "its maker", "4.6", false, 0}, second = first;
  second.egl_device = 1;
  EXPECT_EQ(first.Key(), second.Key());
  EXPECT_NE(first.ToText(), second.ToText());
  second.version = "4.7";
  EXPECT_NE(first.Key(), second.Key());
}

}  // namespace
}  // namespace gaitcam
