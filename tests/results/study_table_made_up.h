// A study that never ran: errors grow with exposure and twice as fast with the plain system.

#pragma once

#include <cmath>

#include "algorithms/core/random.h"
#include "results/reports/study_report.h"
#include "results/scoring/study_effects.h"

namespace gaitcam {

struct MadeUpStudy {
  StudyTable table;
  StudyReportInput input;
  std::vector<StudyEffect> effects;

  explicit MadeUpStudy(size_t seeds = 6) {
    table.name = "made_up";
    table.description = "exposure at three gaits, two systems";
    table.axes = {{"camera.exposure_ms", {"0", "10", "20", "33"}, 0},
                  {"gait.preset", {"slow", "normal", "brisk"}, 1},
                  {"system", {"sift_vo", "mobif_vo_plus"}, 0}};
    table.score_names = {"coverage_ratio", "ate_sim3_rmse_m", "rotation_gain"};
    table.metrics = {
        {"coverage_ratio", 0, "", "part of the frames with a pose", Better::kHigher},
        {"ate_sim3_rmse_m", 0, "m", "position error after Sim(3) alignment, root mean square", Better::kLower},
        {"rotation_gain", 0, "", "estimated over true total turn", Better::kNearOne}};
    table.seeds = seeds;
    const double exposures[] = {0, 10, 20, 33}, speeds[] = {0.05, 0.2, 0.5};
    for (size_t e = 0; e < 4; ++e)
      for (size_t g = 0; g < 3; ++g)
        for (size_t s = 0; s < 2; ++s)
          for (size_t seed = 1; seed <= seeds; ++seed) AddRun({e, g, s}, seed, exposures[e] * speeds[g]);
    effects = RankEffects(table, {}, 2);
    input.table = &table;
    input.effects = &effects;
    input.by = 2;
    input.study_file = "axes: {}\n";
  }
  MadeUpStudy(const MadeUpStudy&) = delete;

 private:
  void AddRun(std::vector<size_t> levels, uint64_t seed, double blur_px) {
    RandomStream random(seed, "made up/" + std::to_string(levels[0] * 100 + levels[1] * 10 + levels[2]));
    StudyRun run;
    run.levels = levels;
    run.seed = seed;
    run.hash = "h" + std::to_string(table.runs.size());
    run.status = "finished";
    run.blur_median_px = blur_px * (1 + 0.05 * random.Normal());
    run.frames = 200;
    const double growth = levels[2] == 0 ? 0.2 : 0.1;
    run.scores["coverage_ratio"] = std::min(1.0, 1.02 - 0.01 * blur_px * (levels[2] == 0 ? 2 : 1));
    if (blur_px < 15 || levels[2] == 1 || seed % 2 == 0) {  // the plain system loses half of the most blurred walks
      run.scores["ate_sim3_rmse_m"] = 0.02 * std::exp(growth * blur_px + 0.2 * random.Normal());
      run.scores["rotation_gain"] = 1 + 0.01 * random.Normal();
    }
    table.runs.push_back(run);
  }
};

}  // namespace gaitcam
