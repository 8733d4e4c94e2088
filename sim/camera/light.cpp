#include "sim/camera/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

using DecodeTable = std::array<float, 256>;

DecodeTable MakeDecodeTable(double weight) {
  DecodeTable table;
  for (int i = 0; i < 256; ++i) table[i] = float(weight * SrgbToLinear(i / 255.0));
  return table;
}

const DecodeTable& UnitTable() {
  static const DecodeTable table = MakeDecodeTable(1);
  return table;
}

/// The table times a weight: the sum then costs one look-up and one addition per value.
DecodeTable Weighted(float weight) {
  DecodeTable table = UnitTable();
  for (float& value : table) value *= weight;
  return table;
}

/// 0..n-1, the rank of each value in sorted order.
std::vector<int> Ranks(const std::vector<double>& values) {
  std::vector<int> order(values.size()), ranks(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  for (size_t i = 0; i < order.size(); ++i) ranks[order[i]] = int(i);
  return ranks;
}

}  // namespace

double SrgbToLinear(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}

double LinearToSrgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double MeanLuminance(const cv::Mat& bgrx_bottom_up) {
  constexpr int kStride = 4;
  const DecodeTable& table = UnitTable();
  double sum = 0;
  int64_t count = 0;
  for (int row = 0; row < bgrx_bottom_up.rows; row += kStride) {
    const uint8_t* from = bgrx_bottom_up.ptr<uint8_t>(row);
    for (int col = 0; col < bgrx_bottom_up.cols; col += kStride, ++count) {
      const uint8_t* p = from + 4 * col;
      sum += 0.0722 * double(table[p[0]]) + 0.7152 * double(table[p[1]]) + 0.2126 * double(table[p[2]]);
    }
  }
  return sum / double(std::max<int64_t>(1, count));
}

double MeanLuminanceOfLight(const cv::Mat& light) {
  const cv::Scalar mean = cv::mean(light);
  return 0.0722 * mean[0] + 0.7152 * mean[1] + 0.2126 * mean[2];
}

void LightAccumulator::AddRow(const cv::Mat& bgrx_bottom_up, int row, const float* table) {
  const uint8_t* from = bgrx_bottom_up.ptr<uint8_t>(light_.rows - 1 - row);
  float* to = light_.ptr<float>(row);
  for (int col = 0; col < light_.cols; ++col, from += 4, to += 3) {
    to[0] += table[from[0]];
    to[1] += table[from[1]];
    to[2] += table[from[2]];
  }
}

void LightAccumulator::Add(const cv::Mat& bgrx_bottom_up, float weight) {
  GAITCAM_ASSERT(bgrx_bottom_up.type() == CV_8UC4 && bgrx_bottom_up.size() == light_.size());
  const DecodeTable table = Weighted(weight);
  for (int row = 0; row < light_.rows; ++row) AddRow(bgrx_bottom_up, row, table.data());
}

void LightAccumulator::Add(const cv::Mat& bgrx_bottom_up, std::span<const float> row_weights) {
  GAITCAM_ASSERT(bgrx_bottom_up.type() == CV_8UC4 && bgrx_bottom_up.size() == light_.size());
  GAITCAM_ASSERT(int(row_weights.size()) == light_.rows);
  DecodeTable table;
  float weight = 0;
  for (int row = 0; row < light_.rows; ++row) {
    if (row_weights[row] == 0) continue;
    if (row_weights[row] != weight) table = Weighted(weight = row_weights[row]);
    AddRow(bgrx_bottom_up, row, table.data());
  }
}

void LightAccumulator::AddBent(const cv::Mat& bgrx_bottom_up, const cv::Mat& map, const Eigen::Vector2d& shift_px,
                               std::span<const float> row_weights) {
  GAITCAM_ASSERT(bgrx_bottom_up.type() == CV_8UC4 && map.type() == CV_32FC2 && map.size() == light_.size());
  GAITCAM_ASSERT(int(row_weights.size()) == light_.rows);
  const DecodeTable& table = UnitTable();
  const float shift_x = float(shift_px.x()), shift_y = float(shift_px.y());
  for (int row = 0; row < light_.rows; ++row) {
    const float weight = row_weights[row];
    if (weight == 0) continue;
    const float* at = map.ptr<float>(row);
    float* to = light_.ptr<float>(row);
    for (int col = 0; col < light_.cols; ++col, at += 2, to += 3) {
      const float x = at[0] - shift_x, y = at[1] - shift_y;
      const int left = int(x), top = int(y);
      const float s = x - float(left), t = (y - float(top)) * weight;
      const uint8_t* upper = bgrx_bottom_up.ptr<uint8_t>(bgrx_bottom_up.rows - 1 - top) + ptrdiff_t{4} * left;
      const uint8_t* lower = upper - bgrx_bottom_up.step;
      const float w[4] = {(1 - s) * (weight - t), s * (weight - t), (1 - s) * t, s * t};
      for (int c = 0; c < 3; ++c) {
        to[c] +=
            w[0] * table[upper[c]] + w[1] * table[upper[4 + c]] + w[2] * table[lower[c]] + w[3] * table[lower[4 + c]];
      }
    }
  }
}

cv::Mat MeanLight(const cv::Mat& bgrx_bottom_up, int finer) {
  GAITCAM_ASSERT(bgrx_bottom_up.type() == CV_8UC4 && finer >= 1);
  const cv::Size size(bgrx_bottom_up.cols / finer, bgrx_bottom_up.rows / finer);
  const DecodeTable table = Weighted(1.f / float(finer * finer));
  cv::Mat mean(size, CV_32FC3, cv::Scalar::all(0));
  for (int row = 0; row < size.height * finer; ++row) {
    const uint8_t* from = bgrx_bottom_up.ptr<uint8_t>(bgrx_bottom_up.rows - 1 - row);
    float* to = mean.ptr<float>(row / finer);
    for (int col = 0; col < size.width; ++col, to += 3) {
      for (int i = 0; i < finer; ++i, from += 4) {
        for (int c = 0; c < 3; ++c) to[c] += table[from[c]];
      }
    }
  }
  return mean;
}

void DecodeLight(const cv::Mat& bgrx_bottom_up, cv::Mat& light) {
  GAITCAM_ASSERT(bgrx_bottom_up.type() == CV_8UC4);
  const DecodeTable& table = UnitTable();
  light.create(bgrx_bottom_up.size(), CV_32FC4);
  for (int row = 0; row < light.rows; ++row) {
    const uint8_t* from = bgrx_bottom_up.ptr<uint8_t>(light.rows - 1 - row);
    float* to = light.ptr<float>(row);
    for (int col = 0; col < light.cols; ++col, from += 4, to += 4) {
      to[0] = table[from[0]];
      to[1] = table[from[1]];
      to[2] = table[from[2]];
      to[3] = 0;
    }
  }
}

cv::Mat EncodeSrgb(const cv::Mat& light) {
  constexpr int kSteps = 1 << 16;  // finer than 1/20 of a grey level even where the curve is steepest
  constexpr float kHalf = 0.5f;    // rounds what is not negative
  static const std::vector<uint8_t> table = [] {
    std::vector<uint8_t> codes(kSteps + 1);
    for (int i = 0; i <= kSteps; ++i) codes[i] = uint8_t(std::lround(255 * LinearToSrgb(double(i) / kSteps)));
    return codes;
  }();
  GAITCAM_ASSERT(light.depth() == CV_32F);
  cv::Mat image(light.size(), CV_8UC(light.channels()));
  for (int row = 0; row < light.rows; ++row) {
    const float* from = light.ptr<float>(row);
    uint8_t* to = image.ptr<uint8_t>(row);
    for (int i = 0; i < light.cols * light.channels(); ++i) {
      to[i] = table[int(std::clamp(from[i], 0.f, 1.f) * kSteps + kHalf)];
    }
  }
  return image;
}

std::vector<Eigen::Vector2d> PixelShifts(int count) {
  GAITCAM_ASSERT(count >= 1);
  // The plastic number's powers: x^3 = x + 1.
  const double plastic = 1.32471795724474602596, step_x = 1 / plastic, step_y = 1 / (plastic * plastic);
  std::vector<double> x(count), y(count);
  for (int i = 0; i < count; ++i) {
    x[i] = std::fmod(0.5 + step_x * i, 1.0);
    y[i] = std::fmod(0.5 + step_y * i, 1.0);
  }
  const std::vector<int> rank_x = Ranks(x), rank_y = Ranks(y);
  std::vector<Eigen::Vector2d> shifts(count);
  for (int i = 0; i < count; ++i) {
    shifts[i] = {(rank_x[i] + 0.5) / count - 0.5, (rank_y[i] + 0.5) / count - 0.5};
  }
  return shifts;
}

}  // namespace gaitcam
