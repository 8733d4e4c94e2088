#include "models/code/textures/floor_textures.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "models/code/textures/texture_noise.h"
#include "models/code/textures/texture_paint.h"

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
  const int rows = std::clamp(int(std::lround(o.size_m.y() / o.unit_m)), 1, size.height / 4);
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
      float tone = 0.09f * board.tone + 0.05f * streaks[from] + pore + 0.15f * GrowthRing(across + 1.1f * warp[from]);
      if (edge_row || x == 0) tone -= 0.5f;  // the gap
      const float factor = std::max(0.05f, 1 + contrast * tone);
      for (int c = 0; c < 3; ++c) out[3 * at + c] = uint8_t(std::min(255.0f, factor * board.tint[c] * base[c] + 0.5f));
      if (++at == width) at = 0;
      if (++from == width) from = 0;
    }
  }
}

/// Knots in a board: dark, with rings of their own, longer along the grain.
void PaintKnots(const Board& board, const TextureOptions& o, cv::Mat& bgr, RandomStream& random) {
  const double px = o.px_per_m, expected = 0.9 * board.area.area() / (px * px) / 0.1;  // nine on ten boards of 0.1 m^2
  for (double left = expected + random.Uniform(-0.9, 0.9); left > 0.5; left -= 1) {
    const double radius = px * random.Uniform(0.004, 0.012), stretch = random.Uniform(1.2, 2.2);
    const double x0 = random.Uniform(0, board.area.width), y0 = random.Uniform(0.15, 0.85) * board.area.height;
    const int reach = int(3 * radius) + 1;
    for (int dy = -reach; dy <= reach; ++dy) {
      const int y = int(y0) + dy;
      if (y < 1 || y >= board.area.height) continue;
      uint8_t* row = bgr.ptr<uint8_t>(board.area.y + y);
      for (int dx = -int(stretch * reach); dx <= int(stretch * reach); ++dx) {
        const int x = int(x0) + dx;
        if (x < 1 || x >= board.area.width) continue;
        const double r = std::hypot(dx / stretch, double(dy)) / radius;
        const double dark =
            (r < 1 ? 0.5 : 0.32 * std::exp(-1.5 * (r - 1))) * (0.75 + 0.25 * std::cos(9 * r)) * o.contrast;
        uint8_t* out = row + 3 * ((board.area.x + x) % bgr.cols);
        for (int c = 0; c < 3; ++c) out[c] = uint8_t(out[c] * std::max(0.1, 1 - dark));
      }
    }
  }
}

cv::Mat NewPlanks(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3);
  const std::vector<Board> boards = LayBoards(o, size, random);
  const Grain grain = MakeGrain(size, random);
  for (const Board& board : boards) {
    PaintBoard(board, grain, o, bgr);
    PaintKnots(board, o, bgr, random);
  }
  return bgr;
}

}  // namespace

cv::Mat MakePlanks(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr = NewPlanks(o, size, random);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddScratches(int(5 * area), 0.03 * px, 0.3 * px, 0.3 * o.contrast, random);
  wear.AddSpots(int(70 * area), std::max(0.8, 0.0015 * px), 0.01 * px, 0.45 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeConcrete(const TextureOptions& o, cv::Size size, RandomStream& random) {
  constexpr int kCoarsest = 128;  // px
  cv::Mat field = FractalNoise(size, kCoarsest, 1, 0.85, random);
  field = 1 + 0.1 * o.contrast * field;
  cv::Mat bgr = Tint(field, o.rgb);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddSpots(int(300 * area), std::max(0.8, 0.0015 * px), 0.012 * px, 0.5 * o.contrast, random);
  wear.AddSpots(int(14 * area), 0.01 * px, 0.05 * px, 0.2 * o.contrast, random);
  wear.AddScratches(int(2 * area), 0.1 * px, 0.7 * px, 0.3 * o.contrast, random);
  wear.AddCracks(int(0.5 * area) + 1, 1.2 * px, 0.5 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

namespace {

/// One tile of a floor.
struct Tile {
  cv::Rect area;  ///< Its ceramic, without the grout.
  float tone = 0;
  cv::Point vein_offset;  ///< Into the shared marbling.
  bool turned = false;    ///< The marbling runs down instead of across.
};

std::vector<Tile> LayTiles(const TextureOptions& o, cv::Size size, int grout_px, RandomStream& random) {
  const int least = grout_px + 2;  // px: a tile is never only grout
  const int columns = std::clamp(int(std::lround(o.size_m.x() / o.unit_m)), 1, std::max(1, size.width / least));
  const int rows = std::clamp(int(std::lround(o.size_m.y() / o.unit_m)), 1, std::max(1, size.height / least));
  std::vector<Tile> tiles;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int left = i * size.width / columns, right = (i + 1) * size.width / columns;
      const int top = j * size.height / rows, bottom = (j + 1) * size.height / rows;
      Tile tile;
      tile.area = {left + grout_px, top + grout_px, right - left - grout_px, bottom - top - grout_px};
      tile.tone = float(random.Normal());
      tile.vein_offset = {random.Index(size.width), random.Index(size.height)};
      tile.turned = random.Uniform() < 0.5;
      tiles.push_back(tile);
    }
  }
  return tiles;
}

void PaintTile(const Tile& tile, const cv::Mat& cloud, const cv::Mat& veins, cv::Mat& field) {
  for (int y = 0; y < tile.area.height; ++y) {
    float* out = field.ptr<float>(tile.area.y + y) + tile.area.x;
    for (int x = 0; x < tile.area.width; ++x) {
      const int u = Wrap((tile.turned ? y : x) + tile.vein_offset.x, cloud.cols);
      const int v = Wrap((tile.turned ? x : y) + tile.vein_offset.y, cloud.rows);
      const float line = std::abs(veins.at<float>(v, u));  // a vein runs where the field changes sign
      const float vein = line < 0.06f ? 0.25f * (line / 0.06f - 1) : 0.0f;
      const bool light_edge = x == 0 || y == 0, dark_edge = x == tile.area.width - 1 || y == tile.area.height - 1;
      const float bevel = light_edge ? 0.06f : dark_edge ? -0.08f : 0.0f;
      out[x] = 0.06f * tile.tone + 0.065f * cloud.at<float>(v, u) + vein + bevel;
    }
  }
}

}  // namespace

cv::Mat MakeTiles(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const int grout_px = std::max(1, int(std::lround(0.004 * o.px_per_m)));
  const std::vector<Tile> tiles = LayTiles(o, size, grout_px, random);
  const cv::Mat cloud = FractalNoise(size, 64, 1, 0.8, random);
  const cv::Mat veins = Enlarge(FractalNoise(size / 4, 32, 1, 0.6, random), 4, 4);
  cv::Mat field = 0.15 * cloud - 0.45;  // grout
  for (const Tile& tile : tiles) PaintTile(tile, cloud, veins, field);
  field = 1 + o.contrast * field;
  cv::Mat bgr = Tint(field, o.rgb);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddSpots(int(90 * area), std::max(0.8, 0.0015 * px), 0.01 * px, 0.4 * o.contrast, random);
  wear.AddScratches(int(3 * area), 0.03 * px, 0.2 * px, 0.25 * o.contrast, random);
  wear.ApplyTo(bgr);
  return bgr;
}

namespace {

/// Tries to lay one chip where nothing lies yet. `free` is 255 where cement shows; it is one pixel per picture pixel.
bool LayChip(cv::Point2d at, double radius, const cv::Scalar& color, cv::Mat& bgr, cv::Mat& taken,
             RandomStream& random) {
  constexpr int kCorners = 7, kShift = 4;
  cv::Point corners[kCorners];
  const double angle = random.Uniform(0, 2 * M_PI), stretch = random.Uniform(0.6, 1.0);
  for (int k = 0; k < kCorners; ++k) {
    const double a = angle + 2 * M_PI * (k + random.Uniform(-0.35, 0.35)) / kCorners;
    const cv::Point2d p = at + radius * cv::Point2d(std::cos(a), stretch * std::sin(a));
    const int x = Wrap(int(std::lround(p.x)), bgr.cols), y = Wrap(int(std::lround(p.y)), bgr.rows);
    if (taken.at<uint8_t>(y, x)) return false;
    corners[k] = {int(p.x * (1 << kShift)), int(p.y * (1 << kShift))};
  }
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const cv::Point2d p = at + cv::Point2d(i * bgr.cols, j * bgr.rows);
      if (p.x < -radius - 1 || p.y < -radius - 1 || p.x > bgr.cols + radius || p.y > bgr.rows + radius) continue;
      cv::Point copy[kCorners];
      for (int k = 0; k < kCorners; ++k) copy[k] = corners[k] + (1 << kShift) * cv::Point(i * bgr.cols, j * bgr.rows);
      cv::fillConvexPoly(bgr, copy, kCorners, color, cv::LINE_AA, kShift);
      cv::fillConvexPoly(taken, copy, kCorners, cv::Scalar(255), cv::LINE_8, kShift);
    }
  }
  return true;
}

}  // namespace

cv::Mat MakeTerrazzo(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat cement = FractalNoise(size, 64, 1, 0.9, random);
  cement = 1 + 0.03 * o.contrast * cement;
  cv::Mat bgr = Tint(cement, o.rgb), taken(size, CV_8UC1, cv::Scalar(0));
  const double largest = std::max(2.0, o.unit_m / 2 * o.px_per_m), smallest = std::max(0.8, largest / 10);
  constexpr double kCover = 0.7;  // of the floor by chips that are tried; those that find room cover about half
  for (double covered = 0; covered < kCover * double(size.area());) {
    const double radius = smallest * std::pow(largest / smallest, random.Uniform());  // p(r) ~ 1/r: sieved gravel
    covered += 2.5 * radius * radius;
    const double brightness = random.Uniform() < 0.6 ? random.Uniform(-0.5, -0.05) : random.Uniform(0.05, 0.3);
    Eigen::Vector3d rgb = o.rgb * (1 + o.contrast * brightness);
    rgb.x() *= 1 + 0.12 * random.Uniform(-0.5, 1);  // some chips are reddish
    const cv::Point2d at(random.Uniform(0, size.width), random.Uniform(0, size.height));
    if (taken.at<uint8_t>(int(at.y), int(at.x))) continue;
    LayChip(at, radius, Bgr(rgb.cwiseMin(1)), bgr, taken, random);
  }
  return bgr;
}

cv::Mat MakeCarpet(const TextureOptions& o, cv::Size size, RandomStream& random) {
  const cv::Mat yarn = FractalNoise(size, 4, 1, 0.9, random);
  const cv::Mat mottle = Enlarge(FractalNoise(size / 4, 32, 1, 0.7, random), 4, 4);
  cv::Mat field;
  cv::addWeighted(yarn, 0.13 * o.contrast, mottle, 0.07 * o.contrast, 1.0, field);
  const std::vector<Tile> tiles = LayTiles(o, size, 1, random);
  for (size_t i = 0; i < tiles.size(); ++i) {
    const double pile = tiles[i].turned ? 0.05 : -0.05;  // pile that lies towards or away looks lighter or darker
    cv::Mat tile = field(tiles[i].area);
    tile += o.contrast * (pile + 0.02 * tiles[i].tone);
  }
  cv::Mat bgr = Tint(field, o.rgb);
  Wear wear(size);
  const double area = o.size_m.prod(), px = o.px_per_m;
  wear.AddSpots(int(250 * area), std::max(0.9, 0.0015 * px), 0.006 * px, 0.6 * o.contrast, random);  // flecks
  wear.AddSpots(int(3 * area), 0.02 * px, 0.08 * px, 0.2 * o.contrast, random);                      // stains
  wear.ApplyTo(bgr);
  return bgr;
}

cv::Mat MakeField(const TextureOptions& o, cv::Size size, RandomStream& random) {
  TextureOptions carpet = o;
  carpet.unit_m = std::max(o.size_m.x(), o.size_m.y());  // one piece
  cv::Mat bgr = MakeCarpet(carpet, size, random);
  constexpr double kLength = 5.4, kWidth = 3.6, kGoalAreaDepth = 0.45, kGoalAreaWidth = 2.1, kCircle = 0.6,
                   kMark = 1.35;
  constexpr int kShift = 4;
  const cv::Point2d scale(size.width / o.size_m.x(), size.height / o.size_m.y());
  const auto pixel = [&](double x, double y) {
    return cv::Point(int((size.width / 2.0 + x * scale.x) * (1 << kShift)),
                     int((size.height / 2.0 - y * scale.y) * (1 << kShift)));
  };
  const int thick = std::max(1, int(std::lround(o.unit_m * scale.x)));
  cv::Mat lines(size, CV_8UC1, cv::Scalar(0));
  const auto line = [&](double x0, double y0, double x1, double y1) {
    cv::line(lines, pixel(x0, y0), pixel(x1, y1), cv::Scalar(255), thick, cv::LINE_AA, kShift);
  };
  const auto rectangle = [&](double x0, double y0, double x1, double y1) {
    line(x0, y0, x1, y0), line(x1, y0, x1, y1), line(x1, y1, x0, y1), line(x0, y1, x0, y0);
  };
  rectangle(-kLength / 2, -kWidth / 2, kLength / 2, kWidth / 2);
  line(0, -kWidth / 2, 0, kWidth / 2);
  cv::circle(lines, pixel(0, 0), int(kCircle * scale.x * (1 << kShift)), cv::Scalar(255), thick, cv::LINE_AA, kShift);
  for (const int side : {-1, 1}) {
    const double goal = side * kLength / 2, mark = goal - side * kMark;
    rectangle(goal, -kGoalAreaWidth / 2, goal - side * kGoalAreaDepth, kGoalAreaWidth / 2);
    line(mark - 0.05, 0, mark + 0.05, 0), line(mark, -0.05, mark, 0.05);
  }
  cv::Mat paint = FractalNoise(size, 4, 1, 0.9, random);
  paint = 1 + 0.07 * o.contrast * paint;
  Tint(paint, {0.88, 0.89, 0.87}).copyTo(bgr, lines > 127);
  return bgr;
}

}  // namespace gaitcam
