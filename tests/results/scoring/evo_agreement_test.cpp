// Agreement with the definitions of the trajectory evaluation tool evo (evo_ape, evo_rpe; github.com/MichaelGrupp/evo),
// which is not packaged for Debian. Its definitions are computed here a second time, on plain arrays and without any
// function of ours: stamps in seconds as double, poses as 4 x 4 matrices, alignment by Horn's quaternion method instead
// of an SVD.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "results/scoring/alignment.h"
#include "results/scoring/association.h"
#include "results/scoring/metrics.h"
#include "tests/results/scoring/synthetic.h"

namespace gaitcam {
namespace {

// 1e-6 is what is promised; both sides compute in double, so 1e-9 leaves room for nothing but rounding.
constexpr double kTolerance = 1e-9;

using Matrix = std::array<std::array<double, 4>, 4>;

struct Path {
  std::vector<double> stamps;  // s
  std::vector<Matrix> poses;
};

Path ToPath(const Trajectory& trajectory) {
  Path path;
  for (const StampedPose& p : trajectory) {
    const double x = p.pose.rotation.x(), y = p.pose.rotation.y(), z = p.pose.rotation.z(), w = p.pose.rotation.w();
    const Eigen::Vector3d t = p.pose.translation;
    path.stamps.push_back(double(p.stamp_ns) * 1e-9);
    path.poses.push_back({{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), t.x()},
                           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), t.y()},
                           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), t.z()},
                           {0, 0, 0, 1}}});
  }
  return path;
}

Matrix Product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
    }
  }
  return c;
}

/// p1^-1 p2
Matrix Relative(const Matrix& p1, const Matrix& p2) {
  Matrix inverse{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      inverse[i][j] = p1[j][i];
      inverse[i][3] -= p1[j][i] * p1[j][3];
    }
  }
  inverse[3][3] = 1;
  return Product(inverse, p2);
}

double TranslationOf(const Matrix& e) { return std::hypot(e[0][3], e[1][3], e[2][3]); }

double DistanceFromIdentity(const Matrix& e, int size) {
  double sum = 0;
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) sum += std::pow(e[i][j] - (i == j), 2);
  }
  return std::sqrt(sum);
}

/// |R - I| = 2 sqrt(2) sin(angle / 2), which stays exact for small angles, where arccos of the trace does not.
double AngleOf(const Matrix& e) { return 2 * std::asin(std::min(1.0, DistanceFromIdentity(e, 3) / std::sqrt(8.0))); }

/// evo: every stamp of the shorter trajectory (of the second, if equally long) asks for the nearest of the longer one;
/// the first of equals; accepted up to and including max_diff. The offset belongs to the estimate.
std::vector<IndexPair> Synchronize(const std::vector<double>& reference, std::vector<double> estimate, double max_diff,
                                   double offset) {
  for (double& s : estimate) s += offset;
  const bool estimate_longer = estimate.size() > reference.size();
  const auto& brief = estimate_longer ? reference : estimate;
  const auto& lengthy = estimate_longer ? estimate : reference;
  std::vector<IndexPair> pairs;
  for (size_t i = 0; i < brief.size(); ++i) {
    size_t nearest = 0;
    for (size_t j = 1; j < lengthy.size(); ++j) {
      if (std::abs(lengthy[j] - brief[i]) < std::abs(lengthy[nearest] - brief[i])) nearest = j;
    }
    if (std::abs(lengthy[nearest] - brief[i]) > max_diff) continue;
    pairs.push_back(estimate_longer ? IndexPair{i, nearest} : IndexPair{nearest, i});
  }
  return pairs;
}

/// Eigenvector of the largest eigenvalue of a symmetric 4 x 4 matrix, by cyclic Jacobi rotations.
std::array<double, 4> LargestEigenvector(Matrix a) {
  Matrix v{};
  for (int i = 0; i < 4; ++i) v[i][i] = 1;
  for (int sweep = 0; sweep < 60; ++sweep) {
    for (int p = 0; p < 4; ++p) {
      for (int q = p + 1; q < 4; ++q) {
        if (a[p][q] == 0) continue;
        const double phi = 0.5 * std::atan2(2 * a[p][q], a[p][p] - a[q][q]), c = std::cos(phi), s = std::sin(phi);
        for (int k = 0; k < 4; ++k) {
          const double kp = a[k][p], kq = a[k][q], vp = v[k][p], vq = v[k][q];
          a[k][p] = c * kp + s * kq;
          a[k][q] = c * kq - s * kp;
          v[k][p] = c * vp + s * vq;
          v[k][q] = c * vq - s * vp;
        }
        for (int k = 0; k < 4; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk + s * qk;
          a[q][k] = c * qk - s * pk;
        }
      }
    }
  }
  int best = 0;
  for (int k = 1; k < 4; ++k) {
    if (a[k][k] > a[best][best]) best = k;
  }
  return {v[0][best], v[1][best], v[2][best], v[3][best]};
}

/// The estimate aligned to the reference: B. K. P. Horn, "Closed-form solution of absolute orientation using unit
/// quaternions", 1987, with Umeyama's scale sum(y . R x) / sum(x . x). As evo does it, orientations are rotated and not
/// scaled.
void AlignTo(const std::vector<Matrix>& reference, std::vector<Matrix>& estimate, bool with_scale) {
  const double n = double(reference.size());
  std::array<double, 3> mx{}, my{};
  for (size_t k = 0; k < reference.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      mx[i] += estimate[k][i][3] / n;
      my[i] += reference[k][i][3] / n;
    }
  }
  double s[3][3] = {}, xx = 0;
  for (size_t k = 0; k < reference.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) s[i][j] += (estimate[k][i][3] - mx[i]) * (reference[k][j][3] - my[j]);
      xx += std::pow(estimate[k][i][3] - mx[i], 2);
    }
  }
  const Matrix horn = {{{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
                        {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                        {s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
                        {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}}};
  const auto [w, x, y, z] = LargestEigenvector(horn);
  Matrix motion = {{{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y), 0},
                    {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x), 0},
                    {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z, 0},
                    {0, 0, 0, 1}}};
  double yrx = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) yrx += motion[i][j] * s[j][i];
  }
  const double scale = with_scale ? yrx / xx : 1;
  for (int i = 0; i < 3; ++i) {
    motion[i][3] = my[i];
    for (int j = 0; j < 3; ++j) motion[i][3] -= scale * motion[i][j] * mx[j];
  }
  for (Matrix& p : estimate) {
    for (int i = 0; i < 3; ++i) p[i][3] *= scale;
    p = Product(motion, p);
  }
}

double StepTo(const std::vector<Matrix>& poses, size_t i) {
  const Matrix &a = poses[i - 1], &b = poses[i];
  return std::hypot(b[0][3] - a[0][3], b[1][3] - a[1][3], b[2][3] - a[2][3]);
}

double PathOf(const std::vector<Matrix>& poses) {
  double path = 0;
  for (size_t i = 1; i < poses.size(); ++i) path += StepTo(poses, i);
  return path;
}

using IdPairs = std::vector<std::pair<size_t, size_t>>;

IdPairs PairsByIndex(size_t count, size_t delta, bool all) {
  IdPairs ids;
  for (size_t i = 0; i + delta < count; i += all ? 1 : delta) ids.emplace_back(i, i + delta);
  return ids;
}

/// evo: consecutive pairs lie between the marks at which the summed path has reached delta (the sum starts anew at each
/// mark); in all-pairs mode each pose is joined with the later one whose distance along the path is nearest to delta,
/// the first of equals, if within the tolerance.
IdPairs PairsByPath(const std::vector<Matrix>& poses, double delta, double tolerance, bool all) {
  IdPairs ids;
  if (!all) {
    std::vector<size_t> marks;
    double path = 0;
    for (size_t i = 0; i < poses.size(); ++i) {
      path += i > 0 ? StepTo(poses, i) : 0;
      if (path >= delta) marks.push_back(i), path = 0;
    }
    for (size_t k = 1; k < marks.size(); ++k) ids.emplace_back(marks[k - 1], marks[k]);
    return ids;
  }
  std::vector<double> gone = {0};
  for (size_t i = 1; i < poses.size(); ++i) gone.push_back(gone.back() + StepTo(poses, i));
  for (size_t i = 0; i + 1 < poses.size(); ++i) {
    size_t best = i + 1;
    for (size_t j = i + 2; j < poses.size(); ++j) {
      if (std::abs(gone[j] - gone[i] - delta) < std::abs(gone[best] - gone[i] - delta)) best = j;
    }
    if (std::abs(gone[best] - gone[i] - delta) <= tolerance) ids.emplace_back(i, best);
  }
  return ids;
}

/// What evo would be given: truth at 200 Hz, an estimate at about 30 Hz with jitter, gaps, drift, noise and a world of
/// its own.
struct Files {
  Trajectory truth, estimate;

  explicit Files(uint64_t seed, bool estimate_longer = false) {
    RandomStream random(seed, "evo");
    const int64_t truth_step = estimate_longer ? 50'000'000 : 5'000'000,
                  estimate_step = estimate_longer ? 10'000'000 : 33'333'333;
    const Trajectory walk = SwayingCircle(1200, 1.5, 5);
    const int64_t begin = walk.front().stamp_ns, end = begin + 12'000'000'000;
    for (int64_t t = begin; t < end; t += truth_step) truth.push_back({t, *PoseAt(walk, t)});
    const Similarity X = RandomSimilarity(random, true);
    for (int64_t t = begin + 400'000'000; t < end - 20'000'000; t += estimate_step) {
      if (random.Uniform() < 0.1) continue;
      const int64_t stamp = t + int64_t(random.Uniform(-3e6, 3e6));
      Pose pose = *PoseAt(walk, stamp);
      pose.translation += 0.02 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
      const double drift = 1e-11 * double(t - begin);
      pose.rotation = pose.rotation * Eigen::Quaterniond(RotX(0.02 * random.Normal()) * RotZ(drift));
      pose.translation *= 1 + drift;
      estimate.push_back({stamp - 7'000'000, X * Pose(pose.rotation, pose.translation)});
    }
  }
};

AssociationOptions NearestStamps(double offset_ms) {
  AssociationOptions options;
  options.rule = AssociationRule::kNearest;
  options.time_offset_ms = offset_ms;
  return options;
}

TEST(EvoAgreement, NearestStampAssociation) {
  for (const bool estimate_longer : {false, true}) {
    for (const double offset_s : {0.0, 0.007, -0.3}) {
      const Files files(1, estimate_longer);
      const Path reference = ToPath(files.truth), estimate = ToPath(files.estimate);
      ASSERT_EQ(estimate_longer, estimate.stamps.size() > reference.stamps.size());
      const auto expected = Synchronize(reference.stamps, estimate.stamps, 0.01, offset_s);
      ASSERT_GT(expected.size(), 100u);
      EXPECT_EQ(Associate(Stamps(files.truth), Stamps(files.estimate), NearestStamps(1e3 * offset_s)), expected);
    }
  }
}

/// Both sides' view of the same associated and aligned trajectories.
struct Compared {
  std::vector<PosePair> ours;
  std::vector<Matrix> reference, estimate;

  Compared(uint64_t seed, Alignment alignment) {
    const Files files(seed);
    const Path truth_path = ToPath(files.truth), estimate_path = ToPath(files.estimate);
    for (const IndexPair& p : Synchronize(truth_path.stamps, estimate_path.stamps, 0.01, 0.007)) {
      reference.push_back(truth_path.poses[p.truth]);
      estimate.push_back(estimate_path.poses[p.estimate]);
    }
    if (alignment != Alignment::kNone) AlignTo(reference, estimate, alignment == Alignment::kSim3);
    ours = AssociatePoses(EstimateOf(files.estimate).frames, files.truth, NearestStamps(7));
    ours = Apply(Align(ours, alignment).X_WV, ours);
  }
  static Estimate EstimateOf(const Trajectory& trajectory) {
    Estimate estimate;
    for (const StampedPose& p : trajectory) {
      FrameEstimate frame;
      frame.stamp_ns = p.stamp_ns;
      frame.pose = p.pose;
      estimate.frames.push_back(frame);
    }
    return estimate;
  }
};

class EvoAgreementUnder : public testing::TestWithParam<Alignment> {};

TEST_P(EvoAgreementUnder, AbsoluteErrorsOfTranslationRotationAndAll) {
  for (const uint64_t seed : {1, 2, 3}) {
    const Compared c(seed, GetParam());
    ASSERT_EQ(c.ours.size(), c.reference.size());
    const auto positions = PositionErrors(c.ours), angles = RotationErrors(c.ours), full = FullErrors(c.ours);
    for (size_t k = 0; k < c.ours.size(); ++k) {
      const Matrix error = Relative(c.estimate[k], c.reference[k]);
      EXPECT_NEAR(positions[k], TranslationOf(error), kTolerance);
      EXPECT_NEAR(angles[k], AngleOf(error), kTolerance);
      EXPECT_NEAR(full[k], DistanceFromIdentity(error, 4), kTolerance);
    }
  }
}

void ExpectSameRelativeErrors(const Compared& c, const IdPairs& expected, const RelativeOptions& options) {
  ASSERT_GT(expected.size(), 3u);
  const std::vector<RelativeError> found = RelativeErrors(c.ours, options);
  ASSERT_EQ(found.size(), expected.size());
  for (size_t k = 0; k < found.size(); ++k) {
    const auto& [i, j] = expected[k];
    EXPECT_EQ(found[k].from, i);
    EXPECT_EQ(found[k].to, j);
    const Matrix error = Relative(Relative(c.reference[i], c.reference[j]), Relative(c.estimate[i], c.estimate[j]));
    EXPECT_NEAR(found[k].translation_m, TranslationOf(error), kTolerance);
    EXPECT_NEAR(found[k].rotation_rad, AngleOf(error), kTolerance);
  }
}

TEST_P(EvoAgreementUnder, RelativeErrorsOverFrames) {
  const Compared c(4, GetParam());
  for (const bool all : {false, true}) {
    for (const int delta : {1, 7, 30}) {
      ExpectSameRelativeErrors(c, PairsByIndex(c.reference.size(), size_t(delta), all),
                               {.delta = double(delta), .unit = DeltaUnit::kFrames, .all_pairs = all});
    }
  }
}

TEST_P(EvoAgreementUnder, RelativeErrorsOverMetres) {
  const Compared c(5, GetParam());
  for (const bool all : {false, true}) {
    for (const bool of_truth : {false, true}) {
      for (const double part_of_path : {0.04, 0.15}) {  // the unaligned estimate has a length unit of its own
        const std::vector<Matrix>& path = of_truth ? c.reference : c.estimate;
        const double delta = part_of_path * PathOf(path);
        ExpectSameRelativeErrors(c, PairsByPath(path, delta, 0.1 * delta, all),
                                 {.delta = delta,
                                  .unit = DeltaUnit::kMeters,
                                  .all_pairs = all,
                                  .path = of_truth ? RpePath::kTruth : RpePath::kEstimate});
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Alignments, EvoAgreementUnder,
                         testing::Values(Alignment::kNone, Alignment::kSe3, Alignment::kSim3),
                         [](const auto& info) { return ToString(info.param); });

TEST(EvoAgreement, Statistics) {
  // numpy: std divides by n, the median of an even number of values is the mean of the middle two.
  const std::vector<double> errors = {0.3, 0.1, 0.2, 0.8};
  const gaitcam::Statistics s = Summarize(errors);
  EXPECT_NEAR(s.rmse, std::sqrt(0.78 / 4), 1e-15);
  EXPECT_NEAR(s.mean, 0.35, 1e-15);
  EXPECT_NEAR(s.median, 0.25, 1e-15);
  EXPECT_NEAR(s.std, std::sqrt((0.0025 + 0.0625 + 0.0225 + 0.2025) / 4), 1e-15);
}

}  // namespace
}  // namespace gaitcam
