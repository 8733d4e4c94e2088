#include "sim/walking/preview_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

std::vector<Eigen::Vector2d> Constant(const PreviewControl& control, const Eigen::Vector2d& value) {
  return std::vector<Eigen::Vector2d>(size_t(control.reference_count()), value);
}

/// A walk's plan: after 1 s the ZMP jumps from foot to foot every 0.35 s and advances 40 mm a step.
Eigen::Vector2d WalkingZmp(double t) {
  const int step = t < 1 ? -1 : int(std::floor((t - 1) / 0.35));
  if (step < 0) return {0, 0};
  return {0.04 * std::min(step, 12), step >= 12 ? 0.0 : (step % 2 == 0 ? -0.04 : 0.04)};
}

TEST(PreviewControl, AStandingCartStaysWhereItIs) {
  PreviewControl control({});
  control.Reset({0.3, -0.2});
  for (int i = 0; i < 500; ++i) control.Update(Constant(control, {0.3, -0.2}));
  EXPECT_NEAR((control.position() - Eigen::Vector2d(0.3, -0.2)).norm(), 0, 1e-9);  // rounding
}

TEST(PreviewControl, AWalkIsTheSameWhereverTheWorldHasItsOrigin) {
  PreviewOptions tall;
  tall.com_height_m = 0.5;  // falls slowly: after a horizon of 1 s a hundredth is left of what it does not see
  const Eigen::Vector2d there(-20, 7);
  PreviewControl here_control(tall), there_control(tall);
  here_control.Reset({0, 0});
  there_control.Reset(there);
  for (int k = 0; k < 1500; ++k) {
    std::vector<Eigen::Vector2d> here_zmp, there_zmp;
    for (int j = 0; j < here_control.reference_count(); ++j) {
      here_zmp.push_back(WalkingZmp((k + j) * 0.004));
      there_zmp.push_back(here_zmp.back() + there);
    }
    here_control.Update(here_zmp);
    there_control.Update(there_zmp);
    ASSERT_LT((there_control.position() - there - here_control.position()).norm(), 1e-6) << k;  // rounding
  }
}

TEST(PreviewControl, GainsLookAheadLessTheFurtherItIs) {
  const PreviewControl control({});
  const std::vector<double>& gains = control.preview_gains();
  EXPECT_DOUBLE_EQ(gains.front(), -control.integral_gain());  // Kajita's remark under eq. 12
  const auto steepest = std::max_element(gains.begin(), gains.end(), [](double a, double b) { return -a < -b; });
  const double last = gains[gains.size() - 2];
  EXPECT_LT(std::abs(last), 0.01 * std::abs(*steepest));  // so 1 s is far enough
  // The one at the horizon stands for all that would follow.
  PreviewOptions far;
  far.horizon_s = 3;
  const std::vector<double> further = PreviewControl(far).preview_gains();
  const double rest = std::accumulate(further.begin() + long(gains.size()) - 1, further.end(), 0.0);
  EXPECT_NEAR(gains.back(), rest, 1e-6 * std::abs(rest));
}

TEST(PreviewControl, ZmpFollowsAWalkWithinMillimetres) {
  PreviewControl control({});
  control.Reset({0, 0});
  double squared = 0;
  int count = 0;
  for (int k = 0; k < 2000; ++k) {
    std::vector<Eigen::Vector2d> reference;
    for (int j = 0; j < control.reference_count(); ++j) reference.push_back(WalkingZmp((k + j) * 0.004));
    control.Update(reference);
    squared += (control.Zmp() - WalkingZmp((k + 1) * 0.004)).squaredNorm();
    ++count;
  }
  // The reference jumps by 89 mm within one period, which no finite jerk can follow; on average the ZMP must be well
  // inside a foot of 60 mm width.
  EXPECT_LT(std::sqrt(squared / count), 0.008);
  EXPECT_NEAR((control.position() - Eigen::Vector2d(0.48, 0)).norm(), 0, 1e-3);
  EXPECT_NEAR(control.velocity().norm(), 0, 1e-3);
}

TEST(PreviewControl, TheCartLeavesBeforeTheZmpDoes) {
  // The centre of mass must start to fall towards the new foot before the support changes: that is what preview is for.
  PreviewControl control({});
  control.Reset({0, 0});
  std::vector<Eigen::Vector2d> reference = Constant(control, {0, 0});
  for (size_t j = reference.size() / 2; j < reference.size(); ++j) reference[j] = {0.1, 0};
  for (int k = 0; k < 100; ++k) {
    control.Update(reference);
    reference.erase(reference.begin());
    reference.push_back({0.1, 0});
  }
  EXPECT_GT(control.position().x(), 0.01);
}

TEST(PreviewControl, DcmObeysThePendulum) {
  // d(dcm)/dt = omega (dcm - zmp), the defining property of the divergent component.
  PreviewControl control({});
  control.Reset({0, 0});
  for (int k = 0; k < 400; ++k) {
    std::vector<Eigen::Vector2d> reference;
    for (int j = 0; j < control.reference_count(); ++j) reference.push_back(WalkingZmp((k + j) * 0.004));
    const Eigen::Vector2d dcm = control.Dcm(), zmp = control.Zmp();
    control.Update(reference);
    const Eigen::Vector2d rate = (control.Dcm() - dcm) / 0.004;
    const Eigen::Vector2d mean_gap = 0.5 * (dcm + control.Dcm() - zmp - control.Zmp());
    // Trapezoid over one period; the ZMP moves by up to 20 mm within it, so second order leaves a few mm/s.
    EXPECT_LT((rate - control.natural_frequency() * mean_gap).norm(), 0.02) << "step " << k;
  }
}

TEST(PreviewControl, RefusesAFlatTable) {
  PreviewOptions options;
  options.com_height_m = 0;
  EXPECT_THROW(PreviewControl{options}, BadOption);
}

}  // namespace
}  // namespace gaitcam
