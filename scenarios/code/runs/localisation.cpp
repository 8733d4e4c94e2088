#include "scenarios/code/runs/localisation.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/places/place_recognition.h"
#include "results/reports/report_places.h"
#include "results/scoring/score_text.h"
#include "results/scoring/statistics.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/place_cache.h"
#include "scenarios/code/runs/progress.h"
#include "scenarios/code/runs/renderer_record.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
constexpr double kDeg = 180 / std::numbers::pi;
constexpr size_t kTrainingPanoramas = 24;  ///< For methods that learn: so many of the references themselves.

double MsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Those of the cache, else made now and kept there.
PlaceViews ViewsOf(const ResolvedScenario& resolved, const RunOptions& options, Progress& progress) {
  const PlaceCache cache(options.cache, resolved);
  if (std::optional<PlaceViews> kept = cache.Read()) {
    kept->grid = GridOf(*resolved.scenario.localisation);
    return std::move(*kept);
  }
  PlaceViews views = MakePlaceViews(resolved, [&](int done, int all) {
    progress.Update(done, all);
    return !options.interrupted();
  });
  if (!options.interrupted()) cache.Write(views);
  return views;
}

/// One method's answers to all views.
struct MethodRun {
  PlaceMethodCost cost;
  std::vector<PlaceAnswer> answers;
  std::vector<PlaceScore> scores;
};

std::vector<cv::Mat> Training(const PlaceViews& views) {
  std::vector<cv::Mat> training;
  const size_t n = views.references.size(), count = std::min(n, kTrainingPanoramas);
  for (size_t i = 0; i < count; ++i) training.push_back(views.references[i * n / count].panorama);
  return training;
}

PlaceAnswer AnswerOf(const std::vector<PlaceMatch>& matches) {
  PlaceAnswer answer;
  for (const PlaceMatch& match : matches) {
    answer.similarity.push_back(match.similarity);
    answer.bearing_rad.push_back(match.bearing_rad);
  }
  return answer;
}

MethodRun AskMethod(const std::string& method, const PlaceViews& views, const LocalisationOptions& options,
                    uint64_t seed) {
  const PlaceIndexSetup setup{views.layout, views.view_width_px, Training(views), seed, options.wavelet};
  const std::unique_ptr<PlaceIndex> index = MakePlaceIndex(method, setup);
  MethodRun run;
  std::vector<double> add_ms, query_ms, headings;
  for (const PlaceReference& reference : views.references) {
    const auto start = Clock::now();
    index->Add(reference.panorama);
    add_ms.push_back(MsSince(start));
    headings.push_back(reference.heading_rad);
  }
  for (const PlaceQuery& query : views.queries) {
    const auto start = Clock::now();
    const std::vector<PlaceMatch> matches = index->Query(query.view);
    query_ms.push_back(MsSince(start));
    run.answers.push_back(AnswerOf(matches));
    run.scores.push_back(ScorePlace(views.grid, run.answers.back(), query.position_m, query.heading_rad, headings));
  }
  run.cost = {method, index->bytes_per_place(), MedianOf(add_ms), MedianOf(query_ms), QuantileOf(query_ms, 0.95)};
  return run;
}

std::vector<PlaceSummary> Summaries(const PlaceViews& views, const std::vector<MethodRun>& runs,
                                    const std::vector<std::string>& conditions) {
  std::vector<PlaceSummary> summaries;
  for (const MethodRun& run : runs) {
    for (const std::string& condition : conditions) {
      std::vector<PlaceScore> scores;
      for (size_t i = 0; i < views.queries.size(); ++i) {
        if (views.queries[i].condition == condition) scores.push_back(run.scores[i]);
      }
      if (!scores.empty()) summaries.push_back(Summarise(run.cost.method, condition, scores));
    }
  }
  return summaries;
}

std::string Csv(const PlaceViews& views, const std::vector<MethodRun>& runs) {
  std::string text =
      "query,condition,x_m,y_m,heading_deg,covered_ratio,blur_median_px,method,found,nearest,best,best_x_m,best_y_m,"
      "position_error_m,bearing_error_deg,similarity,peak_area_ratio,peak_area_range_ratio,modes\n";
  for (size_t i = 0; i < views.queries.size(); ++i) {
    const PlaceQuery& q = views.queries[i];
    for (const MethodRun& run : runs) {
      const PlaceScore& s = run.scores[i];
      const Eigen::Vector2d best = views.grid.At(s.best);
      text += fmt::format("{},{},{:.4f},{:.4f},{:.3f},{:.4f},{:.3f},", i, q.condition, q.position_m.x(),
                          q.position_m.y(), q.heading_rad * kDeg, q.covered_ratio, q.blur_px);
      text += fmt::format("{},{},{},{},{:.4f},{:.4f},{:.4f},{:.3f},{:.6g},{:.4f},{:.4f},{}\n", run.cost.method,
                          int(s.found), s.nearest, s.best, best.x(), best.y(), s.position_error_m, s.bearing_error_deg,
                          s.similarity, s.of_maximum.area_ratio, s.of_range.area_ratio, s.of_range.modes);
    }
  }
  return text;
}

/// Views that the page shows: the first plain ones and the first one of each other condition, as they come.
std::vector<size_t> ShownQueries(const PlaceViews& views, int plain) {
  std::vector<size_t> shown;
  std::string last;
  for (size_t i = 0; i < views.queries.size(); ++i) {
    const std::string& condition = views.queries[i].condition;
    const bool first = condition != last;
    last = condition;
    if (condition == "plain" ? int(i) < plain : first && plain > 0) shown.push_back(i);
  }
  return shown;
}

PlaceExample ExampleOf(const PlaceViews& views, const std::vector<MethodRun>& runs, size_t query) {
  constexpr int kMapWidth_px = 560;
  const PlaceQuery& q = views.queries[query];
  PlaceExample example;
  example.title = fmt::format("{}, view {}", q.condition, query);
  example.image = q.image;
  const PlaceScore& first = runs.front().scores[query];
  example.panorama = views.references[first.best].panorama;
  example.window_width_px = views.view_width_px;
  const double bearing = runs.front().answers[query].bearing_rad[first.best];
  example.window_left_px = views.layout.ColumnOf(bearing) - 0.5 * (views.view_width_px - 1);
  for (const MethodRun& run : runs) {
    if (example.methods.size() == 2) break;  // side by side, as the thesis shows them
    example.methods.push_back(run.cost.method);
    example.scores.push_back(run.scores[query]);
    example.maps.push_back(HeatMap(views.grid, run.answers[query].similarity, q.position_m, kMapWidth_px));
  }
  return example;
}

void WriteHeatMaps(const std::vector<PlaceExample>& examples, const fs::path& folder) {
  if (examples.empty()) return;
  fs::create_directories(folder);
  for (const PlaceExample& example : examples) {
    for (size_t m = 0; m < example.maps.size(); ++m) {
      std::string name = example.title + "_" + example.methods[m] + ".png";
      std::replace(name.begin(), name.end(), ' ', '_');
      std::erase(name, ',');
      if (!cv::imwrite((folder / name).string(), example.maps[m]))
        throw MissingResource("cannot write " + (folder / name).string());
    }
  }
}

/// What was made, beside how well it was recognised.
std::vector<Score> ViewScores(const PlaceViews& views) {
  std::vector<double> seams, frames, covered, blur;
  for (const PlaceReference& r : views.references) {
    seams.push_back(r.seam_error_px);
    frames.push_back(r.frames);
  }
  std::vector<Score> scores{
      {"references", double(views.references.size()), "", "panoramas of known places"},
      {"queries", double(views.queries.size()), "", "views of all conditions"},
      {"panorama_frames_median", MedianOf(frames), "", "frames of a panorama, median"},
      {"panorama_seam_error_median_px", MedianOf(seams), "px", "mean seam error of a panorama, median", Better::kLower},
      {"view_width_px", double(views.view_width_px), "px", "width of a view in the panorama's pixels"}};
  for (const PlaceQuery& q : views.queries) {
    if (q.covered_ratio > 0) covered.push_back(q.covered_ratio);
    if (q.condition.starts_with("walk_")) blur.push_back(q.blur_px);
  }
  if (!covered.empty())
    scores.push_back(
        {"occlusion_covered_median_ratio", MedianOf(covered), "", "share of a view behind pasted robots, median"});
  if (!blur.empty())
    scores.push_back({"walk_blur_median_px", MedianOf(blur), "px", "motion blur of views while walking, median"});
  return scores;
}

std::string WithUnit(const Score& score) {
  return ScoreText(score.value) + (score.unit.empty() ? "" : " " + score.unit);
}

std::string ScoresFile(const Scores& scores, const PlaceViews& views, const std::string& status, uint64_t seed) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(ScoresToJson(scores));
  json.erase("alignment");  // nothing was aligned
  json["run"] = {{"status", status}, {"seed", seed}};
  WriteRenderer(views.renderer, json["run"]);
  return json.dump(2) + "\n";
}

PlaceReportInput ReportOf(const ResolvedScenario& resolved, const PlaceViews& views, const std::string& status) {
  const Scenario& s = resolved.scenario;
  PlaceReportInput report;
  report.title = s.name;
  report.subtitle = fmt::format("{} in {}: {} panoramas of {} x {} px, {} views of {} x {} px", resolved.robot.name,
                                resolved.scene.name, views.references.size(), views.layout.width_px,
                                views.layout.height_px, views.queries.size(), s.camera.width_px, s.camera.height_px);
  report.status = status;
  report.renderer = views.renderer.ToText();
  report.software_renderer = views.renderer.is_software;
  for (const std::string& condition : PlaceConditions(*s.localisation))
    report.conditions.emplace_back(condition, PlaceConditionText(condition));
  report.resolved_scenario = resolved.ToYaml();
  report.facts = RunFacts(s.seed);
  for (const Score& score : ViewScores(views)) report.facts.emplace_back(score.meaning, WithUnit(score));
  return report;
}

}  // namespace

RunOutcome RunLocalisation(const ResolvedScenario& resolved, const RunOptions& options) {
  const Scenario& scenario = resolved.scenario;
  CheckPlaceViews(resolved);
  OutputFolder folder(options.out, "scores.json");
  Progress progress(scenario.name, 0, options.quiet);
  const auto started = Clock::now();
  const PlaceViews views = ViewsOf(resolved, options, progress);
  progress.Finish();
  RunOutcome outcome;
  outcome.folder = options.out;
  outcome.end_time_s = 1e-3 * MsSince(started);
  outcome.status = options.interrupted() ? "interrupted" : "finished";
  if (views.references.size() < views.grid.size() || views.queries.empty()) {
    outcome.no_scores_reason = "not all places were seen, and nothing was written";
    return outcome;
  }

  const std::vector<std::string>& wanted = scenario.localisation->methods;
  std::vector<MethodRun> runs;
  for (const std::string& method : wanted.empty() ? PlaceIndexNames() : wanted)
    runs.push_back(AskMethod(method, views, *scenario.localisation, scenario.seed));

  PlaceReportInput report = ReportOf(resolved, views, outcome.status);
  for (const MethodRun& run : runs) report.methods.push_back(run.cost);
  report.summaries = Summaries(views, runs, PlaceConditions(*scenario.localisation));
  for (const size_t query : ShownQueries(views, scenario.localisation->heat_maps))
    report.examples.push_back(ExampleOf(views, runs, query));
  Scores scores = PlaceScores(report.summaries, report.methods);
  const std::vector<Score> of_views = ViewScores(views);
  scores.scores.insert(scores.scores.begin(), of_views.begin(), of_views.end());
  outcome.table = PlaceTable(report.summaries, report.methods);

  folder.WriteText("localisation.csv", Csv(views, runs));
  folder.WriteText("scenario.yaml", report.resolved_scenario);
  folder.WriteText("scores.json", ScoresFile(scores, views, outcome.status, scenario.seed));
  WriteHeatMaps(report.examples, folder.path() / "heatmaps");
  folder.WriteText("report.html", PlaceReportHtml(report));
  folder.Commit();
  outcome.scores = std::move(scores);
  return outcome;
}

}  // namespace gaitcam
