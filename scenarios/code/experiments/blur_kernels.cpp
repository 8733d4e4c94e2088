#include "scenarios/code/experiments/blur_kernels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/random.h"
#include "algorithms/features/blur_path.h"
#include "algorithms/features/light_response.h"
#include "algorithms/features/mobif.h"
#include "algorithms/features/psf.h"
#include "algorithms/features/psf_path.h"
#include "scenarios/code/experiments/table_experiment.h"

namespace gaitcam {
namespace {

/// An image as it was filmed, and how it truly moved; both after the crop.
struct FilmedBlur {
  cv::Mat grey;
  ImageMotion motion;
  uint64_t seed = 0;
  PathEstimate found;  ///< By the image alone.
};

FilmedBlur Film(const cv::Mat& grey, const ImageMotion& motion, const CameraSetting& setting, uint64_t seed) {
  cv::Mat values;
  grey.convertTo(values, CV_32F, 1 / 255.0);
  if (setting.linear_light) values = LightOfGrey(grey);
  values = BlurAlong(values, motion);
  if (setting.linear_light) values = GreyOfLight(values);
  values = values(cv::Rect(kCrop_px, kCrop_px, grey.cols - 2 * kCrop_px, grey.rows - 2 * kCrop_px)) * 255;
  RandomStream random(seed, "noise");
  for (int y = 0; y < values.rows && setting.noise_sigma > 0; ++y)
    for (int x = 0; x < values.cols; ++x) values.at<float>(y, x) += float(random.Normal(0, setting.noise_sigma));
  FilmedBlur film{{}, motion.Cropped({double(kCrop_px), double(kCrop_px)}), seed, {}};
  values.convertTo(film.grey, CV_8U);
  if (setting.jpeg_quality > 0) {
    std::vector<uchar> bytes;
    cv::imencode(".jpg", film.grey, bytes, {cv::IMWRITE_JPEG_QUALITY, setting.jpeg_quality});
    film.grey = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  }
  return film;
}

/// The truth, its end moved against its beginning by `error_px` in a direction drawn from the seed: what a gyroscope
/// with a wrong rate would say.
std::vector<BlurRegion> KnownTo(double error_px, const FilmedBlur& film) {
  RandomStream random(film.seed, "error of the known path");
  const double direction = random.Uniform(0, 2 * M_PI);
  const Eigen::Vector2d error = error_px * Eigen::Vector2d(std::cos(direction), std::sin(direction));
  return DivideByPath(
      [&](const Eigen::Vector2d& pixel) {
        BlurPath path = film.motion.PathAt(pixel);
        for (size_t i = 0; i < path.points.size(); ++i)
          path.points[i] += (double(i) / double(path.points.size() - 1) - 0.5) * error;
        return path;
      },
      film.grey.size());
}

Features ByName(const std::string& name, const FilmedBlur& film, int most) {
  return DetectFeatures(*MakeFeature2d(name), film.grey, most);
}

Features Told(double error_px, const FilmedBlur& film, int most) {
  const cv::Ptr<BlurAwareFeature> mobif = MakeMobif();
  mobif->SetBlurRegions(KnownTo(error_px, film));
  return DetectFeatures(*mobif, film.grey, most);
}

/// What was found, restored however sure it is, or its chord adapted to.
Features Forced(bool restore, const FilmedBlur& film, int most) {
  const cv::Rect whole({0, 0}, film.grey.size());
  if (film.found.path.empty()) return ByName("mobif", film, most);
  const double confidence = restore ? 1 : 0;
  const cv::Ptr<BlurAwareFeature> mobif = MakeMobif();
  mobif->SetBlurRegions({{whole, {film.found.path.Chord(), confidence, true}, film.found.path}});
  return DetectFeatures(*mobif, film.grey, most);
}

Features LeftAlone(const FilmedBlur& film, int most) {
  const cv::Ptr<BlurAwareFeature> mobif = MakeMobif();
  mobif->SetBlur(LineBlur{});
  return DetectFeatures(*mobif, film.grey, most);
}

struct Way {
  std::string name, sharp;  ///< The detector of the other, sharp image.
  std::function<Features(const FilmedBlur&, int most)> extract;
};

const std::string kLeftAlone = "mobif, left alone", kRestored = "mobif, found path restored",
                  kAdapted = "mobif, found chord adapted to";

const std::vector<Way>& Ways() {
  static const std::vector<Way> ways = [] {
    std::vector<Way> all;
    for (const char* name : {"sift", "mobif_adapt", "mobif_restore", "mobif_fast", "mobif", "mobif_path"})
      all.push_back({name, name, [name](const FilmedBlur& f, int most) { return ByName(name, f, most); }});
    all.push_back({kLeftAlone, "mobif", LeftAlone});
    all.push_back({kRestored, "mobif", [](const FilmedBlur& f, int n) { return Forced(true, f, n); }});
    all.push_back({kAdapted, "mobif", [](const FilmedBlur& f, int n) { return Forced(false, f, n); }});
    all.push_back({"mobif, path known", "mobif", [](const FilmedBlur& f, int n) { return Told(0, f, n); }});
    all.push_back({"mobif, path known to 1 px", "mobif", [](const FilmedBlur& f, int n) { return Told(1, f, n); }});
    return all;
  }();
  return ways;
}

/// One pair in one setting.
std::vector<KernelTrial> RunPair(const ImagePair& pair, const CameraSetting& setting,
                                 const KernelExperimentOptions& options) {
  const TrueMap map = MapOfHomography(AfterCrop(pair.H_ba));
  const FilmedBlur sharp = Film(pair.a, {}, setting, options.seed);
  std::map<std::string, Features> of_sharp;
  for (const Way& way : Ways())
    if (!of_sharp.contains(way.sharp)) of_sharp[way.sharp] = ByName(way.sharp, sharp, options.max_features);
  std::vector<KernelTrial> trials;
  const auto add = [&](BlurKind kind, double extent_px) {
    RandomStream random(options.seed, fmt::format("{} {} {}", pair.name, ToWord(kind), extent_px));
    const uint64_t seed = uint64_t(random.Index(1 << 30));
    FilmedBlur film = Film(pair.b, DrawMotion(kind, extent_px, pair.b.size(), seed), setting, seed);
    film.found = EstimatePath(film.grey, MakePsfEstimator(MobifOptions().psf)->EstimateWhole(film.grey).blur);
    KernelTrial trial{pair.name, setting.name, kind, extent_px, {}, film.found.confidence};
    trial.of_light = film.found.of_light;
    trial.straight = film.found.straight;
    if (extent_px > 0) trial.found_apart_px = PathDistance(film.found.path, film.motion.PathAt(film.motion.centre));
    for (const Way& way : Ways())
      trial.ways.push_back(
          CountMatches(of_sharp[way.sharp], way.extract(film, options.max_features), map, {options.ratio}).front());
    trials.push_back(trial);
  };
  add(BlurKind::kLine, 0);
  for (const BlurKind kind : options.kinds)
    for (const double extent_px : options.extents_px) add(kind, extent_px);
  return trials;
}

}  // namespace

std::vector<std::string> KernelWays() {
  std::vector<std::string> names;
  for (const Way& way : Ways()) names.push_back(way.name);
  return names;
}

std::vector<KernelTrial> RunKernelExperiment(const std::vector<ImagePair>& pairs,
                                             const KernelExperimentOptions& options,
                                             const std::function<void(int done, int all)>& progress) {
  std::vector<CameraSetting> settings = CameraSettings();
  std::erase_if(settings, [&](const CameraSetting& s) {
    return std::find(options.settings.begin(), options.settings.end(), s.name) == options.settings.end();
  });
  const int jobs = int(pairs.size() * settings.size());
  std::vector<std::vector<KernelTrial>> parts(size_t(jobs), std::vector<KernelTrial>{});
  std::mutex mutex;
  int done = 0;
  InParallel(jobs, options.jobs, [&](int i) {
    parts[size_t(i)] = RunPair(pairs[size_t(i) / settings.size()], settings[size_t(i) % settings.size()], options);
    const std::lock_guard lock(mutex);
    progress(++done, jobs);
  });
  std::vector<KernelTrial> trials;
  for (const std::vector<KernelTrial>& part : parts) trials.insert(trials.end(), part.begin(), part.end());
  return trials;
}

namespace {

/// The trials of one cell of the table.
std::vector<const KernelTrial*> CellOf(const std::vector<KernelTrial>& trials, const std::string& setting,
                                       BlurKind kind, double extent_px) {
  std::vector<const KernelTrial*> cell;
  for (const KernelTrial& t : trials)
    if (t.setting == setting && t.kind == kind && t.extent_px == extent_px) cell.push_back(&t);
  return cell;
}

/// "1234 (5.6), 78 %": correct matches, times SIFT's, precision.
std::string CellText(const std::vector<const KernelTrial*>& cell, size_t way) {
  MatchCount sum, sift;
  for (const KernelTrial* trial : cell) {
    sum += trial->ways[way];
    sift += trial->ways[0];
  }
  const double times = sift.correct > 0 ? double(sum.correct) / sift.correct : std::nan("");
  return fmt::format("{} ({:.1f}), {:.0f} %", sum.correct, times, 100 * sum.Precision());
}

/// A row for each way, a column for each extent.
std::string KindTable(const std::vector<KernelTrial>& trials, const std::string& setting, BlurKind kind,
                      const std::vector<double>& extents) {
  std::string head = "| " + std::string(ToWord(kind)) + " |", line = "|---|", rows;
  for (const double extent : extents) {
    head += extent > 0 ? fmt::format(" {:.0f} px |", extent) : " sharp |";
    line += "---:|";
  }
  for (size_t way = 0; way < Ways().size(); ++way) {
    rows += "| " + Ways()[way].name + " |";
    for (const double extent : extents) rows += " " + CellText(CellOf(trials, setting, kind, extent), way) + " |";
    rows += "\n";
  }
  return head + "\n" + line + "\n" + rows + "\n";
}

std::string KindTables(const std::vector<KernelTrial>& trials, const std::string& setting,
                       const std::vector<double>& extents) {
  std::string text;
  for (const auto& word : WordsOf(BlurKind{})) {
    std::vector<double> of_kind;  // the sharp image stands with the lines
    for (const double extent : extents)
      if (!CellOf(trials, setting, word.value, extent).empty()) of_kind.push_back(extent);
    if (!of_kind.empty()) text += KindTable(trials, setting, word.value, of_kind);
  }
  return text;
}

/// Of the images whose path was found with such a confidence, how many gained by being restored along it.
std::string ConfidenceTable(const std::vector<KernelTrial>& trials) {
  constexpr int kBins = 5;
  const auto way = [names = KernelWays()](const std::string& name) {
    return size_t(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const size_t restored = way(kRestored), adapted = way(kAdapted), alone = way(kLeftAlone);
  std::string text =
      "| confidence | images | mean confidence | share that gained | of them sharp or turned |\n"
      "|---|---:|---:|---:|---:|\n";
  for (int bin = 0; bin < kBins; ++bin) {
    int all = 0, gains = 0, none = 0;
    double sum = 0;
    for (const KernelTrial& t : trials) {
      if (std::min(kBins - 1, int(t.confidence * kBins)) != bin) continue;
      ++all;
      sum += t.confidence;
      none += t.extent_px == 0 || t.kind == BlurKind::kRotation;
      gains += t.ways[restored].correct > std::max(t.ways[adapted].correct, t.ways[alone].correct);
    }
    if (all > 0)
      text += fmt::format("| {:.1f} to {:.1f} | {} | {:.2f} | {:.2f} | {} |\n", double(bin) / kBins,
                          double(bin + 1) / kBins, all, sum / all, double(gains) / all, none);
  }
  return text;
}

/// How near the found path is to the true one, and in how many images it was told right what the blur acted on.
std::string PathErrorTable(const std::vector<KernelTrial>& trials, const std::vector<std::string>& settings) {
  std::string text =
      "| setting | kind | images | found path off by (quartiles) | light or grey values told right |\n"
      "|---|---|---:|---:|---:|\n";
  for (const std::string& setting : settings)
    for (const auto& word : WordsOf(BlurKind{})) {
      std::vector<double> errors;
      int right = 0;
      for (const KernelTrial& t : trials) {
        if (t.setting != setting || t.kind != word.value || t.extent_px == 0) continue;
        errors.push_back(t.found_apart_px);
        right += t.of_light == (setting == "realistic");
      }
      if (errors.empty()) continue;
      std::sort(errors.begin(), errors.end());
      const auto at = [&](double share) { return errors[size_t(share * double(errors.size() - 1))]; };
      text += fmt::format("| {} | {} | {} | {:.2f}, {:.2f}, {:.2f} px | {} |\n", setting, word.word, errors.size(),
                          at(0.25), at(0.5), at(0.75), right);
    }
  return text + "\n";
}

}  // namespace

std::string KernelTable(const std::vector<KernelTrial>& trials, const std::string& command) {
  std::string text = "# Blur as a walk makes it\n\nMade by `" + command + "`.\n\nImage pairs: ";
  std::vector<std::string> pairs, settings;
  std::vector<double> extents;
  const auto note = [](auto& list, const auto& value) {
    if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
  };
  for (const KernelTrial& t : trials) {
    note(pairs, t.pair);
    note(settings, t.setting);
    note(extents, t.extent_px);
  }
  for (size_t i = 0; i < pairs.size(); ++i) text += (i ? ", " : "") + pairs[i];
  text += fmt::format(
      ". One image of each blurred, its motion drawn from the seed, then {} px cut off each side; noise of sigma 2; "
      "realistic: light added up, JPEG 90. Nearest neighbour, ratio 0.8; correct: within {:.0f} px. Sums over all "
      "pairs; in brackets the factor over `sift`, then precision.\n\n",
      kCrop_px, kCorrect_px);
  for (const std::string& setting : settings) text += "## " + setting + "\n\n" + KindTables(trials, setting, extents);
  return text + "## The path found\n\n" + PathErrorTable(trials, settings) + "## Confidence\n\n" +
         ConfidenceTable(trials);
}

}  // namespace gaitcam
