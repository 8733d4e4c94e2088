// Who renders, on machines as they are: no EGL, a driver that does not load, two devices. The second device is a copy
// of Mesa's library under another name, which EGL's vendor-neutral loader takes for another vendor.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kMesa = "libEGL_mesa.so.0";

/// Mesa's library where Debian puts it, or nothing.
fs::path FindMesa() {
  for (const auto& entry : fs::directory_iterator("/usr/lib")) {
    const fs::path file = entry.path() / kMesa;
    std::error_code none;
    if (entry.is_directory(none) && fs::exists(file, none)) return fs::canonical(file);
  }
  return {};
}

class RendererTest : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path mesa = FindMesa();
    if (mesa.empty()) GTEST_SKIP() << "no " << kMesa << " on this machine";
    fs::copy_file(mesa, File("libEGL_copy.so.0"));
    Vendor("first.json", kMesa);
    Vendor("second.json", File("libEGL_copy.so.0"));
    std::ofstream(File("walk.yaml"))
        << "scene: plain\nduration_s: 0.5\npath: {kind: stand, duration_s: 1}\nvideo: {enabled: false}\n"
           "camera: {width_px: 80, height_px: 60, rate_hz: 10}\nsystem: orb_vo\n"
           "score: {min_coverage_ratio: 0, min_pairs: 3}\n";
  }

  fs::path File(const std::string& name) const { return temporary_.path() / name; }
  void Vendor(const std::string& name, const fs::path& library) const {
    std::ofstream(File(name)) << R"({"file_format_version": "1.0.0", "ICD": {"library_path": ")" << library.string()
                              << "\"}}\n";
  }
  /// Mesa draws in software here whatever GPU there is; its loader's own warnings are kept quiet.
  ProgramResult Run(const std::string& words, const std::string& environment = "") const {
    return RunShell("env LIBGL_ALWAYS_SOFTWARE=1 EGL_LOG_LEVEL=fatal GAITCAM_EGL= __EGL_VENDOR_LIBRARY_FILENAMES=" +
                        File("first.json").string() + ":" + File("second.json").string() +
                        " GAITCAM_DATA=" + TestData().string() + " " + environment + " " + Program() + " " + words,
                    temporary_.path());
  }
  void ExpectRefusal(int code, const std::string& words, const testing::Matcher<std::string>& message,
                     const std::string& environment = "") const {
    const ProgramResult result = Run(words + " --out nothing", environment);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, message);
    EXPECT_FALSE(fs::exists(File("nothing")));
  }
  nlohmann::json Doctor(const std::string& environment = "") const {
    return nlohmann::json::parse(Run("doctor --json", environment).out);
  }

  const TemporaryFolder temporary_;
};

TEST_F(RendererTest, DoctorListsTheDevicesAndWhichOneIsTaken) {
  const nlohmann::json doctor = Doctor();
  for (const char* device : {"EGL device 0", "EGL device 1"}) {
    ASSERT_TRUE(doctor.contains(device)) << doctor;
    EXPECT_THAT(doctor[device]["answer"].get<std::string>(),
                AllOf(HasSubstr(", software, OpenGL "), HasSubstr("Mesa")));
  }
  EXPECT_FALSE(doctor.contains("EGL device 2"));
  EXPECT_THAT(doctor["EGL"]["answer"].get<std::string>(),
              AllOf(HasSubstr("camera.renderer: auto takes "), HasSubstr("EGL device 0")));
  EXPECT_THAT(Doctor("GAITCAM_EGL=device:1")["EGL"]["answer"].get<std::string>(),
              AllOf(HasSubstr("GAITCAM_EGL=device:1 takes "), HasSubstr("EGL device 1")));
}

TEST_F(RendererTest, ADriverThatDoesNotLoadIsListedWithTheReason) {
  const nlohmann::json doctor = Doctor("LIBGL_DRIVERS_PATH=/nonexistent");
  EXPECT_THAT(doctor["EGL device 0"]["answer"].get<std::string>(),
              HasSubstr("no OpenGL context: eglInitialize failed: EGL_NOT_INITIALIZED"));
  EXPECT_FALSE(doctor["EGL"]["ok"]);
  EXPECT_THAT(doctor["EGL"]["answer"].get<std::string>(), HasSubstr("no EGL device gives an OpenGL context"));
}

TEST_F(RendererTest, WhatIsNotThereIsMissingInOneLineThatSaysWhatIs) {
  const testing::Matcher<std::string> two = AllOf(HasSubstr("; EGL lists device 0: "), HasSubstr("; device 1: "));
  ExpectRefusal(4, "run walk.yaml --set camera.renderer=gpu",
                AllOf(HasSubstr("camera.renderer = gpu: no GPU gives an OpenGL context"), two));
  ExpectRefusal(4, "run walk.yaml --set camera.renderer=device:2",
                AllOf(HasSubstr("camera.renderer = device:2: there is no such EGL device"), two));
  ExpectRefusal(4, "record walk.yaml", AllOf(HasSubstr("GAITCAM_EGL=device:7: there is no such EGL device"), two),
                "GAITCAM_EGL=device:7");
  ExpectRefusal(4, "run walk.yaml", AllOf(HasSubstr("GAITCAM_EGL=gpu: no GPU"), two), "GAITCAM_EGL=gpu");
  ExpectRefusal(2, "run walk.yaml", HasSubstr("GAITCAM_EGL=fast: expected one of auto, gpu, software, device:N"),
                "GAITCAM_EGL=fast");
}

TEST_F(RendererTest, ARunSaysWhoRenderedAndTheOtherDeviceDrawsTheSameBytes) {
  ASSERT_EQ(Run("record walk.yaml --out software -q --set camera.renderer=software").exit_code, 0);
  const ProgramResult other = Run("record walk.yaml --out other -q --set camera.renderer=device:1");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  int images = 0;
  for (const auto& entry : fs::recursive_directory_iterator(File("software"))) {
    if (entry.path().extension() != ".png") continue;
    ++images;
    EXPECT_EQ(ReadText(entry.path()), ReadText(File("other") / fs::relative(entry.path(), File("software"))));
  }
  EXPECT_GE(images, 5);

  const ProgramResult run = Run("run walk.yaml --out run -q --set camera.renderer=device:1");
  ASSERT_EQ(run.exit_code, 3) << run.err << "who stands in a plain room is not tracked, but the report is there";
  const nlohmann::json scores = nlohmann::json::parse(ReadText(File("run/scores.json")));
  EXPECT_EQ(scores["run"]["egl_device"], 1);
  EXPECT_EQ(scores["run"]["software_renderer"], true);
  EXPECT_THAT(ReadText(File("run/report.html")), HasSubstr(", software, EGL device 1, OpenGL "));
  EXPECT_THAT(ReadText(File("run/scenario.yaml")), HasSubstr("renderer: device:1\n"));
}

}  // namespace
}  // namespace gaitcam
