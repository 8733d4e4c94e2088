#include "models/code/textures/street_textures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "models/code/textures/picture_textures.h"
#include "models/code/textures/room_textures.h"
#include "models/code/textures/texture_noise.h"
#include "models/code/textures/texture_paint.h"

namespace gaitcam {
namespace {

using Eigen::Vector3d;

/// A house's front while it is painted: lengths in m, from the left and from the ground up.
struct Front {
  cv::Mat bgr;
  double px_per_m;
  double contrast;

  double Width() const { return bgr.cols / px_per_m; }
  double Height() const { return bgr.rows / px_per_m; }
  cv::Rect Area(double left, double bottom, double width, double height) const {
    const auto px = [this](double m) { return int(std::lround(m * px_per_m)); };
    const cv::Rect wanted(px(left), bgr.rows - px(bottom + height), px(width), px(height));
    return wanted & cv::Rect({0, 0}, bgr.size());
  }
  void Fill(double left, double bottom, double width, double height, const cv::Scalar& color) const {
    const cv::Rect area = Area(left, bottom, width, height);
    if (!area.empty()) bgr(area).setTo(color);
  }
  /// A picture of another kind in its place.
  template <class Make>
  void Show(double left, double bottom, double width, double height, Make make, RandomStream& random) const {
    const cv::Rect area = Area(left, bottom, width, height);
    if (area.width < 8 || area.height < 8) return;
    TextureOptions options;
    options.size_m = {width, height};
    options.px_per_m = px_per_m;
    options.contrast = contrast;
    options.unit_m = 0.4 * std::min(width, height);
    options.rgb = Vector3d::Constant(random.Uniform(0.3, 0.55));
    make(options, area.size(), random).copyTo(bgr(area));
  }
};

cv::Scalar Shade(const Vector3d& rgb, double factor) { return Bgr((factor * rgb).cwiseMin(1)); }

/// Lines `pitch_m` apart, across the front and, for bricks, up it.
void PaintCourses(const Front& front, const Vector3d& rgb, double pitch_m, double brick_m) {
  int row = 0;
  for (double z = 0; z < front.Height(); z += pitch_m, ++row) {
    front.Fill(0, z, front.Width(), 0.015, Shade(rgb, 0.8));
    if (brick_m == 0) continue;
    for (double x = (row % 2) * brick_m / 2; x < front.Width(); x += brick_m)
      front.Fill(x, z, 0.015, pitch_m, Shade(rgb, 0.84));
  }
}

/// Glass with what it reflects, or a curtain behind it, in a frame with a post.
void PaintWindow(const Front& front, double left, double bottom, double width, double height, RandomStream& random) {
  const cv::Scalar frame = RandomColor(random, 0.15, 0.9);
  front.Fill(left - 0.07, bottom - 0.07, width + 0.14, height + 0.14, frame);
  front.Fill(left - 0.12, bottom - 0.14, width + 0.24, 0.06, RandomColor(random, 0.4, 0.7));  // the sill
  front.Fill(left, bottom, width, height, RandomColor(random, 0.12, 0.35));
  const double choice = random.Uniform();
  if (choice < 0.35) {
    front.Show(left, bottom, width, height, MakePink, random);
  } else if (choice < 0.75) {
    const double part = random.Uniform(0.2, 0.5) * width;
    front.Fill(left, bottom, part, height, RandomColor(random, 0.55, 0.85));
    front.Fill(left + width - 0.8 * part, bottom, 0.8 * part, height, RandomColor(random, 0.55, 0.85));
  }
  front.Fill(left + width * random.Uniform(0.4, 0.6), bottom, 0.05, height, frame);
  if (random.Uniform() < 0.4) front.Fill(left, bottom + 0.6 * height, width, 0.04, frame);
}

void PaintBalcony(const Front& front, double left, double bottom, double width, RandomStream& random) {
  const cv::Scalar rail = RandomColor(random, 0.2, 0.8);
  front.Fill(left, bottom, width, 0.12, RandomColor(random, 0.4, 0.7));
  front.Fill(left, bottom + 1.0, width, 0.06, rail);
  const double pitch = random.Uniform(0.12, 0.3);
  for (double x = left; x < left + width; x += pitch) front.Fill(x, bottom, 0.04, 1.0, rail);
  for (double x = left + 0.3; x < left + width - 0.6; x += random.Uniform(0.4, 0.9))  // the washing
    if (random.Uniform() < 0.6)
      front.Fill(x, bottom + 0.9, 0.35, random.Uniform(0.4, 0.8), RandomColor(random, 0.2, 0.9));
}

void PaintStorey(const Front& front, double bottom, double height, RandomStream& random) {
  const int bays = std::max(1, int(front.Width() / random.Uniform(1.9, 3.2)));
  const double pitch = front.Width() / bays, sill = random.Uniform(0.7, 1.0);
  const double tall = std::min(height - sill - 0.3, random.Uniform(1.0, 1.6));
  for (int bay = 0; bay < bays; ++bay) {
    const double choice = random.Uniform(), left = bay * pitch;
    if (choice < 0.15) continue;  // a blank wall
    const double width = random.Uniform(0.45, 0.7) * pitch;
    PaintWindow(front, left + (pitch - width) * random.Uniform(0.3, 0.7), bottom + sill, width, tall, random);
    if (choice > 0.75) PaintBalcony(front, left + 0.1, bottom + 0.05, pitch - 0.2, random);
  }
}

/// A door, and beside it whatever the ground floor is used for.
void PaintGroundFloor(const Front& front, double height, RandomStream& random) {
  front.Fill(0, 0, front.Width(), 0.3, RandomColor(random, 0.3, 0.5));  // the plinth
  const double door = random.Uniform(0.3, std::max(0.31, front.Width() - 1.4));
  double x = 0.3;
  while (x < front.Width() - 0.8) {
    if (x > door - 0.6 && x < door + 1.1) x = door + 1.2;
    const double room = (x < door ? door : front.Width()) - x - 0.2, width = std::min(room, random.Uniform(0.9, 2.6));
    if (width < 0.6) {
      x += std::max(0.3, room);
      continue;
    }
    const double choice = random.Uniform();
    if (choice < 0.3) {
      front.Show(x, 0.5, width, height - 1.0, MakeDeadLeaves, random);  // a shop's window
    } else if (choice < 0.5) {
      front.Show(x, 0.8, std::min(width, 1.0), 1.3, MakePoster, random);
    } else if (choice < 0.65) {
      front.Show(x, 1.0, std::min(width, 1.4), 0.9, MakeNoticeBoard, random);
    } else if (choice < 0.8) {  // a shutter
      const cv::Scalar color = RandomColor(random, 0.4, 0.75);
      front.Fill(x, 0, width, height - 0.5, color);
      for (double z = 0.1; z < height - 0.5; z += 0.1) front.Fill(x, z, width, 0.02, 0.75 * color);
    } else {
      PaintWindow(front, x + 0.1, 0.9, std::max(0.4, width - 0.2), 1.3, random);
    }
    x += width + random.Uniform(0.2, 0.9);
  }
  TextureOptions leaf;
  leaf.size_m = {1.0, 2.1};
  leaf.px_per_m = front.px_per_m;
  leaf.rgb = Vector3d(random.Uniform(0.2, 0.7), random.Uniform(0.2, 0.6), random.Uniform(0.2, 0.6));
  const cv::Rect area = front.Area(door, 0, 1.0, 2.1);
  if (area.width > 40 && area.height > 80) MakeDoor(leaf, area.size(), random).copyTo(front.bgr(area));
}

void PaintSign(const Front& front, double bottom, RandomStream& random) {
  const double width = random.Uniform(0.4, 0.9) * front.Width(), height = random.Uniform(0.4, 0.7);
  const cv::Rect area = front.Area(random.Uniform(0, front.Width() - width), bottom, width, height);
  if (area.width < 8 || area.height < 8) return;
  const bool dark = random.Uniform() < 0.5;
  cv::Mat board = front.bgr(area);
  board.setTo(dark ? RandomColor(random, 0.1, 0.35) : RandomColor(random, 0.7, 0.95));
  DrawWords(board, {area.width / 30, 0, area.width * 14 / 15, area.height * 9 / 10}, 0.6 * area.height,
            dark ? RandomColor(random, 0.8, 1.0) : RandomColor(random, 0.05, 0.3), random);
}

/// A rain pipe, boxes of meters and coolers, streaks below.
void PaintFittings(const Front& front, RandomStream& random) {
  front.Fill(random.Uniform() < 0.5 ? 0.12 : front.Width() - 0.22, 0, 0.1, front.Height(),
             RandomColor(random, 0.25, 0.8));
  for (int i = int(front.Width() / 2.5); i > 0; --i) {
    const double x = random.Uniform(0.1, front.Width() - 0.8), z = random.Uniform(0.4, front.Height() - 1.0);
    const double width = random.Uniform(0.2, 0.7), height = random.Uniform(0.2, 0.6);
    front.Fill(x, z, width, height, RandomColor(random, 0.3, 0.85));
    front.Fill(x + 0.15 * width, z + 0.2 * height, 0.4 * width, 0.5 * height, RandomColor(random, 0.15, 0.6));
  }
}

}  // namespace

cv::Mat MakeHouseFront(const TextureOptions& o, cv::Size size, RandomStream& random) {
  Vector3d rgb = o.rgb * random.Uniform(0.7, 1.15);
  for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c] + o.contrast * random.Uniform(-0.12, 0.12), 0.1, 0.95);
  cv::Mat stains = FractalNoise({RoundUp(size.width, 64), RoundUp(size.height, 64)}, 64, 1, 0.9, random);
  stains = 1 + 0.05 * o.contrast * stains;
  Front front{Tint(stains(cv::Rect({0, 0}, size)), rgb), o.px_per_m, o.contrast};
  const double material = random.Uniform();
  if (material < 0.35) PaintCourses(front, rgb, random.Uniform(0.07, 0.25), random.Uniform(0.22, 0.6));
  if (material > 0.7) PaintCourses(front, rgb, random.Uniform(0.15, 0.3), 0);
  const double ground = 1.05 * o.unit_m;
  PaintGroundFloor(front, ground, random);
  for (double z = ground; z + 0.8 * o.unit_m < front.Height(); z += o.unit_m) {
    front.Fill(0, z - 0.06, front.Width(), 0.12, Shade(rgb, random.Uniform(0.6, 1.2)));
    PaintStorey(front, z, o.unit_m, random);
  }
  PaintFittings(front, random);
  if (random.Uniform() < 0.6) PaintSign(front, ground - 0.3, random);
  front.Fill(0, front.Height() - 0.2, front.Width(), 0.2, Shade(rgb, 0.5));  // the eaves
  Wear wear(size);
  wear.AddSpots(int(2 * o.size_m.prod()), 0.01 * o.px_per_m, 0.06 * o.px_per_m, 0.2 * o.contrast, random);
  wear.ApplyTo(front.bgr);
  return front.bgr;
}

cv::Mat MakeCarBody(const TextureOptions& o, cv::Size size, RandomStream& random) {
  cv::Mat bgr(size, CV_8UC3, Bgr(o.rgb));
  const auto area = [&](double left, double top, double width, double height) {
    return cv::Rect(int(left * size.width), int(top * size.height), int(width * size.width), int(height * size.height));
  };
  for (int y = 0; y < size.height; ++y) bgr.row(y) *= 1.1 - 0.4 * y / size.height;  // rounded: darker below
  bgr(area(0, 0.72, 1, 0.28)).setTo(Shade(o.rgb, 0.35));
  for (const double x : {0.3, 0.5, 0.72}) bgr(area(x, 0.05, 0.004, 0.65)).setTo(Shade(o.rgb, 0.3));
  for (const double x : {0.43, 0.64}) bgr(area(x, 0.18, 0.05, 0.05)).setTo(Bgr({0.75, 0.75, 0.77}));
  for (const double x : {0.02, 0.9})
    bgr(area(x, 0.2, 0.08, 0.2)).setTo(x < 0.5 ? Bgr({0.9, 0.9, 0.8}) : Bgr({0.7, 0.1, 0.1}));
  for (const double x : {0.18, 0.82}) {
    const cv::Point hub(int(x * size.width), int(0.7 * size.height));
    const cv::Scalar rim = cv::Scalar::all(random.Uniform(120, 200));
    for (const auto& [part, color] :
         {std::pair(1.0, Bgr({0.08, 0.08, 0.08})), {0.6, rim}, {0.15, Bgr({0.2, 0.2, 0.2})}}) {
      const cv::Size axes(int(0.075 * part * size.width), int(0.46 * part * size.height));  // round on the long side
      cv::ellipse(bgr, hub, axes, 0, 0, 360, color, cv::FILLED, cv::LINE_AA);
    }
  }
  cv::Mat plate = bgr(area(0.44, 0.42, 0.12, 0.16));
  plate.setTo(Bgr({0.92, 0.92, 0.88}));
  DrawWords(plate, {1, 0, plate.cols - 2, plate.rows}, 0.6 * plate.rows, cv::Scalar(40, 60, 30), random);
  Wear wear(size);
  wear.AddSpots(int(20 * o.contrast), 1, 0.02 * size.height, 0.3, random);
  wear.ApplyTo(bgr);
  return bgr;
}

}  // namespace gaitcam
