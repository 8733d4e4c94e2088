#include "scenarios/code/experiments/light_cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "algorithms/core/errors.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/runs/runner.h"

namespace gaitcam {
namespace {

constexpr TruthOptions kNoTruth{false, false, false};

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// MuJoCo's own loop with the same effects switched off.
class BareLoop {
 public:
  BareLoop(const World& world, int width_px, int height_px)
      : model_(*world.model()),
        view_{0, 0, width_px, height_px},
        rgb_(size_t(3) * size_t(width_px) * size_t(height_px)) {
    mjv_defaultOption(&option_);
    mjv_defaultScene(&scene_);
    mjv_makeScene(&model_, &scene_, model_.ngeom + 100);
    scene_.flags[mjRND_SHADOW] = scene_.flags[mjRND_REFLECTION] = 0;
    mjv_defaultCamera(&camera_);
    camera_.type = mjCAMERA_FIXED;
    camera_.fixedcamid = FindCamera(&model_, "camera.left");
    model_.vis.global.offwidth = width_px;
    model_.vis.global.offheight = height_px;
    model_.vis.quality.offsamples = 0;
    mjr_defaultContext(&context_);
    mjr_makeContext(&model_, &context_, mjFONTSCALE_50);
    UploadPictures(&model_, context_, world.pictures());
  }
  ~BareLoop() {
    mjr_freeContext(&context_);
    mjv_freeScene(&scene_);
  }
  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;

  /// @returns seconds.
  double Run(mjData* data, int rounds) {
    const double begin = Now();
    mjr_setBuffer(mjFB_OFFSCREEN, &context_);
    for (int i = 0; i < rounds; ++i) {
      mjv_updateScene(&model_, data, &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
      mjr_render(view_, &scene_, &context_);
      mjr_readPixels(rgb_.data(), nullptr, view_, &context_);
    }
    return Now() - begin;
  }

 private:
  mjModel model_;  ///< Shallow: only sizes of the picture differ.
  mjrRect view_;
  std::vector<unsigned char> rgb_;
  mjvOption option_;
  mjvScene scene_;
  mjvCamera camera_;
  mjrContext context_;
};

SimulationOptions OptionsOf(const ResolvedScenario& resolved, double longest_s) {
  SimulationOptions options = SimulationOptionsOf(resolved);
  options.camera.exposure.noise = 0;
  options.camera.stereo.baseline_m = 0;
  if (options.duration_s <= 0 || options.duration_s > longest_s) options.duration_s = longest_s;
  return options;
}

/// Numbers of the frames with the longest blur, each a third of a second from the next at least; in order of time.
std::vector<int64_t> WorstFrames(const ResolvedScenario& resolved, const LightMeasurement& options) {
  SimulationOptions small = OptionsOf(resolved, options.longest_s);
  small.camera.height_px = std::max(16, 64 * small.camera.height_px / small.camera.width_px);
  small.camera.width_px = 64;
  small.camera.exposure.fixed_subframes = 1;
  Simulation simulation(resolved.robot, resolved.scene, small, resolved.scenario.seed);
  std::vector<std::pair<double, int64_t>> by_blur;
  while (const auto frame = simulation.Next(kNoTruth)) {
    by_blur.emplace_back(frame->truth.blur_max_px, simulation.next_frame() - 1);
  }
  std::sort(by_blur.rbegin(), by_blur.rend());
  const auto apart = int64_t(std::ceil(small.camera.rate_hz / 3));
  std::vector<int64_t> worst;
  for (const auto& [blur_px, frame] : by_blur) {
    const bool near =
        std::any_of(worst.begin(), worst.end(), [&, at = frame](int64_t w) { return std::abs(w - at) < apart; });
    if (!near && int(worst.size()) < options.frames) worst.push_back(frame);
  }
  std::sort(worst.begin(), worst.end());
  return worst;
}

/// The same camera as the scenario's, integrating otherwise.
struct Rigs {
  CameraRig sheared, plain, fine;

  explicit Rigs(const CameraOptions& camera) : sheared(camera, 1), plain(Plain(camera), 1), fine(Fine(camera), 1) {}

  static CameraOptions Plain(CameraOptions camera) {
    camera.exposure.integration = LightIntegration::kPlain;
    return camera;
  }
  static CameraOptions Fine(CameraOptions camera) {
    camera.exposure.max_step_px /= 4;
    camera.exposure.max_subframes = 4096;
    camera.antialias *= 4;
    return Plain(camera);
  }
};

}  // namespace

LightRow MeasureLight(const ResolvedScenario& resolved, const LightMeasurement& options) {
  const SimulationOptions simulated = OptionsOf(resolved, options.longest_s);
  const CameraOptions& camera = simulated.camera;
  LightRow row;
  row.name = resolved.scenario.name;
  Rigs rigs(camera);
  const std::vector<int64_t> worst = WorstFrames(resolved, options);
  if (worst.empty()) throw TooLittleData(row.name + ": its walk has no frames");
  SimulationOptions blind = simulated;  // walks as the scenario does; its own frames are not looked at
  blind.camera.exposure.fixed_subframes = 1;
  Simulation simulation(resolved.robot, resolved.scene, blind, resolved.scenario.seed);
  BareLoop bare(simulation.world(), camera.width_px, camera.height_px);
  std::vector<double> blur_px, seconds, ratio, ratio_with_truth;
  const auto expose = [&](CameraRig& rig, int64_t frame, const TruthOptions& truth) {
    return rig.Expose(simulation.renderer(), simulation.world().record(), frame, truth).left;
  };
  while (simulation.next_frame() <= worst.back() && simulation.Next(kNoTruth)) {
    const int64_t frame = simulation.next_frame() - 1;
    if (!std::binary_search(worst.begin(), worst.end(), frame)) continue;
    if (row.frames == 0) expose(rigs.sheared, frame, {});  // what is made once
    const double begin = Now();
    const ExposedFrame sheared = expose(rigs.sheared, frame, kNoTruth);
    const double frame_s = Now() - begin;
    const ExposedFrame with_truth = expose(rigs.sheared, frame, {});
    const double truth_s = Now() - begin - frame_s;
    const ExposedFrame plainly = expose(rigs.plain, frame, kNoTruth);
    const int subframes = int(plainly.truth.subframes.size());  // by the rule of camera.max_step_px and antialias
    const double bare_s = bare.Run(simulation.world().data(), subframes);
    seconds.push_back(frame_s);
    ratio.push_back(frame_s / bare_s);
    ratio_with_truth.push_back(truth_s / bare_s);
    blur_px.push_back(sheared.truth.blur_max_px);
    row.renders += sheared.truth.renders;
    row.subframes += subframes;
    ++row.frames;
    if (!options.convergence) continue;
    const cv::Mat plain = plainly.image.pixels;
    const cv::Mat fine = expose(rigs.fine, frame, kNoTruth).image.pixels;
    const cv::Mat edges = NearDepthEdges(with_truth.truth.depth);
    row.sheared.Add(sheared.image.pixels, fine);
    row.sheared_edges.Add(sheared.image.pixels, fine, edges);
    row.plain.Add(plain, fine);
    row.plain_edges.Add(plain, fine, edges);
  }
  row.renders /= std::max(1, row.frames);
  row.subframes /= std::max(1, row.frames);
  row.blur_px = QuantileOf(blur_px, 0.5);
  row.frame_s = QuantileOf(seconds, 0.5);
  row.ratio = QuantileOf(ratio, 0.5);
  row.ratio_with_truth = QuantileOf(ratio_with_truth, 0.5);
  return row;
}

}  // namespace gaitcam
