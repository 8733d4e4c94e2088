// What a blurred frame costs, measured against MuJoCo's bare loop over the same scene in the same run.
//
// Counters: `ratio` is the time of one frame of 16 sub-frames (noise and response included) over 16 rounds of
// mjv_updateScene, mjr_render and mjr_readPixels; `ms_per_subframe` is the frame's time per sub-frame.

#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>

#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "sim/camera/camera_rig.h"
#include "sim/camera/egl_context.h"
#include "sim/walking/walker.h"
#include "sim/world/world.h"

namespace gaitcam {
namespace {

constexpr int kSubframes = 16;

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// KHR-1HV standing in the lab, with the record of its first fifth of a second.
class Lab {
 public:
  explicit Lab(const CameraOptions& camera)
      : rig_(camera, 1),
        robot_(ReadRobot("khr1hv", GAITCAM_SOURCE_DIR "/models")),
        place_(ReadScene("lab", GAITCAM_SOURCE_DIR "/models")),
        world_(robot_, place_, PhysicsOptions(), rig_.WorldCameras(), 1),
        renderer_(world_.model(), rig_.MakeRendererOptions(), world_.pictures()) {
    const Pose start(RotZ(place_.start.z()), Eigen::Vector3d(place_.start.x(), place_.start.y(), 0));
    const auto walker =
        MakeWalker(robot_, world_.nominal_model(), robot_.gaits.at("normal"), PathOptions(), PhysicsOptions(), start);
    world_.SetState(walker->InitialRoot(), walker->InitialJoints());
    while (world_.stamp_ns() < 200000000) world_.Step();
  }

  double ExposeOnce(const TruthOptions& truth) {
    const double begin = Now();
    benchmark::DoNotOptimize(rig_.Expose(renderer_, world_.record(), 1, truth));
    return Now() - begin;
  }

  World& world() { return world_; }

 private:
  CameraRig rig_;
  Robot robot_;
  Scene place_;
  World world_;
  Renderer renderer_;
};

/// MuJoCo's own loop with the same effects switched off.
class BareLoop {
 public:
  BareLoop(mjModel* model, const std::vector<TexturePicture>& pictures, int width_px, int height_px)
      : model_(model), view_{0, 0, width_px, height_px}, rgb_(size_t(3 * width_px * height_px)) {
    mjv_defaultOption(&option_);
    mjv_defaultScene(&scene_);
    mjv_makeScene(model, &scene_, 2000);
    scene_.flags[mjRND_SHADOW] = scene_.flags[mjRND_REFLECTION] = 0;
    mjv_defaultCamera(&camera_);
    camera_.type = mjCAMERA_FIXED;
    camera_.fixedcamid = FindCamera(model, "camera.left");
    model->vis.global.offwidth = width_px;
    model->vis.global.offheight = height_px;
    model->vis.quality.offsamples = 0;
    mjr_defaultContext(&context_);
    mjr_makeContext(model, &context_, mjFONTSCALE_50);
    UploadPictures(model, context_, pictures);
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  }
  ~BareLoop() {
    mjr_freeContext(&context_);
    mjv_freeScene(&scene_);
  }

  double Run(mjData* data, int rounds) {
    const double begin = Now();
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    for (int i = 0; i < rounds; ++i) {
      mjv_updateScene(model_, data, &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
      mjr_render(view_, &scene_, &context_);
      mjr_readPixels(rgb_.data(), nullptr, view_, &context_);
    }
    return Now() - begin;
  }

 private:
  mjModel* model_;
  mjrRect view_;
  std::vector<unsigned char> rgb_;
  mjvOption option_;
  mjvScene scene_;
  mjvCamera camera_;
  mjrContext context_;
};

CameraOptions Camera(int width_px, int height_px) {
  CameraOptions options;
  options.width_px = width_px;
  options.height_px = height_px;
  options.exposure.fixed_subframes = kSubframes;
  return options;
}

void BlurredFrame(benchmark::State& state, bool with_truth) {
  const EglContext gl;
  state.SetLabel(gl.renderer());
  const CameraOptions camera = Camera(int(state.range(0)), int(state.range(1)));
  Lab lab(camera);
  BareLoop bare(const_cast<mjModel*>(lab.world().model()), lab.world().pictures(), camera.width_px, camera.height_px);
  TruthOptions truth;
  truth.sharp = truth.depth = truth.blur = with_truth;
  lab.ExposeOnce(truth);
  bare.Run(lab.world().data(), 2);
  double frames_s = 0, bare_s = 0;
  for (auto _ : state) {  // in turn, so that whatever else runs on the machine slows both
    const double frame_s = lab.ExposeOnce(truth);
    bare_s += bare.Run(lab.world().data(), kSubframes);
    frames_s += frame_s;
    state.SetIterationTime(frame_s);
  }
  state.counters["ratio"] = frames_s / bare_s;
  state.counters["ms_per_subframe"] = 1e3 * frames_s / kSubframes / double(state.iterations());
}

void BM_BlurredFrame(benchmark::State& state) { BlurredFrame(state, false); }
void BM_BlurredFrameWithAllTruth(benchmark::State& state) { BlurredFrame(state, true); }
BENCHMARK(BM_BlurredFrame)->Args({320, 240})->Args({640, 480})->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_BlurredFrameWithAllTruth)
    ->Args({320, 240})
    ->Args({640, 480})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void BM_SensorNoise(benchmark::State& state) {
  const ImageSensor sensor(ExposureOptions(), false);
  const cv::Mat light(240, 320, CV_32FC3, cv::Scalar(0.2, 0.4, 0.6));
  uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sensor.Develop(light, RandomStream(++seed, "benchmark")));
}
BENCHMARK(BM_SensorNoise)->Unit(benchmark::kMillisecond);

void BM_AddLight(benchmark::State& state) {
  const cv::Mat picture(240, 320, CV_8UC4, cv::Scalar(20, 100, 200, 255));
  LightAccumulator light(320, 240);
  for (auto _ : state) light.Add(picture, 1e-6f);
}
BENCHMARK(BM_AddLight)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gaitcam
