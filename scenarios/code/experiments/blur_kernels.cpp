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
#include "scenarios/code/experiments/table_experiment.h"

namespace gaitcam {
namespace {

/// An image as it was filmed, and how it truly moved; both after the crop.
struct FilmedBlur {
  cv::Mat grey;
  ImageMotion motion;
  uint64_t seed = 0;
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
  FilmedBlur film{{}, motion.Cropped({double(kCrop_px), double(kCrop_px)}), seed};
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

Features Forced(double restore_confidence, const FilmedBlur& film, int most) {
  MobifOptions options = MobifPathOptions();
  options.restore_confidence = restore_confidence;
  return DetectFeatures(*MakeMobif(options), film.grey, most);
}

struct Way {
  std::string name, sharp;  ///< The detector of the other, sharp image.
  std::function<Features(const FilmedBlur&, int most)> extract;
};

const std::vector<Way>& Ways() {
  static const std::vector<Way> ways = [] {
    std::vector<Way> all;
    for (const char* name : {"sift", "mobif_adapt", "mobif_restore", "mobif_fast", "mobif", "mobif_path"})
      all.push_back({name, name, [name](const FilmedBlur& f, int most) { return ByName(name, f, most); }});
    all.push_back({"mobif_path, always restored", "mobif", [](const FilmedBlur& f, int n) { return Forced(0, f, n); }});
    all.push_back({"mobif_path, always adapted", "mobif", [](const FilmedBlur& f, int n) { return Forced(1, f, n); }});
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
    const FilmedBlur film = Film(pair.b, DrawMotion(kind, extent_px, pair.b.size(), seed), setting, seed);
    KernelTrial trial{pair.name, setting.name, kind, extent_px, {}, 0, false};
    for (const Way& way : Ways())
      trial.ways.push_back(CountMatches(of_sharp[way.sharp], way.extract(film, options.max_features), map,
                                        {options.ratio})
                               .front());
    const BlurEstimate estimate = MakePsfEstimator(MobifOptions().psf)->EstimateWhole(film.grey);
    trial.confidence = estimate.confidence;
    trial.blurred = estimate.blurred;
    trials.push_back(trial);
  };
  add(BlurKind::kLine, 0);
  for (const auto& word : WordsOf(BlurKind{}))
    for (const double extent_px : options.extents_px) add(word.value, extent_px);
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

std::string KindTables(const std::vector<KernelTrial>& trials, const std::string& setting,
                       const std::vector<double>& extents) {
  std::string text;
  for (const auto& word : WordsOf(BlurKind{})) {
    text += fmt::format("| {} |", word.word);
    std::string line = "|---|";
    for (const double extent : extents) {
      if (extent == 0 && word.value != BlurKind::kLine) continue;
      text += extent > 0 ? fmt::format(" {:.0f} px |", extent) : " sharp |";
      line += "---:|";
    }
    text += "\n" + line + "\n";
    for (size_t way = 0; way < Ways().size(); ++way) {
      text += "| " + Ways()[way].name + " |";
      for (const double extent : extents) {
        if (extent == 0 && word.value != BlurKind::kLine) continue;
        text += " " + CellText(CellOf(trials, setting, word.value, extent), way) + " |";
      }
      text += "\n";
    }
    text += "\n";
  }
  return text;
}

/// Of the images that `mobif` was as sure of, how many gained by being restored.
std::string ConfidenceTable(const std::vector<KernelTrial>& trials) {
  const auto way = [](const char* name) {
    const std::vector<std::string> names = KernelWays();
    return size_t(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const size_t restored = way("mobif, always restored"), adapted = way("mobif, always adapted");
  std::string text =
      "| confidence | images | mean confidence | restored has more than adapted | verdict blurred |\n"
      "|---|---:|---:|---:|---:|\n";
  for (int tenth = 0; tenth < 10; ++tenth) {
    int all = 0, gains = 0, blurred = 0;
    double sum = 0;
    for (const KernelTrial& t : trials) {
      if (t.extent_px == 0 || std::min(9, int(t.confidence * 10)) != tenth) continue;
      ++all;
      sum += t.confidence;
      blurred += t.blurred;
      gains += t.ways[restored].correct > t.ways[adapted].correct;
    }
    if (all > 0)
      text += fmt::format("| {:.1f} to {:.1f} | {} | {:.2f} | {:.2f} | {} |\n", 0.1 * tenth, 0.1 * (tenth + 1), all,
                          sum / all, double(gains) / all, blurred);
  }
  return text;
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
  for (const std::string& setting : settings)
    text += "## " + setting + "\n\n" + KindTables(trials, setting, extents);
  return text + "## Confidence\n\n" + ConfidenceTable(trials);
}

}  // namespace gaitcam
