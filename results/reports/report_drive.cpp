#include "results/reports/report_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "results/reports/ground_drawing.h"
#include "results/reports/html_page.h"
#include "results/reports/page_file.h"
#include "results/scoring/score_text.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;

constexpr double kNear_m = 4;  // people farther from the way are not drawn

std::vector<Vector2d> TruePath(const DriveComparison& comparison) {
  std::vector<Vector2d> path;
  for (const DrivenStep& step : comparison.steps) {
    if (step.at_m.allFinite()) path.push_back(step.at_m);
  }
  return path;
}

bool IsNear(const Vector2d& p, const std::vector<Vector2d>& path) {
  return std::any_of(path.begin(), path.end(), [&](const Vector2d& q) { return (p - q).norm() < kNear_m; });
}

/// The parts of a person's track that lie near the path.
std::string Track(const internal::GroundDrawing& ground, const std::vector<Vector2d>& person,
                  const std::vector<Vector2d>& path) {
  std::string svg;
  std::vector<Vector2d> part;
  const auto draw = [&] {
    if (part.size() > 1 && (part.front() - part.back()).norm() > 0.1) svg += ground.Path(part, "person");
    if (!part.empty()) svg += ground.Circle(part.back(), 0.25, "person");
    part.clear();
  };
  constexpr size_t kEvery = 4;
  for (size_t i = 0; i < person.size(); i += kEvery) {
    if (IsNear(person[i], path)) {
      part.push_back(person[i]);
    } else {
      draw();
    }
  }
  draw();
  return svg;
}

std::string Drawing(const DriveComparison& comparison, const TaughtDrive& drive) {
  const std::vector<Vector2d> path = TruePath(comparison);
  std::vector<Vector2d> all = path;
  for (const auto& taught : comparison.taught_m) all.insert(all.end(), taught.begin(), taught.end());
  const internal::GroundDrawing ground(all);
  std::string svg;
  for (const auto& person : comparison.people_m) svg += Track(ground, person, path);
  for (const auto& taught : comparison.taught_m) svg += ground.Path(taught, "taught");
  svg += ground.Path(path);
  for (size_t s = 0; s < drive.steps.size(); ++s) {
    const DriveStep& step = drive.steps[s];
    const Vector2d& at = comparison.steps[s].at_m;
    if (!at.allFinite()) continue;
    if (step.state == DriveState::kWaiting) svg += ground.Circle(at, 1.3 * ground.unit(), "waits");
    if (step.confirmed) svg += ground.Circle(at, 0.45 * ground.unit(), "confirmed");
    if (step.found) svg += ground.Circle(at, 2 * ground.unit(), "ring");
  }
  if (!comparison.taught_m.empty() && !comparison.taught_m.back().empty())
    svg += ground.Circle(comparison.taught_m.back().back(), 1.6 * ground.unit(), "goal");
  return ground.Svg(svg, "drive");
}

double Value(const DriveComparison& comparison, const std::string& name) {
  const auto score =
      std::find_if(comparison.scores.begin(), comparison.scores.end(), [&](const Score& s) { return s.name == name; });
  return score->value;
}

}  // namespace

ReportSection DriveReportSection(const DriveComparison& comparison, const TaughtDrive& drive, const std::string& film) {
  const auto value = [&](const char* name) { return Value(comparison, name); };
  ReportSection section;
  section.cards = internal::Card("Beside the taught way", value("drive_deviation_mean_m"), "m",
                                 fmt::format("mean; at most {} m", ScoreText(value("drive_deviation_max_m")))) +
                  internal::Card("Time", value("drive_time_s"), "s",
                                 fmt::format("{}; waited {} s for what was in its way",
                                             value("drive_goal_reached") > 0 ? "goal reached" : "goal not reached",
                                             ScoreText(value("drive_waited_s"))));
  if (std::isfinite(value("drive_clearance_m")))
    section.cards += internal::Card("Clearance", value("drive_clearance_m"), "m",
                                    fmt::format("to people, by its own motion; {} touched while it moved towards them",
                                                ScoreText(value("drive_touches"))));
  section.body = "<h2>Drive by the taught map</h2>\n" +
                 internal::Key({{"sim3", "taught way (true)"},
                                {"truth", "driven way (true)"},
                                {"green", "a view of the map confirmed where it was"},
                                {"se3", "waited, or slowed down; ring: found itself in the whole map"},
                                {"purple", "people's tracks, and where they were last"},
                                {"bad", "goal"}},
                               "") +
                 Drawing(comparison, drive);
  if (!film.empty()) {
    section.body += fmt::format(
        "<h3>Film of the drive, four times as fast</h3>\n<video controls muted loop playsinline preload=\"metadata\" "
        "src=\"{}\"></video>\n",
        internal::Escape(film));
  }
  section.style = std::string(internal::PageFile("report_graph.css"));
  return section;
}

std::string DriveCsv(const TaughtDrive& drive, const DriveComparison& comparison) {
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : std::string(); };
  std::string text = "stamp_ns,state,confirmed,found,places,x_m,y_m,beside_m,person_m\n";
  for (size_t s = 0; s < drive.steps.size(); ++s) {
    const DriveStep& step = drive.steps[s];
    const DrivenStep& truth = comparison.steps[s];
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", step.stamp_ns, ToWord(step.state), int(step.confirmed),
                        int(step.found), step.places, number(truth.at_m.x()), number(truth.at_m.y()),
                        number(truth.beside_m), number(truth.person_m));
  }
  return text;
}

}  // namespace gaitcam
