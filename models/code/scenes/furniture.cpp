#include "models/code/scenes/furniture.h"

#include "models/code/scenes/scene_file.h"

namespace gaitcam {
namespace {

using Parts = std::vector<FurniturePart>;
using Eigen::Vector3d;

constexpr double kWoodRepeat = 1.2;  // m: one repeat of the main texture on large faces

FurniturePart Main(const Vector3d& center, const Vector3d& size) {
  return {center, size, "main", {kWoodRepeat, kWoodRepeat}, {0.6, 0.5, 0.4}};
}

FurniturePart Plain(const Vector3d& center, const Vector3d& size, const Vector3d& rgb) {
  return {center, size, "", {0, 0}, rgb};
}

/// A picture of `kind` stretched over the front, on a box.
FurniturePart Front(const Vector3d& center, const Vector3d& size, const std::string& kind) {
  return {center, size, kind, {0, 0}, {0.5, 0.5, 0.5}};
}

Parts MakeTable(const Vector3d& size, RandomStream&) {
  constexpr double kTop = 0.03, kLeg = 0.05;
  const double height = size.z() - kTop;
  Parts parts{Main({0, 0, size.z() - kTop / 2}, {size.x(), size.y(), kTop})};
  for (const int i : {-1, 1}) {
    for (const int j : {-1, 1}) {
      const double x = i * (size.x() / 2 - kLeg), y = j * (size.y() / 2 - kLeg);
      parts.push_back(Plain({x, y, height / 2}, {kLeg, kLeg, height}, {0.25, 0.25, 0.27}));
    }
  }
  return parts;
}

Parts MakeChair(const Vector3d& size, RandomStream& random) {
  const double seat = 0.5 * size.z(), depth = size.x(), width = size.y();
  const Vector3d cloth =
      Vector3d(0.2, 0.25, 0.4) + 0.2 * Vector3d(random.Uniform(), random.Uniform(), random.Uniform());
  Parts parts{Plain({0, 0, seat}, {depth, width, 0.05}, cloth),
              Main({-depth / 2 + 0.02, 0, 0.75 * size.z() + 0.06}, {0.03, width, 0.5 * size.z() - 0.1})};
  for (const int j : {-1, 1}) {
    parts.push_back(Plain({0, j * (width / 2 - 0.02), seat / 2}, {0.8 * depth, 0.03, seat}, {0.2, 0.2, 0.2}));
  }
  return parts;
}

Parts MakeShelf(const Vector3d& size, RandomStream& random) {
  constexpr double kBoard = 0.02;
  const double depth = size.x(), width = size.y(), height = size.z();
  Parts parts{Main({-depth / 2 + kBoard / 2, 0, height / 2}, {kBoard, width, height})};
  for (const int j : {-1, 1}) {
    parts.push_back(Main({0, j * (width - kBoard) / 2, height / 2}, {depth, kBoard, height}));
  }
  const int tiers = std::max(1, int(height / 0.36));
  const double pitch = (height - kBoard) / tiers, inner = width - 2 * kBoard;
  for (int tier = 0; tier <= tiers; ++tier) {
    const double z = kBoard / 2 + tier * pitch;
    parts.push_back(Main({0, 0, z}, {depth - 0.002, inner, kBoard}));
    if (tier == tiers) break;
    const double tall = (pitch - kBoard) * random.Uniform(0.75, 0.92), deep = depth * random.Uniform(0.6, 0.85);
    const double wide = inner * random.Uniform(0.7, 1.0), left = random.Uniform(-0.5, 0.5) * (inner - wide);
    parts.push_back(
        Front({-depth / 2 + kBoard + deep / 2, left, z + kBoard / 2 + tall / 2}, {deep, wide, tall}, "books"));
  }
  return parts;
}

Parts MakeCupboard(const Vector3d& size, RandomStream&) {
  const double depth = size.x(), width = size.y(), height = size.z();
  Parts parts{Main({0, 0, height / 2}, size)};
  for (const int j : {-1, 1}) {  // two doors with handles
    parts.push_back(Main({depth / 2 + 0.008, j * width / 4, height / 2}, {0.016, width / 2 - 0.01, height - 0.06}));
    parts.push_back(Plain({depth / 2 + 0.025, j * 0.05, 0.55 * height}, {0.02, 0.015, 0.12}, {0.8, 0.8, 0.82}));
  }
  return parts;
}

Parts MakeCarton(const Vector3d& size, RandomStream&) { return {Front({0, 0, size.z() / 2}, size, "main")}; }

Parts MakePillar(const Vector3d& size, RandomStream&) { return {Main({0, 0, size.z() / 2}, size)}; }

Parts MakeDesk(const Vector3d& size, RandomStream& random) {
  Parts parts = MakeTable(size, random);
  const double x = -size.x() / 4, top = size.z();
  parts.push_back(Front({x, 0, top + 0.24}, {0.03, 0.52, 0.32}, "dead_leaves"));  // a screen that shows a photograph
  parts.push_back(Plain({x - 0.02, 0, top + 0.06}, {0.04, 0.08, 0.12}, {0.1, 0.1, 0.1}));
  parts.push_back(Front({size.x() / 4, 0.28 * size.y(), top + 0.03}, {0.21, 0.16, 0.06}, "books"));
  return parts;
}

Parts MakeBin(const Vector3d& size, RandomStream&) {
  return {{{0, 0, size.z() / 2}, size, "main", {0, 0}, {0.24, 0.3, 0.36}},
          Plain({0, 0, size.z() - 0.01}, {size.x() + 0.02, size.y() + 0.02, 0.02}, {0.12, 0.12, 0.13})};
}

Parts MakeBench(const Vector3d& size, RandomStream&) {
  Parts parts{Main({0, 0, size.z() - 0.02}, {size.x(), size.y(), 0.04})};
  for (const int j : {-1, 1}) {
    parts.push_back(
        Plain({0, 0.4 * j * size.y(), size.z() / 2 - 0.02}, {0.8 * size.x(), 0.05, size.z() - 0.04}, {0.3, 0.3, 0.32}));
  }
  return parts;
}

Parts MakePedestalTable(const Vector3d& size, RandomStream&) {
  constexpr double kTop = 0.04, kColumn = 0.14;
  return {Main({0, 0, size.z() - kTop / 2}, {size.x(), size.y(), kTop}),
          Plain({0, 0, (size.z() - kTop) / 2}, {kColumn, kColumn, size.z() - kTop}, {0.25, 0.25, 0.27})};
}

Parts MakeStool(const Vector3d& size, RandomStream& random) {
  constexpr double kSeat = 0.06, kColumn = 0.12;
  const Vector3d cloth =
      Vector3d(0.35, 0.2, 0.15) + 0.25 * Vector3d(random.Uniform(), random.Uniform(), random.Uniform());
  return {Plain({0, 0, size.z() - kSeat / 2}, {size.x(), size.y(), kSeat}, cloth),
          Plain({0, 0, (size.z() - kSeat) / 2}, {kColumn, kColumn, size.z() - kSeat}, {0.2, 0.2, 0.2})};
}

Parts MakeExtinguisher(const Vector3d& size, RandomStream&) {
  return {Plain({0, 0, 0.4 * size.z()}, {size.x(), size.y(), 0.8 * size.z()}, {0.75, 0.1, 0.08}),
          Plain({0, 0, 0.86 * size.z()}, {0.4 * size.x(), 0.4 * size.y(), 0.12 * size.z()}, {0.1, 0.1, 0.1}),
          Front({0.505 * size.x(), 0, 0.45 * size.z()}, {0.01 * size.x(), 0.7 * size.y(), 0.35 * size.z()}, "poster")};
}

Parts MakeRadiator(const Vector3d& size, RandomStream&) {
  constexpr double kFoot = 0.1;
  const Vector3d paint(0.86, 0.86, 0.84);
  const int ribs = std::max(2, int(size.y() / 0.2));
  Parts parts{
      Plain({-size.x() / 4, 0, (size.z() + kFoot) / 2}, {size.x() / 2, size.y(), size.z() - kFoot}, 0.8 * paint)};
  for (int i = 0; i < ribs; ++i) {
    const double y = ((i + 0.5) / ribs - 0.5) * size.y();
    parts.push_back(
        Plain({0, y, (size.z() + kFoot) / 2}, {size.x(), 0.55 * size.y() / ribs, size.z() - kFoot - 0.03}, paint));
  }
  return parts;
}

/// Its body shows wheels and doors; bonnet, windows and roof are plain.
Parts MakeCar(const Vector3d& size, RandomStream& random) {
  const double length = size.x(), width = size.y(), waist = 0.57 * size.z(), clear = 0.12;
  const double cabin = random.Uniform(0.5, 0.62) * length, back = random.Uniform(-0.12, -0.04) * length;
  const Vector3d silver(0.7, 0.71, 0.73), glass(0.13, 0.16, 0.19);
  Parts parts{Front({0, 0, (waist + clear) / 2}, {length, width, waist - clear}, "car_body")};
  const auto paint = [&](double x, double z, double long_m, double wide_m, double tall_m) {
    parts.push_back({{x, 0, z}, {long_m, wide_m, tall_m}, "main", {0, 0}, silver});
  };
  paint(0, waist + 0.02, length - 0.04, width - 0.04, 0.04);
  parts.push_back(Plain({back, 0, (waist + size.z()) / 2}, {cabin, 0.9 * width, size.z() - waist - 0.06}, glass));
  paint(back, size.z() - 0.03, 0.92 * cabin, 0.92 * width, 0.06);
  return parts;
}

/// A soccer goal that opens to the front; the net is a plain back.
Parts MakeGoal(const Vector3d& size, RandomStream&) {
  constexpr double kPost = 0.06;
  const double depth = size.x(), width = size.y(), height = size.z();
  Parts parts{{{-depth / 2, 0, height / 2}, {0.02, width, height}, "main", {0, 0}, {0.8, 0.8, 0.8}},
              {{depth / 2, 0, height - kPost / 2}, {kPost, width + kPost, kPost}, "main", {0, 0}, {0.9, 0.9, 0.9}}};
  for (const int j : {-1, 1}) {
    parts.push_back({{0, j * width / 2, 0.3 * height}, {depth, 0.02, 0.6 * height}, "main", {0, 0}, {0.8, 0.8, 0.8}});
    parts.push_back({{depth / 2, j * width / 2, height / 2 - kPost / 2},
                     {kPost, kPost, height - kPost},
                     "main",
                     {0, 0},
                     {0.9, 0.9, 0.9}});
  }
  return parts;
}

}  // namespace

const std::vector<FurnitureKind>& AllFurniture() {
  static const std::vector<FurnitureKind> kinds = {
      {"bench", {0.34, 1.4, 0.44}, "wood", false, 1, MakeBench},
      {"bin", {0.28, 0.28, 0.35}, "", false, 0, MakeBin},
      {"car", {4.2, 1.7, 1.45}, "", true, 0, MakeCar},
      {"carton", {0.4, 0.5, 0.35}, "cardboard", true, 0, MakeCarton},
      {"chair", {0.42, 0.42, 0.85}, "wood", false, 0.53, MakeChair},
      {"cupboard", {0.45, 0.9, 1.9}, "wood", false, 0, MakeCupboard},
      {"desk", {0.7, 1.4, 0.74}, "wood", false, 0, MakeDesk},
      {"extinguisher", {0.16, 0.16, 0.5}, "", false, 0, MakeExtinguisher},
      {"goal", {0.4, 0.8, 0.8}, "", false, 0, MakeGoal},
      {"pedestal_table", {0.8, 1.5, 0.74}, "wood", false, 0, MakePedestalTable},
      {"pillar", {0.5, 0.5, 3.0}, "concrete", false, 0, MakePillar},
      {"radiator", {0.1, 1.2, 0.6}, "", false, 0, MakeRadiator},
      {"shelf", {0.3, 0.9, 1.85}, "wood", false, 0, MakeShelf},
      {"stool", {0.36, 0.36, 0.46}, "", false, 1, MakeStool},
      {"table", {0.7, 1.2, 0.73}, "wood", false, 0, MakeTable},
  };
  return kinds;
}

const std::vector<std::string>& FurnitureKinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const FurnitureKind& kind : AllFurniture()) list.push_back(kind.name);
    return list;
  }();
  return names;
}

}  // namespace gaitcam
