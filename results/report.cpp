#include "results/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "algorithms/core/errors.h"
#include "results/html_page.h"
#include "results/metrics.h"
#include "results/report_graph.h"
#include "results/report_map.h"
#include "results/report_page.h"
#include "results/statistics.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;
using internal::Banner;
using internal::Card;
using internal::Escape;
using internal::JpegUri;
using internal::Key;
using internal::KeyEntry;
using internal::Panel;
using internal::ThreeDigits;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- What the charts are drawn from
// -----------------------------------------------------------------------------------

/// A number with about a tenth of a millimetre of room: enough for a chart, and short in the file.
Json Rounded(double value) { return std::isfinite(value) ? Json(std::round(value * 1e4) / 1e4) : Json(nullptr); }

Json Column(size_t count, const auto& value_at) {
  Json column = Json::array();
  for (size_t i = 0; i < count; ++i) column.push_back(Rounded(value_at(i)));
  return column;
}

/// The run's clock starts at its first frame (or true pose).
struct Clock {
  int64_t zero_ns = 0, end_ns = 0;
  explicit Clock(const ReportInput& input) {
    if (!input.frames.empty()) {
      zero_ns = input.frames.front().stamp_ns;
      end_ns = input.frames.back().stamp_ns;
    } else if (!input.truth.empty()) {
      zero_ns = input.truth.front().stamp_ns;
      end_ns = input.truth.back().stamp_ns;
    }
  }
  double Seconds(int64_t stamp_ns) const { return double(stamp_ns - zero_ns) * 1e-9; }
};

/// Median distance of successive stamps, s; 0 for less than two.
double UsualInterval(const Trajectory& trajectory) {
  std::vector<double> gaps;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    gaps.push_back(double(trajectory[i].stamp_ns - trajectory[i - 1].stamp_ns) * 1e-9);
  }
  return gaps.empty() ? 0 : MedianOf(gaps);
}

/// Columns x, y, z; a null where there was no pose for a while, so that no line is drawn across.
Json PathJson(const Trajectory& trajectory) {
  Json x = Json::array(), y = Json::array(), z = Json::array();
  const double longest = 2.5 * UsualInterval(trajectory);
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && double(trajectory[i].stamp_ns - trajectory[i - 1].stamp_ns) * 1e-9 > longest) {
      for (Json* column : {&x, &y, &z}) column->push_back(nullptr);
    }
    const Eigen::Vector3d& p = trajectory[i].pose.translation;
    x.push_back(Rounded(p.x()));
    y.push_back(Rounded(p.y()));
    z.push_back(Rounded(p.z()));
  }
  return {{"x", x}, {"y", y}, {"z", z}};
}

bool HasPoses(const ReportInput& input) { return input.scores && input.scores->HasPoses(); }

Json PathsJson(const ReportInput& input) {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e300), high = -low;
  for (const StampedPose& p : input.truth) {
    low = low.min(p.pose.translation.array());
    high = high.max(p.pose.translation.array());
  }
  Json json = {{"truth", PathJson(input.truth)}};
  json["side_axis"] = high.y() - low.y() > high.x() - low.x() ? "y" : "x";  // the side from which most is seen
  if (HasPoses(input)) {
    json["sim3"] = PathJson(input.scores->aligned_sim3);
    json["se3"] = PathJson(input.scores->aligned_se3);
  }
  return json;
}

Json ErrorsJson(const Scores& scores, const Clock& clock) {
  const std::vector<PosePair>& pairs = scores.pairs;
  Trajectory stamps;
  for (const PosePair& p : pairs) stamps.push_back({p.stamp_ns, p.truth});
  const double longest = 2.5 * UsualInterval(stamps);
  Json t = Json::array(), se3 = Json::array(), sim3 = Json::array(), rot = Json::array(), own = Json::array();
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (i > 0 && double(pairs[i].stamp_ns - pairs[i - 1].stamp_ns) * 1e-9 > longest) {
      t.push_back(Rounded(clock.Seconds(pairs[i].stamp_ns)));
      for (Json* column : {&se3, &sim3, &rot, &own}) column->push_back(nullptr);
    }
    t.push_back(Rounded(clock.Seconds(pairs[i].stamp_ns)));
    se3.push_back(Rounded(scores.error_se3_m[i]));
    sim3.push_back(Rounded(scores.error_sim3_m[i]));
    rot.push_back(Rounded(scores.error_rot_deg[i]));
    own.push_back(Rounded(scores.error_rot_own_deg[i]));
  }
  // Errors in a foreign scale would press those in the true one flat on the axis: left to a click.
  const bool hide_se3 = scores.Value("ate_rmse_m") > 4 * scores.Value("ate_sim3_rmse_m");
  const bool hide_rot = scores.Value("ate_rot_rmse_deg") > 4 * scores.Value("ate_rot_own_rmse_deg");
  return {{"t", t},     {"se3", se3},           {"sim3", sim3},        {"rot", rot},
          {"own", own}, {"hide_se3", hide_se3}, {"hide_rot", hide_rot}};
}

Json HeadingJson(const Scores& scores, const Clock& clock) {
  const TurnCourse course = MeasureTurnCourse(scores.pairs);
  const size_t n = scores.pairs.size();
  const double degrees = 180 / std::numbers::pi;
  return {{"t", Column(n, [&](size_t i) { return clock.Seconds(scores.pairs[i].stamp_ns); })},
          {"truth", Column(n, [&](size_t i) { return course.truth[i] * degrees; })},
          {"estimate", Column(n, [&](size_t i) { return course.estimate[i] * degrees; })}};
}

Json FramesJson(const std::vector<ReportFrame>& frames, const Clock& clock) {
  const size_t n = frames.size();
  return {{"t", Column(n, [&](size_t i) { return clock.Seconds(frames[i].stamp_ns); })},
          {"blur_median", Column(n, [&](size_t i) { return frames[i].blur_median_px; })},
          {"blur_p90", Column(n, [&](size_t i) { return frames[i].blur_p90_px; })},
          {"blur_max", Column(n, [&](size_t i) { return frames[i].blur_max_px; })},
          {"features", Column(n, [&](size_t i) { return double(frames[i].features); })},
          {"inliers", Column(n, [&](size_t i) { return double(frames[i].inliers); })}};
}

/// Times between which `holds` is true of the frames: each frame stands for the time halfway to its neighbours.
std::vector<std::pair<double, double>> Spans(const std::vector<ReportFrame>& frames, const Clock& clock,
                                             const auto& holds) {
  std::vector<std::pair<double, double>> spans;
  const auto edge = [&](size_t i) {  // between frames i - 1 and i
    if (i == 0) return clock.Seconds(frames.front().stamp_ns);
    if (i == frames.size()) return clock.Seconds(frames.back().stamp_ns);
    return 0.5 * (clock.Seconds(frames[i - 1].stamp_ns) + clock.Seconds(frames[i].stamp_ns));
  };
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!holds(frames[i])) continue;
    const size_t begin = i;
    while (i + 1 < frames.size() && holds(frames[i + 1])) ++i;
    spans.emplace_back(edge(begin), edge(i + 1));
  }
  return spans;
}

Json StatusSpansJson(const std::vector<ReportFrame>& frames, const Clock& clock) {
  Json json = Json::array();
  for (const TrackingStatus status : {TrackingStatus::kInitializing, TrackingStatus::kLost}) {
    for (const auto& [from, to] : Spans(frames, clock, [&](const ReportFrame& f) { return f.status == status; })) {
      json.push_back({Rounded(from), Rounded(to), ToString(status)});
    }
  }
  return json;
}

Json GaitJson(const std::vector<ReportFrame>& frames, const Clock& clock) {
  Json rows = Json::array();
  for (const int side : {0, 1}) {
    Json points = Json::array();
    const auto touches = [&](const ReportFrame& f) {
      return f.has_gait && (side == 0 ? f.left_contact : f.right_contact);
    };
    for (const auto& [from, to] : Spans(frames, clock, touches)) {
      const int row = side == 0 ? 2 : 1;
      points.push_back({{"x", Rounded(from)}, {"y", row}});
      points.push_back({{"x", Rounded(to)}, {"y", row}});
      points.push_back({{"x", Rounded(to)}, {"y", nullptr}});
    }
    rows.push_back(
        {{"name", side == 0 ? "left foot" : "right foot"}, {"colour", side == 0 ? "sim3" : "se3"}, {"points", points}});
  }
  return {{"rows", rows}};
}

bool HasGait(const ReportInput& input) {
  return std::any_of(input.frames.begin(), input.frames.end(),
                     [](const ReportFrame& f) { return f.has_gait && (f.left_contact || f.right_contact); });
}

Json ChartData(const ReportInput& input) {
  const Clock clock(input);
  Json json;
  json["t_min"] = 0;
  json["t_max"] = Rounded(clock.Seconds(clock.end_ns));
  json["path"] = PathsJson(input);
  if (HasPoses(input)) {
    json["error"] = ErrorsJson(*input.scores, clock);
    json["heading"] = HeadingJson(*input.scores, clock);
  }
  json["frames"] = FramesJson(input.frames, clock);
  json["spans"] = StatusSpansJson(input.frames, clock);
  json["restarts"] = Json::array();
  for (const ReportFrame& f : input.frames) {
    if (f.restarted) json["restarts"].push_back(Rounded(clock.Seconds(f.stamp_ns)));
  }
  if (HasGait(input)) json["gait"] = GaitJson(input.frames, clock);
  return json;
}

// ---- The page, from top to bottom
// -------------------------------------------------------------------------------------

std::string Header(const ReportInput& input) {
  std::string pill;
  switch (input.end) {
    case RunEnd::kFinished: pill = "<span class=\"pill good\">&#10003; finished</span>"; break;
    case RunEnd::kFell:
      pill = fmt::format("<span class=\"pill bad\">&#9888; fell at {:.1f} s</span>", input.end_time_s);
      break;
    case RunEnd::kInterrupted:
      pill = fmt::format("<span class=\"pill warn\">&#9632; interrupted at {:.1f} s</span>", input.end_time_s);
      break;
  }
  return fmt::format("<header>\n<span class=\"brand\">gaitcam run</span>\n<h1>{}</h1>\n{}\n<p>{}</p>\n</header>\n",
                     Escape(input.title), pill, Escape(input.subtitle));
}

std::string Banners(const ReportInput& input) {
  std::string html;
  if (input.end == RunEnd::kFell) {
    html += Banner("bad", fmt::format("The robot fell after {:.1f} s.", input.end_time_s),
                   "What was filmed until then is kept; the rest of the path was never walked.");
  }
  if (input.end == RunEnd::kInterrupted) {
    html += Banner("warn", fmt::format("The run was interrupted after {:.1f} s.", input.end_time_s),
                   "What was finished until then is kept.");
  }
  if (!input.scores) {
    html += Banner("bad", "There are no scores.", input.no_scores_reason);
  } else if (HasPoses(input) && input.scores->Value("coverage_ratio") < input.min_good_coverage_ratio) {
    html += Banner("bad",
                   fmt::format("Low coverage: only {:.0f} % of the frames have a pose.",
                               100 * input.scores->Value("coverage_ratio")),
                   "The errors below say nothing of the rest.");
  }
  if (input.software_renderer) {
    html +=
        Banner("warn", "Rendered in software.",
               "Times are not those of a machine with a graphics processor, and its pictures may differ in single grey "
               "levels. Renderer: " +
                   input.renderer);
  }
  return html;
}

double MedianBlur(const std::vector<ReportFrame>& frames) {
  std::vector<double> blur;
  blur.reserve(frames.size());
  for (const ReportFrame& f : frames) blur.push_back(f.blur_median_px);
  return blur.empty() ? kNaN : MedianOf(blur);
}

std::string Cards(const ReportInput& input) {
  std::string html = "<dl class=\"cards\">\n";
  if (HasPoses(input)) {
    const Scores& s = *input.scores;
    html += Card(
        "Position error, Sim(3)", s.Value("ate_sim3_rmse_m"), "m",
        fmt::format("root mean square along {} m of path, scale given away", ThreeDigits(s.Value("path_length_m"))));
    html += Card("Position error, SE(3)", s.Value("ate_rmse_m"), "m",
                 fmt::format("with the estimate's own scale: {} of the true one", ThreeDigits(s.Value("scale_ratio"))));
    html += Card("Drift", s.Value("drift_sim3_pct"), "%", "of the distance gone, scale corrected");
    html += Card("Rotation error", s.Value("ate_rot_own_rmse_deg"), "\u00b0",
                 "root mean square after the best-fitting rotation");
    html += Card(
        "Coverage", 100 * s.Value("coverage_ratio"), "%",
        fmt::format("{} of {} frames have a pose", ScoreText(s.Value("tracked_frames")), ScoreText(s.Value("frames"))));
    const double gain = s.Value("rotation_gain");
    html += Card("Rotation gain", gain, "",
                 std::isfinite(gain) ? "estimated over true total turn; 1 is right" : "the robot hardly turned");
  }
  if (input.map && !input.map->empty()) html += internal::MapCards(*input.map);
  if (input.places) html += internal::PlaceCards(*input.places);
  if (!input.frames.empty()) {
    html += Card("Motion blur", MedianBlur(input.frames), "px", "median over frames of the median blur extent");
  }
  if (input.scores && !input.scores->timing.empty() && input.scores->timing.front().name == "track_ms_mean") {
    html += Card("Tracking time", input.scores->Value("track_ms_mean"), "ms",
                 fmt::format("per frame; 95 % below {} ms", ThreeDigits(input.scores->Value("track_ms_p95"))));
  }
  return html + "</dl>\n";
}

std::string Film(const ReportInput& input) {
  if (input.video_file.empty()) return {};
  const std::string poster =
      input.video_poster.empty() ? "" : fmt::format(" poster=\"{}\"", JpegUri(input.video_poster, 1280));
  return fmt::format(
      "<section class=\"film\"><h2>The walk</h2>\n<video controls muted loop playsinline preload=\"none\" "
      "src=\"{}\"{}></video></section>\n",
      Escape(input.video_file), poster);
}

/// Length over width of the true path, seen from above.
double Elongation(const Trajectory& truth) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
  for (const StampedPose& p : truth) {
    low = low.min(p.pose.translation.head<2>().array());
    high = high.max(p.pose.translation.head<2>().array());
  }
  return (high.x() - low.x()) / std::max(high.y() - low.y(), 1e-3);
}

std::string Paths(const ReportInput& input) {
  if (input.truth.empty()) return {};
  std::vector<KeyEntry> key = {{"truth", "truth (circle: start, diamond: end)"}};
  std::string heading;
  if (HasPoses(input)) {
    key.push_back({"sim3", "estimate after Sim(3) alignment", "", "sim3"});
    key.push_back({"se3", "after SE(3) alignment", "dashed", "se3"});
    heading = Panel("heading", "Turned about the vertical", {{"truth", "truth"}, {"sim3", "estimate"}}, 165);
  }
  const std::string head = "<h2>Path</h2>\n" + Key(key, "top side");
  if (Elongation(input.truth) > 3) {
    return head + Panel("top", "From above", {}, 220) + "<div class=\"grid halves\">\n" +
           Panel("side", "From the side", {}, 180) + heading + "</div>\n";
  }
  return head + "<div class=\"grid two\">\n" + Panel("top", "From above", {}, heading.empty() ? 320 : 405) + "<div>\n" +
         Panel("side", "From the side", {}, heading.empty() ? 320 : 138) + heading + "</div></div>\n";
}

/// The estimated path as the map shows it: where the pictures' alignment puts both.
std::string Map(const ReportInput& input) {
  if (!input.map || input.map->empty() || !input.scores) return {};
  const FloorMotion X_WW = input.map->X_WV * input.map->X_WV_trajectory.Inverse();
  return internal::MapSection(*input.map, internal::FloorPath(input.truth, {}),
                              internal::FloorPath(input.scores->aligned_se3, X_WW));
}

std::string Places(const ReportInput& input) {
  return input.places ? internal::PlaceSection(*input.places, *input.graph) : std::string();
}

std::string OverTime(const ReportInput& input) {
  std::string html = "<h2>Over time</h2>\n";
  std::vector<KeyEntry> shades;
  const auto has = [&](TrackingStatus status) {
    return std::any_of(input.frames.begin(), input.frames.end(),
                       [&](const ReportFrame& f) { return f.status == status; });
  };
  if (has(TrackingStatus::kInitializing)) shades.push_back({"wait", "no pose yet", "area"});
  if (has(TrackingStatus::kLost)) shades.push_back({"lost", "lost", "area"});
  if (std::any_of(input.frames.begin(), input.frames.end(), [](const ReportFrame& f) { return f.restarted; })) {
    shades.push_back({"bad", "world chosen anew", "dashed"});
  }
  const auto with_shades = [&](std::vector<KeyEntry> key) {
    key.insert(key.end(), shades.begin(), shades.end());
    return key;
  };
  if (HasPoses(input)) {
    html += Panel("error", "Position error",
                  with_shades({{"sim3", "after Sim(3) alignment", "", "sim3"},
                               {"se3", "after SE(3) alignment", "dashed", "se3"}}),
                  230);
    html += Panel("rotation", "Rotation error",
                  with_shades({{"purple", "after the rotation that fits orientations best", "", "own"},
                               {"se3", "after alignment of positions", "dashed", "rot"}}),
                  180);
  }
  if (!input.frames.empty()) {
    html += Panel("blur", "Motion blur: how far image points move during the exposure",
                  with_shades({{"sim3", "median over the image", "", "median"},
                               {"green", "90th percentile", "", "p90"},
                               {"se3", "largest", "", "max"}}),
                  220);
    html += Panel("inliers", "What the system found",
                  with_shades({{"sim3", "inliers", "", "inliers"}, {"green", "features", "", "features"}}), 200);
  }
  if (HasGait(input)) html += Panel("gait", "Feet on the floor", {{"sim3", "left"}, {"se3", "right"}}, 120);
  return input.scores || !input.frames.empty() ? html : std::string();
}

std::string Strip(const ReportInput& input) {
  if (input.twins.empty()) return {};
  const Clock clock(input);
  std::string html =
      "<h2>Frames and their sharp twins</h2>\n<p class=\"note\">Above, the frame as the camera exposed it: light "
      "integrated "
      "while the shutter was open, with noise. Below, one instant in the middle of the same exposure.</p>\n<div "
      "class=\"strip\">\n";
  for (const ReportTwin& twin : input.twins) {
    const std::string when = fmt::format("{:.2f} s", clock.Seconds(twin.stamp_ns));
    html += fmt::format(
        "<figure><span class=\"shot\"><img alt=\"exposed frame at {0}\" src=\"{1}\"><span>exposed</span></span><span "
        "class=\"shot\"><img alt=\"sharp twin at {0}\" src=\"{2}\"><span>sharp</span></span><figcaption><b>{0}</b> "
        "&middot; "
        "blur {3:.1f} px median, {4:.1f} px largest</figcaption></figure>\n",
        when, JpegUri(twin.blurred, 400), JpegUri(twin.sharp, 400), twin.blur_median_px, twin.blur_max_px);
  }
  return html + "</div>\n";
}

std::string GroupOf(const std::string& name) {
  const auto starts = [&](std::string_view prefix) { return name.rfind(prefix, 0) == 0; };
  if (starts("ate_")) return "Absolute error";
  if (starts("rpe_")) return "Relative error";
  if (starts("drift") || starts("end_drift")) return "Drift";
  if (starts("map_")) return "Map";
  if (starts("place_") || starts("loop")) return "Places and loops";
  if (starts("scale") || starts("turn") || starts("rotation")) return "Scale and turning";
  if (starts("track_ms") || starts("peak_memory")) return "Time and memory: differ from run to run";
  return "Coverage";
}

std::string ScoreTable(const ReportInput& input) {
  if (!input.scores) return {};
  std::string html = "<h2>All scores</h2>\n";
  for (const std::string& remark : input.scores->remarks)
    html += "<p class=\"note\">Note: " + Escape(remark) + ".</p>\n";
  html +=
      "<div class=\"panel scroll\"><table>\n<thead><tr><th>name</th><th style=\"text-align: right\">value</th>"
      "<th>unit</th><th class=\"meaning\">meaning</th></tr></thead>\n<tbody>\n";
  std::string group;
  for (const std::vector<Score>* list : {&input.scores->scores, &input.scores->timing}) {
    for (const Score& s : *list) {
      const std::string its_group =
          list == &input.scores->timing ? "Time and memory: differ from run to run" : GroupOf(s.name);
      if (its_group != group) html += fmt::format("<tr><th colspan=\"4\" scope=\"colgroup\">{}</th></tr>\n", its_group);
      group = its_group;
      html += fmt::format(
          "<tr><td><code>{}</code></td><td class=\"number\">{}</td><td class=\"unit\">{}</td><td "
          "class=\"meaning\">{}</td></tr>\n",
          Escape(s.name), std::isfinite(s.value) ? ScoreText(s.value) : "&ndash;", Escape(s.unit), Escape(s.meaning));
    }
  }
  return html + "</tbody></table></div>\n";
}

std::string Provenance(const ReportInput& input) {
  std::string html = "<h2>How it was made</h2>\n";
  std::vector<std::pair<std::string, std::string>> facts = input.facts;
  if (!input.renderer.empty())
    facts.emplace_back("renderer", input.renderer + (input.software_renderer ? " (software)" : ""));
  html += internal::Facts(facts);
  if (!input.resolved_scenario.empty()) {
    html += fmt::format("<details class=\"panel\"><summary>Resolved scenario</summary><pre>{}</pre></details>\n",
                        Escape(input.resolved_scenario));
  }
  return html;
}

}  // namespace

std::string ReportHtml(const ReportInput& input, const ReportOptions& options) {
  internal::HtmlPage page;
  page.title = input.title;
  page.body = Header(input) + Banners(input) + Cards(input) + Film(input) + Paths(input) + Map(input) + Places(input) +
              OverTime(input) + Strip(input) + ScoreTable(input) + Provenance(input);
  page.data = ChartData(input).dump();
  const bool has_map = input.map && !input.map->empty();
  const std::string style = std::string(internal::ReportStyle()) + std::string(has_map ? internal::MapStyle() : "") +
                            std::string(input.places ? internal::PlaceStyle() : "");
  page.style = style;
  page.script = internal::ReportScript();
  return internal::PageHtml(page, options.chart_library);
}

void WriteReport(const std::filesystem::path& path, const ReportInput& input, const ReportOptions& options) {
  const std::string html = ReportHtml(input, options);
  std::filesystem::path temporary = path;
  temporary += ".partial";
  std::error_code error;
  {
    std::ofstream file(temporary, std::ios::binary);
    file << html;
    file.close();
    if (!file) throw MissingResource(path.string() + ": the report cannot be written there");
  }
  std::filesystem::rename(temporary, path, error);
  if (error) throw MissingResource(path.string() + ": the report cannot be written there: " + error.message());
}

}  // namespace gaitcam
