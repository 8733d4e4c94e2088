#include "algorithms/features/blur_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "algorithms/core/errors.h"
#include "algorithms/features/line_spectra.h"
#include "algorithms/features/log_spectrum.h"
#include "algorithms/features/psf_spectral.h"

namespace gaitcam {
namespace {

constexpr double kLowFrequency = 0.02, kHighFrequency = 0.30, kMinExtent = 4;
constexpr int kDirections = 60;
constexpr float kFloorShare = 0.3f;

/// One tile: where it is, and how well each line fits it.
struct Tile {
  Eigen::Vector2d middle;
  LogSpectrum log;
  Eigen::MatrixXf score;  ///< Rows by extent from kMinExtent on, a column for each direction.

  /// Between the entries linearly. A blur too short to be told from none counts 0, as no blur does.
  double Score(const Eigen::Vector2d& blur) const {
    const double extent = blur.norm();
    const double row = (extent - kMinExtent) / LineSpectra::kExtentStep;
    if (row > double(score.rows() - 1)) return 0;
    if (row < 0) return row > -4 ? (1 + row / 4) * ScoreAt(0, blur) : 0;
    return ScoreAt(row, blur);
  }

 private:
  double ScoreAt(double row, const Eigen::Vector2d& blur) const {
    double column = std::atan2(blur.y(), blur.x()) * kDirections / M_PI;
    if (column < 0) column += kDirections;
    const int c0 = int(column) % kDirections, c1 = (c0 + 1) % kDirections;
    const int r0 = int(row), r1 = std::min(r0 + 1, int(score.rows()) - 1);
    const double a = row - r0, b = column - std::floor(column);
    return (1 - b) * ((1 - a) * double(score(r0, c0)) + a * double(score(r1, c0))) +
           b * ((1 - a) * double(score(r0, c1)) + a * double(score(r1, c1)));
  }
};

/// First pixels of tiles that cover `length` evenly, overlapping by a quarter at least.
std::vector<int> TileStarts(int length, int tile) {
  const int steps = int(std::ceil(double(length - tile) / (0.75 * tile)));
  std::vector<int> starts;
  for (int i = 0; i <= steps; ++i) starts.push_back(steps > 0 ? (length - tile) * i / steps : 0);
  return starts;
}

std::vector<Tile> MakeTiles(const cv::Mat& grey, const LineSpectra& spectra, const BlurFieldOptions& options) {
  const cv::Mat laplacian = Laplacian(grey);
  const int side = options.tile_px;
  std::vector<Tile> tiles;
  if (laplacian.cols < side || laplacian.rows < side) return tiles;
  for (const int top : TileStarts(laplacian.rows, side)) {
    for (const int left : TileStarts(laplacian.cols, side)) {
      PowerSpectrum spectrum(side);
      spectrum.Add(laplacian(cv::Rect(left, top, side, side)));
      if (spectrum.empty()) continue;
      Tile tile;
      tile.middle = {left + 0.5 * (side + 1), top + 0.5 * (side + 1)};
      tile.log = MakeLogSpectrum(spectrum, kLowFrequency, kHighFrequency, LineSpectra::kRings);
      std::vector<float> floors = tile.log.floors;
      for (float& floor : floors) floor *= kFloorShare;
      const LineSpectra::Templates templates =
          spectra.MakeTemplates(spectra.CountSamples(tile.log), floors, 0, options.max_extent_px);
      tile.score.resize(templates.norms.size(), kDirections);
      for (int i = 0; i < kDirections; ++i) {
        tile.score.col(i) = spectra.Correlate(tile.log, templates, M_PI * i / kDirections);
      }
      tiles.push_back(std::move(tile));
    }
  }
  return tiles;
}

double Score(const std::vector<Tile>& tiles, const BlurField& field) {
  double sum = 0;
  for (const Tile& tile : tiles) sum += tile.Score(field.VectorAt(tile.middle));
  return sum / double(tiles.size());
}

struct Candidate {
  BlurField field;
  double score = 0;
};

/// The best few of a grid of motions at the centre and rolls, 2 px apart at the centre and 3 at the corners.
std::vector<Candidate> Search(const std::vector<Tile>& tiles, const BlurField& empty, const cv::Size& image,
                              double max_extent) {
  constexpr double kCentreStep = 2, kCornerStep = 3;
  constexpr size_t kKept = 8;
  const double corner = 0.5 * std::hypot(image.width, image.height);
  const int reach = int(max_extent / kCentreStep), rolls = int(max_extent / kCornerStep);
  std::vector<Candidate> best;
  for (int y = 0; y <= reach; ++y) {
    for (int x = y == 0 ? 0 : -reach; x <= reach; ++x) {
      if (x * x + y * y > reach * reach) continue;
      for (int r = -rolls; r <= rolls; ++r) {
        Candidate c{empty, 0};
        c.field.at_centre = kCentreStep * Eigen::Vector2d(x, y);
        c.field.roll_rad = r * kCornerStep / corner;
        c.score = Score(tiles, c.field);
        if (best.size() == kKept && c.score <= best.back().score) continue;
        best.insert(std::upper_bound(best.begin(), best.end(), c,
                                     [](const Candidate& a, const Candidate& b) { return a.score > b.score; }),
                    c);
        if (best.size() > kKept) best.pop_back();
      }
    }
  }
  return best;
}

/// Climbs along the three coordinates with halving steps.
void Climb(const std::vector<Tile>& tiles, double corner, Candidate& c) {
  for (double step = 1; step > 0.03; step /= 2) {
    for (int i = 0; i < 6; ++i) {
      bool better = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (const double by : {-step, step}) {
          Candidate beside = c;
          if (axis < 2) {
            beside.field.at_centre[axis] += by;
          } else {
            beside.field.roll_rad += by / corner;
          }
          beside.score = Score(tiles, beside.field);
          if (beside.score <= c.score) continue;
          c = beside;
          better = true;
        }
      }
      if (!better) break;
    }
  }
}

/// Correlation of the ripple that all tiles share with that of a line, over frequency in periods of each tile's blur.
double SharedAgreement(const std::vector<Tile>& tiles, const BlurField& field) {
  constexpr int kPeriods = 5, kBinsEach = 16, kBins = kPeriods * kBinsEach;
  constexpr double kFloor = 0.01;
  std::array<double, kBins> sum{}, count{};
  for (const Tile& tile : tiles) {
    const Eigen::Vector2f blur = field.VectorAt(tile.middle).cast<float>();
    if (double(blur.norm()) < kMinExtent) continue;
    for (const SpectrumSample& s : tile.log.samples) {
      const int bin = int(std::abs(s.fx * blur.x() + s.fy * blur.y()) * kBinsEach);
      if (bin >= kBins) continue;
      sum[size_t(bin)] += double(s.value / tile.log.deviation);
      count[size_t(bin)] += 1;
    }
  }
  const auto ripple = [&](auto value, int b) {  // less its mean over a period
    double mean = 0;
    int n = 0;
    for (int k = b - kBinsEach / 2; k <= b + kBinsEach / 2; ++k) {
      const int mirrored = k < 0 ? -1 - k : k;
      if (mirrored >= kBins || count[size_t(mirrored)] == 0) continue;
      const double half = std::abs(k - b) == kBinsEach / 2 ? 0.5 : 1;
      mean += half * value(mirrored);
      n += half == 1 ? 2 : 1;
    }
    return value(b) - 2 * mean / std::max(1, n);
  };
  const auto seen = [&](int b) { return sum[size_t(b)] / count[size_t(b)]; };
  const auto line = [&](int b) {
    const double x = M_PI * (b + 0.5) / kBinsEach, s = std::sin(x) / x;
    return std::log(s * s + kFloor / (1 + x * x));
  };
  double dot = 0, ss = 0, ll = 0;
  for (int b = 0; b < kBins; ++b) {
    if (count[size_t(b)] == 0) continue;
    const double n = count[size_t(b)], s = ripple(seen, b), l = ripple(line, b);
    dot += n * s * l;
    ss += n * s * s;
    ll += n * l * l;
  }
  return ss > 0 && ll > 0 ? std::clamp(dot / std::sqrt(ss * ll), 0.0, 1.0) : 0;
}

void Divide(const BlurField& field, const cv::Rect& r, const BlurFieldOptions& options,
            std::vector<BlurRegion>& regions) {
  const Eigen::Vector2d middle(r.x + 0.5 * (r.width - 1), r.y + 0.5 * (r.height - 1));
  const Eigen::Vector2d blur = field.VectorAt(middle);
  double variation = 0;
  for (const double x : {r.x - 0.5, r.br().x - 0.5}) {
    for (const double y : {r.y - 0.5, r.br().y - 0.5}) {
      variation = std::max(variation, (field.VectorAt({x, y}) - blur).norm());
    }
  }
  const double tolerance = std::max(options.tolerance_px, options.tolerance_share * blur.norm());
  const bool wide = r.width >= r.height;
  const int side = wide ? r.width : r.height;
  if (variation <= tolerance || side < 2 * options.min_region_px) {
    const LineBlur line = LineBlur::FromVector(blur);
    const bool blurred = field.confidence >= options.min_confidence && line.extent_px >= options.verdict_px;
    regions.push_back({r, {line, field.confidence, blurred}});
    return;
  }
  cv::Rect first = r, second = r;
  (wide ? first.width : first.height) = side / 2;
  (wide ? second.x : second.y) += side / 2;
  (wide ? second.width : second.height) -= side / 2;
  Divide(field, first, options, regions);
  Divide(field, second, options, regions);
}

}  // namespace

void BlurFieldOptions::Check() const {
  CheckFields(*this);
  if ((tile_px & (tile_px - 1)) != 0) {
    throw BadOption("tile_px: " + std::to_string(tile_px) + " is not a power of two");
  }
}

Eigen::Vector2d BlurField::VectorAt(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d p = pixel - centre;
  Eigen::Vector2d blur = at_centre + roll_rad * Eigen::Vector2d(p.y(), -p.x());
  if (focal_px > 0) blur += p * (p.dot(at_centre) / (focal_px * focal_px));
  return blur;
}

BlurField EstimateBlurField(const cv::Mat& grey, const BlurFieldOptions& options) {
  GAITCAM_ASSERT(grey.type() == CV_8UC1);
  options.Check();
  BlurField field;
  field.centre = {0.5 * (grey.cols - 1), 0.5 * (grey.rows - 1)};
  field.focal_px = options.focal_px;
  if (std::min(grey.cols, grey.rows) < options.tile_px + 2) return field;
  const LineSpectra spectra(options.tile_px, kMinExtent, options.max_extent_px, kHighFrequency);
  const std::vector<Tile> tiles = MakeTiles(grey, spectra, options);
  if (tiles.empty()) return field;
  std::vector<Candidate> candidates = Search(tiles, field, grey.size(), options.max_extent_px);
  const double corner = 0.5 * std::hypot(grey.cols, grey.rows);
  for (Candidate& c : candidates) Climb(tiles, corner, c);
  const Candidate& best = *std::max_element(candidates.begin(), candidates.end(),
                                            [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  // One blur for the whole image may be seen where that of single tiles drowns in noise: start from that as well.
  Candidate uniform{field, 0};
  uniform.field.at_centre = SpectralPsf().EstimateWhole(grey).blur.Vector();
  uniform.score = Score(tiles, uniform.field);
  Climb(tiles, corner, uniform);
  const double best_agreement = SharedAgreement(tiles, best.field);
  const double uniform_agreement = SharedAgreement(tiles, uniform.field);
  field = uniform_agreement > best_agreement ? uniform.field : best.field;
  field.confidence = std::max(uniform_agreement, best_agreement);
  return field;
}

std::vector<BlurRegion> DivideByBlur(const BlurField& field, const cv::Size& image, const BlurFieldOptions& options) {
  std::vector<BlurRegion> regions;
  Divide(field, {{0, 0}, image}, options, regions);
  return regions;
}

std::vector<BlurRegion> SegmentBlurField(const cv::Mat& grey, const BlurFieldOptions& options) {
  return DivideByBlur(EstimateBlurField(grey, options), grey.size(), options);
}

}  // namespace gaitcam
