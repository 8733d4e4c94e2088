#include "models/floor_textures.h"

#include <cmath>
#include <vector>

#include "models/texture_noise.h"
#include "models/texture_paint.h"

namespace gaitcam {
namespace {

/// One board: where it lies, and what makes it differ from its neighbours.
struct Board {
  cv::Rect area;       ///< May reach over the right edge; wraps around.
  float tone = 0;      ///< Brightness, standard deviations.
  float ring_px = 10;  ///< Spacing of the growth rings.
  float ring_phase = 0;
  cv::Point grain_offset;   ///< Into the shared grain fields.
  cv::Vec3f tint{1, 1, 1};  ///< BGR factors.
};

std::vector<Board> LayBoards(const TextureOptions& o, cv::Size size, RandomStream& random) {
  std::vector<Board> boards;
  const int rows = std::max(1, int(std::lround(o.size_m.y() / o.unit_m)));
  const double longest = 14 * o.unit_m * size.width / o.size_m.x();
  for (int row = 0; row < rows; ++row) {
    const int top = row * size.height / rows, bottom = (row + 1) * size.height / rows;
    const int start = random.Index(size.width);
    for (int x = 0; x < size.width;) {
      int length = int(longest * random.Uniform(0.35, 1.0));
      if (x + length + 0.2 * longest > size.width) length = size.width - x;  // no splinter at the end
      Board board;
      board.area = {start + x, top, length, bottom - top};
      board.tone = float(random.Normal());
      board.ring_px = float((bottom - top) * random.Uniform(0.08, 0.3));
      board.ring_phase = float(random.Uniform(0, 10));
      board.grain_offset = {random.Index(size.width), random.Index(size.height)};
      const float warm = float(random.Normal(0, 0.02));
      board.tint = {1 - warm, 1, 1 + warm};
      boards.push_back(board);
      x += length;
    }
  }
  return boards;
}

/// Fields that all boards share, each board at an offset of its own.
struct Grain {
  cv::Mat streaks;  ///< Fine fibres and pores.
  cv::Mat warp;     ///< Bends the growth rings; slow along x.
};

Grain MakeGrain(cv::Size size, RandomStream& random) {
  Grain grain;
  grain.streaks = StreakNoise(size, 32, random);
  grain.warp = Enlarge(FractalNoise({size.width / 64, size.height / 16}, 4, 1, 0.5, random), 64, 16);
  return grain;
}

/// Growth rings: slowly darker, then a sharp edge to light. @returns -1..0.5.
inline float Ring(float phase) {
  const float part = phase - std::floor(phase);
  return 0.5f - 1.5f * part * part;
}

void PaintBoard(const Board& board, const Grain& grain, const TextureOptions& o, cv::Mat& bgr) {
  const int width = bgr.cols, height = bgr.rows;
  const float contrast = float(o.contrast);
  const cv::Vec3f base(float(255 * o.rgb.z()), float(255 * o.rgb.y()), float(255 * o.rgb.x()));
  for (int y = 0; y < board.area.height; ++y) {
    const int grain_y = (y + board.grain_offset.y) % height;
    const float* streaks = grain.streaks.ptr<float>(grain_y);
    const float* warp = grain.warp.ptr<float>(grain_y);
    uint8_t* out = bgr.ptr<uint8_t>(board.area.y + y);
    const float across = float(y) / board.ring_px + board.ring_phase;
    const bool edge_row = y == 0;
    for (int x = 0, at = board.area.x % width, from = board.grain_offset.x; x < board.area.width; ++x) {
      const float pore = streaks[from] < -1.7f ? -0.12f : 0.0f;
      float tone = 0.11f * board.tone + 0.045f * streaks[from] + pore + 0.16f * Ring(across + 1.1f * warp[from]);
      if (edge_row || x == 0) tone -= 0.5f;  // the gap
      const float factor = std::max(0.05f, 1 + contrast * tone);
      for (int c = 0; c < 3; ++c) out[3 * at + c] = uint8_t(std::min(255.0f, factor * board.tint[c] * base[c] + 0.5f));
      if (++at == width) at = 0;
      if (++from == width) from = 0;
    }
  }
}

}  // namespace

cv::Mat MakePlanks(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3);
  const std::vector<Board> boards = LayBoards(o, size, random);
  const Grain grain = MakeGrain(size, random);
  for (const Board& board : boards) PaintBoard(board, grain, o, bgr);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddScratches(int(5 * area), 0.03 * px, 0.3 * px, 0.3 * o.contrast, random);
  wear.AddSpots(int(25 * area), std::max(0.8, 0.001 * px), 0.008 * px, 0.35 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeConcrete(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const int coarsest = 128;
  cv::Mat field = FractalNoise(size, coarsest, 1, 0.85, random);
  field = 1 + 0.09 * o.contrast * field;
  cv::Mat bgr = Tint(field, o.rgb);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddSpots(int(120 * area), std::max(0.7, 0.001 * px), 0.006 * px, 0.5 * o.contrast, random);
  wear.AddSpots(int(4 * area), 0.01 * px, 0.05 * px, 0.12 * o.contrast, random);
  wear.AddScratches(int(3 * area), 0.1 * px, 0.9 * px, 0.45 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

}  // namespace gaitcam
