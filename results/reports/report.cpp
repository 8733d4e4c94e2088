#include "results/reports/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "algorithms/core/units.h"
#include "algorithms/io/whole_file.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/reports/report_charts.h"
#include "results/scoring/score_text.h"
#include "results/scoring/statistics.h"

namespace gaitcam {
namespace {

using internal::Banner;
using internal::Card;
using internal::Escape;
using internal::HasGait;
using internal::HasPoses;
using internal::JpegUri;
using internal::Key;
using internal::KeyEntry;
using internal::Panel;
using internal::ReportClock;
using internal::ThreeDigits;

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
    const auto with_live = [&](const std::string& note, const std::string& name, double factor = 1) {
      return s.live ? note + fmt::format("; live {}", ThreeDigits(factor * s.Value("live_" + name))) : note;
    };
    html += Card("Position error, Sim(3)", s.Value("ate_sim3_rmse_m"), "m",
                 with_live(fmt::format("root mean square over {} m walked, scale given away",
                                       ThreeDigits(s.Value("path_length_m"))),
                           "ate_sim3_rmse_m"));
    html += Card(
        "Position error, SE(3)", s.Value("ate_rmse_m"), "m",
        with_live(fmt::format("with the estimate's own scale, {} of the true one", ThreeDigits(s.Value("scale_ratio"))),
                  "ate_rmse_m"));
    html += Card("Drift", s.Value("drift_sim3_pct"), "%",
                 with_live("of the path walked, scale corrected", "drift_sim3_pct"));
    html += Card("Rotation error", s.Value("ate_rot_own_rmse_deg"), "\u00b0",
                 with_live("root mean square after the best-fitting rotation", "ate_rot_own_rmse_deg"));
    html += Card("Coverage", 100 * s.Value("coverage_ratio"), "%",
                 with_live(fmt::format("{} of {} frames have a pose", ScoreText(s.Value("tracked_frames")),
                                       ScoreText(s.Value("frames"))),
                           "coverage_ratio", 100));
    const double gain = s.Value("rotation_gain");
    html += Card("Rotation gain", gain, "",
                 std::isfinite(gain) ? "estimated over true total turn; 1 is right" : "the robot hardly turned");
  }
  for (const ReportSection& section : input.sections) html += section.cards;
  if (!input.frames.empty()) {
    html += Card("Motion blur", MedianBlur(input.frames), "px",
                 "length of an image point's path during the exposure, median");
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
    key.push_back({"sim3", "final estimate after Sim(3) alignment", "", "sim3"});
    if (input.scores->live) key.push_back({"purple", "live, after its own Sim(3) alignment", "", "live"});
    key.push_back({"se3", "final, after SE(3) alignment", "dashed", "se3"});
    if (internal::HasCovariances(input)) {
      key.push_back({"green",
                     fmt::format("95 % of its position by its covariance, {:g} times as large",
                                 internal::PathEllipseMagnification(input)),
                     "", "ellipses"});
    }
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

std::string Sections(const ReportInput& input) {
  std::string html;
  for (const ReportSection& section : input.sections) html += section.body;
  return html;
}

std::string OverTime(const ReportInput& input) {
  std::string html = "<h2>Over time</h2>\n";
  std::vector<KeyEntry> shades;
  const auto has = [&](TrackingStatus status) {
    return std::any_of(input.frames.begin(), input.frames.end(),
                       [&](const ReportFrame& f) { return f.live == status; });
  };
  if (has(TrackingStatus::kInitializing)) shades.push_back({"wait", "live: no map yet", "area"});
  if (has(TrackingStatus::kLost)) shades.push_back({"lost", "live: lost", "area"});
  if (HasPoses(input) && input.scores->Value(input.scores->live ? "live_jumps" : "jumps") > 0) {
    shades.push_back({"bad", input.scores->live ? "live: jump" : "jump", "dashed"});
  }
  const auto with_shades = [&](std::vector<KeyEntry> key) {
    key.insert(key.end(), shades.begin(), shades.end());
    return key;
  };
  if (HasPoses(input)) {
    std::vector<KeyEntry> key = {{"sim3", "final, after Sim(3) alignment", "", "sim3"},
                                 {"se3", "final, after SE(3) alignment", "dashed", "se3"}};
    if (input.scores->live) key.insert(key.begin() + 1, {"purple", "live, after Sim(3) alignment", "", "live"});
    html += Panel("error", "Position error", with_shades(key), 230);
    html += Panel("rotation", "Rotation error",
                  with_shades({{"purple", "after the rotation that fits orientations best", "", "own"},
                               {"se3", "after alignment of positions", "dashed", "rot"}}),
                  180);
  }
  if (internal::HasCovariances(input)) {
    html +=
        Panel("nees", "Squared error over stated covariance, per dimension: 1 is right",
              with_shades({{"sim3", "NEES", "", "nees"}, {"truth", "95 % band of one pose", "dashed", "band"}}), 180);
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
  const ReportClock clock(input);
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

std::string ScoreTable(const ReportInput& input) {
  if (!input.scores) return {};
  std::string html = "<h2>All scores</h2>\n";
  for (const std::string& remark : input.scores->remarks)
    html += "<p class=\"note\">Note: " + Escape(remark) + ".</p>\n";
  html +=
      "<div class=\"panel scroll\"><table>\n<thead><tr><th>name</th><th style=\"text-align: right\">final</th>"
      "<th style=\"text-align: right\">live</th><th>unit</th><th "
      "class=\"meaning\">meaning</th></tr></thead>\n<tbody>\n";
  std::optional<ScoreGroup> group;
  std::vector<ScoreRow> rows = JoinAnswers(input.scores->scores);
  for (const Score& score : input.scores->timing) rows.push_back({score, std::nullopt});
  const auto cell = [](double value) { return std::isfinite(value) ? ScoreText(value) : std::string("&ndash;"); };
  for (const ScoreRow& row : rows) {
    const Score& s = row.last;
    if (s.group != group) {
      html += fmt::format("<tr><th colspan=\"5\" scope=\"colgroup\">{}</th></tr>\n", Title(s.group));
    }
    group = s.group;
    html += fmt::format(
        "<tr><td><code>{}</code></td><td class=\"number\">{}</td><td class=\"number\">{}</td><td "
        "class=\"unit\">{}</td><td class=\"meaning\">{}</td></tr>\n",
        Escape(s.name), cell(s.value), row.live ? cell(*row.live) : "", Escape(s.unit), Escape(s.meaning));
  }
  return html + "</tbody></table></div>\n";
}

std::string Provenance(const ReportInput& input) {
  std::string html = "<h2>How it was made</h2>\n";
  std::vector<std::pair<std::string, std::string>> facts = input.facts;
  if (!input.renderer.empty()) facts.emplace_back("renderer", input.renderer);
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
  page.body = Header(input) + Banners(input) + Cards(input) + Film(input) + Paths(input) + Sections(input) +
              OverTime(input) + Strip(input) + ScoreTable(input) + Provenance(input);
  page.data = internal::ReportChartData(input);
  page.style = internal::PageFile("report.css");
  for (const ReportSection& section : input.sections) page.style += section.style;
  page.script = internal::PageFile("report.js");
  return internal::PageHtml(page, options.chart_library);
}

void WriteReport(const std::filesystem::path& path, const ReportInput& input, const ReportOptions& options) {
  WriteWholeFile(path, ReportHtml(input, options));
}

}  // namespace gaitcam
