#include "models/code/scenes/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/random.h"
#include "models/code/scenes/furniture.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double Radians(double degrees) { return degrees * M_PI / 180; }

/// Box frame of something flat and upright: z out of the picture, y up, x to the right as seen by a viewer.
Eigen::Matrix3d FacingRotation(double yaw) {
  Eigen::Matrix3d R;
  R << -std::sin(yaw), 0, std::cos(yaw), std::cos(yaw), 0, std::sin(yaw), 0, 1, 0;
  return R;
}

void CheckPositive(const OptionValue& node, const std::string& key, const Eigen::Ref<const Eigen::VectorXd>& value) {
  if (value.allFinite() && value.minCoeff() > 0) return;
  (node.Has(key) ? node.Child(key) : node).Fail("expected lengths above 0");
}

void CheckColor(const OptionValue& node, const std::string& key, const Vector3d& rgb) {
  if (rgb.allFinite() && rgb.minCoeff() >= 0 && rgb.maxCoeff() <= 1) return;
  node.Child(key).Fail("expected three numbers from 0 to 1");
}

/// An occupied rectangle of a wall: from left to right and from bottom to top, m.
struct Taken {
  double left, right, bottom, top;
  bool Overlaps(const Taken& o) const { return left < o.right && o.left < right && bottom < o.top && o.bottom < top; }
};

/// One straight piece of a wall's visible surface.
struct WallPiece {
  Vector2d from, to;
  bool convex_from = false, convex_to = false;  ///< The next piece bends away from the viewer.

  double Length() const { return (to - from).norm(); }
  Vector2d Along() const { return (to - from).normalized(); }
  Vector2d Normal() const { return {-Along().y(), Along().x()}; }  ///< To the left: towards the viewer.
};

/// Builds a Scene from its file.
class SceneBuilder {
 public:
  SceneBuilder(const OptionValue& root, const SceneFile& file) : root_(root), file_(file) {
    scene_.file = root.origin().file;
    scene_.name = scene_.file.stem().string();
  }

  Scene Build();

 private:
  TextureOptions Resolve(const TextureUse& use) const;
  int AddTexture(const TextureOptions& options, const OptionValue& node);
  int AddTexture(const TextureUse& use);
  void AddBox(const std::string& name, const Pose& X_WB, const Vector3d& size, int texture, const Vector2d& repeat,
              const Vector3d& rgb, bool collides = true);

  void AddFloor();
  void AddCeiling(const CeilingEntry& ceiling);
  void ScatterPrints();
  void AddLights();
  void AddWall(const WallEntry& wall, const OptionValue& node, int index);
  void AddWallPiece(const WallEntry& wall, const WallPiece& piece, const std::string& name);
  void ScatterPosters(const WallEntry& wall, const OptionValue& node, const std::vector<WallPiece>& pieces, int index);
  std::vector<Taken> TakenOn(const WallPiece& piece) const;
  void AddPoster(const PosterEntry& poster, const TextureOptions& options, const OptionValue& node);
  void AddSpotBefore(const Vector2d& at, double yaw, double depth_m);
  int PartTexture(const FurnitureEntry& piece, const FurnitureKind& kind, const FurniturePart& part,
                  const OptionValue& node, int index, int number);
  void AddFurniture(const FurnitureEntry& piece, const OptionValue& node, int index);
  void AddBoxEntry(const BoxEntry& box, const OptionValue& node, int index);

  OptionValue root_;
  const SceneFile& file_;
  Scene scene_;
  std::vector<std::pair<std::string, Vector2d>> texture_keys_;  ///< Per texture: its complete options; one repeat, m.
  int hung_posters_ = 0;
};

TextureOptions SceneBuilder::Resolve(const TextureUse& use) const {
  if (use.options) return *use.options;
  const auto named = file_.textures.find(use.name);
  if (named != file_.textures.end()) return named->second;
  TextureOptions options;
  options.kind = use.name;
  const std::vector<std::string>& kinds = TextureKinds();
  if (std::find(kinds.begin(), kinds.end(), use.name) != kinds.end()) return options;
  std::vector<std::string> known = kinds;
  for (const auto& [name, unused] : file_.textures) known.push_back(name);
  use.node->Fail("\"" + use.name + "\" is no texture; " +
                 DidYouMean(use.name, known, "known here: " + JoinWords(known)));
}

int SceneBuilder::AddTexture(const TextureOptions& wanted, const OptionValue& node) {
  try {
    TextureOptions options = CompleteTexture(wanted);
    const std::string key = fmt::format("{} {} {} {} {} {} {} {} {} {} {}", options.kind, options.size_m.x(),
                                        options.size_m.y(), options.px_per_m, options.unit_m, options.contrast,
                                        options.rgb.x(), options.rgb.y(), options.rgb.z(), options.seed, options.file);
    for (size_t i = 0; i < texture_keys_.size(); ++i) {
      if (texture_keys_[i].first == key) return int(i);
    }
    texture_keys_.emplace_back(key, options.size_m);
    options.seed += 1000003 * file_.seed;  // no two scenes share a texture
    const std::string name = fmt::format("{}{}", options.kind, scene_.textures.size());
    const auto make = [options, folder = root_.folder()] { return MakeTexture(options, folder); };
    scene_.textures.push_back({name, TextureSize(options, root_.folder()), make});
    const std::filesystem::path picture = PictureFile(options, root_.folder());
    if (!picture.empty()) scene_.pictures.push_back(picture);
  } catch (const BadInput& e) {
    node.Fail(e.what());
  }
  if (int(scene_.textures.size()) > kMaxSceneTextures) {
    node.Fail(fmt::format("one texture too many; MuJoCo draws at most {} in a scene", kMaxSceneTextures));
  }
  return int(scene_.textures.size()) - 1;
}

int SceneBuilder::AddTexture(const TextureUse& use) {
  if (!use.options && (use.name.empty() || use.name == "none")) return -1;
  return AddTexture(Resolve(use), *use.node);
}

void SceneBuilder::AddBox(const std::string& name, const Pose& X_WB, const Vector3d& size, int texture,
                          const Vector2d& repeat, const Vector3d& rgb, bool collides) {
  SceneBox box;
  box.name = name;
  box.X_WB = X_WB;
  box.size = size;
  box.texture = texture;
  box.texture_size_m = repeat;
  box.rgb = rgb;
  box.collides = collides;
  scene_.boxes.push_back(std::move(box));
}

void SceneBuilder::AddFloor() {
  const FloorEntry& floor = file_.floor;
  const OptionValue node = root_.Has("floor") ? root_.Child("floor") : root_;
  if (floor.extent.size() != 2 || !((floor.extent[1] - floor.extent[0]).minCoeff() > 0)) {
    node.Child("extent").Fail("expected [[min x, min y], [max x, max y]] with max above min");
  }
  scene_.floor_min = floor.extent[0];
  scene_.floor_max = floor.extent[1];
  scene_.floor_friction = floor.friction;
  if (floor.texture.name.empty() && !floor.texture.options) node.Fail("texture: missing; a floor needs one");
  scene_.floor_texture = AddTexture(floor.texture);
  if (scene_.floor_texture < 0) floor.texture.node->Fail("a floor needs a texture");
  scene_.floor_texture_size_m = texture_keys_[scene_.floor_texture].second;
}

void SceneBuilder::AddCeiling(const CeilingEntry& ceiling) {
  constexpr double kThick = 0.05;
  const int texture = AddTexture(ceiling.texture);
  const Vector2d middle = (scene_.floor_min + scene_.floor_max) / 2, size = scene_.floor_max - scene_.floor_min;
  AddBox("ceiling", Pose(Eigen::Quaterniond::Identity(), {middle.x(), middle.y(), ceiling.height_m + kThick / 2}),
         {size.x(), size.y(), kThick}, texture, texture < 0 ? Vector2d(0, 0) : texture_keys_[texture].second,
         {0.9, 0.9, 0.89}, false);
}

void SceneBuilder::ScatterPrints() {
  const PrintScatter& prints = file_.floor.prints;
  if (prints.count == 0) return;
  const OptionValue node = root_.Child("floor").Child("prints");
  CheckPositive(node, "width_m", prints.width_m);
  if (prints.textures.empty()) node.Fail("textures: expected at least one kind");
  RandomStream random(file_.seed, "place.prints");
  std::vector<Vector3d> disks;  // x, y, and the half diagonal of what lies there
  for (int attempt = 0; int(disks.size()) < prints.count && attempt < 200 * prints.count; ++attempt) {
    const double width = random.Uniform(prints.width_m.x(), prints.width_m.y());
    const double height = width * (random.Uniform() < 0.5 ? 0.707 : 1.414);  // DIN formats
    const double reach = std::hypot(width, height) / 2, angle = random.Uniform(0, 360);
    const double x = random.Uniform(scene_.floor_min.x(), scene_.floor_max.x());
    const double y = random.Uniform(scene_.floor_min.y(), scene_.floor_max.y());
    const double edge = std::min(
        {x - scene_.floor_min.x(), scene_.floor_max.x() - x, y - scene_.floor_min.y(), scene_.floor_max.y() - y});
    const auto touches = [&](const Vector3d& d) { return std::hypot(d.x() - x, d.y() - y) < d.z() + reach; };
    if (edge < reach || std::any_of(disks.begin(), disks.end(), touches)) continue;
    PosterEntry print;
    print.at = {x, y, 0};
    print.facing_deg = angle;
    print.lies = true;
    print.size = {width, height};
    print.thickness_m = 0.001;
    print.texture.name = prints.textures[disks.size() % prints.textures.size()];
    print.texture.node = node;
    AddPoster(print, Resolve(print.texture), node);
    disks.emplace_back(x, y, reach);
  }
  if (int(disks.size()) < prints.count) {
    node.Fail(
        fmt::format("there is room for {} of {} prints; expected fewer or smaller ones", disks.size(), prints.count));
  }
}

void SceneBuilder::AddLights() {
  for (size_t i = 0; i < file_.lights.size(); ++i) {
    const LightEntry& entry = file_.lights[i];
    if (!(entry.direction.norm() > 0))
      root_.Child("lights").Element(i).Fail("direction: expected a vector of length above 0");
    scene_.lights.push_back(
        {entry.position, entry.direction.normalized(), entry.directional, entry.brightness, entry.casts_shadow});
  }
}

std::vector<WallPiece> Pieces(const WallEntry& wall) {
  std::vector<WallPiece> pieces;
  const size_t count = wall.points.size(), ends = wall.closed ? count : count - 1;
  for (size_t i = 0; i < ends; ++i) pieces.push_back({wall.points[i], wall.points[(i + 1) % count]});
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (i + 1 == pieces.size() && !wall.closed) break;
    WallPiece& next = pieces[(i + 1) % pieces.size()];
    const Vector2d a = pieces[i].Along(), b = next.Along();
    pieces[i].convex_to = next.convex_from = a.x() * b.y() - a.y() * b.x() < 0;  // a turn to the right
  }
  return pieces;
}

void SceneBuilder::AddWallPiece(const WallEntry& wall, const WallPiece& piece, const std::string& name) {
  // At inner corners pieces reach into each other behind the surface; at outer ones they stop just before the next
  // piece's surface, so that no two faces lie in one plane.
  constexpr double kGap = 0.001;
  const double before = piece.convex_from ? -kGap : wall.thickness_m,
               after = piece.convex_to ? -kGap : wall.thickness_m;
  const Vector2d middle = (piece.from + piece.to) / 2 + (after - before) / 2 * piece.Along();
  const double length = piece.Length() + before + after;
  const Eigen::Matrix3d R = FacingRotation(std::atan2(piece.Normal().y(), piece.Normal().x()));
  const Vector2d back = middle - wall.thickness_m / 2 * piece.Normal();
  const int texture = AddTexture(wall.texture);
  AddBox(name, Pose(R, {back.x(), back.y(), (wall.base_m + wall.height_m) / 2}),
         {length, wall.height_m - wall.base_m, wall.thickness_m}, texture,
         texture < 0 ? Vector2d(0, 0) : texture_keys_[texture].second, wall.rgb);
  if (wall.skirting_m == 0) return;
  constexpr double kThick = 0.014;
  const double reach = piece.convex_to ? kThick : 0, reach_from = piece.convex_from ? kThick : 0;
  const Vector2d at =
      (piece.from + piece.to) / 2 + (reach - reach_from) / 2 * piece.Along() + kThick / 2 * piece.Normal();
  AddBox(name + ".skirting", Pose(R, {at.x(), at.y(), wall.skirting_m / 2}),
         {piece.Length() + reach + reach_from, wall.skirting_m, kThick}, -1, {0, 0}, wall.skirting_rgb);
}

void SceneBuilder::AddWall(const WallEntry& wall, const OptionValue& node, int index) {
  if (!(wall.height_m > wall.base_m)) node.Fail("height_m: expected more than base_m");
  if (wall.points.size() < 2) node.Fail("points: expected at least two corners");
  CheckColor(node, "rgb", wall.rgb);
  CheckColor(node, "skirting_rgb", wall.skirting_rgb);
  const std::vector<WallPiece> pieces = Pieces(wall);
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (!(pieces[i].Length() > 0)) node.Child("points").Fail("two successive corners are the same");
    AddWallPiece(wall, pieces[i], fmt::format("wall{}.{}", index, i));
  }
}

/// The occupied rectangles of a piece of wall.
std::vector<Taken> SceneBuilder::TakenOn(const WallPiece& piece) const {
  std::vector<Taken> taken;
  for (const SceneBox& box : scene_.boxes) {
    if (box.name.rfind("poster", 0) != 0) continue;
    const Vector2d at = box.X_WB.translation.head<2>() - piece.from;
    if (std::abs(at.dot(piece.Normal())) > 0.1) continue;
    const double along = at.dot(piece.Along()), z = box.X_WB.translation.z();
    taken.push_back({along - box.size.x() / 2, along + box.size.x() / 2, z - box.size.y() / 2, z + box.size.y() / 2});
  }
  return taken;
}

void SceneBuilder::ScatterPosters(const WallEntry& wall, const OptionValue& node, const std::vector<WallPiece>& pieces,
                                  int index) {
  const PosterScatter& scatter = wall.posters;
  if (scatter.count == 0) return;
  const OptionValue here = node.Child("posters");
  CheckPositive(here, "width_m", scatter.width_m);
  if (scatter.textures.empty()) here.Fail("textures: expected at least one kind");
  RandomStream random(file_.seed, fmt::format("place.posters{}", index));
  double length = 0;
  for (const WallPiece& piece : pieces) length += piece.Length();
  constexpr double kMargin = 0.04;  // m between neighbours
  int hung = 0;
  for (int attempt = 0; hung < scatter.count && attempt < 200 * scatter.count; ++attempt) {
    double along = random.Uniform(0, length);
    const WallPiece* piece = pieces.data();
    while (along > piece->Length() && piece != &pieces.back()) along -= (piece++)->Length();
    const double width = random.Uniform(scatter.width_m.x(), scatter.width_m.y());
    const double height = width * (random.Uniform() < 0.5 ? 0.75 : 1.35);  // landscape or portrait
    const double bottom = random.Uniform(scatter.bottom_m.x(), scatter.bottom_m.y());
    if (along < width / 2 + kMargin || along > piece->Length() - width / 2 - kMargin) continue;
    if (bottom + height > std::min(scatter.top_m, wall.height_m)) continue;
    const Taken wish{along - width / 2 - kMargin, along + width / 2 + kMargin, bottom - kMargin,
                     bottom + height + kMargin};
    const std::vector<Taken> taken = TakenOn(*piece);
    if (std::any_of(taken.begin(), taken.end(), [&](const Taken& t) { return t.Overlaps(wish); })) continue;
    PosterEntry poster;
    const Vector2d at = piece->from + along * piece->Along();
    poster.at = {at.x(), at.y(), bottom + height / 2};
    poster.facing_deg = std::atan2(piece->Normal().y(), piece->Normal().x()) * 180 / M_PI;
    poster.size = {width, height};
    poster.texture.name = scatter.textures[hung % scatter.textures.size()];
    poster.texture.node = here;
    AddPoster(poster, Resolve(poster.texture), here);
    ++hung;
  }
  if (hung < scatter.count) {
    here.Fail(fmt::format("there is room for {} of {} posters; expected fewer or smaller ones", hung, scatter.count));
  }
}

void SceneBuilder::AddPoster(const PosterEntry& poster, const TextureOptions& wanted, const OptionValue& node) {
  CheckPositive(node, "size", poster.size);
  TextureOptions options = wanted;
  if (options.size_m.isZero()) options.size_m = poster.size;
  if (options.px_per_m == 0) {  // small prints are seen from nearby, large ones from afar
    options.px_per_m = std::clamp(360 / options.size_m.maxCoeff(), 300.0, 1200.0);
  }
  if (poster.seed) {
    options.seed = uint64_t(*poster.seed);
  } else if (options.seed == 0) {
    options.seed = 1000 + uint64_t(hung_posters_);
  }
  const double yaw = Radians(poster.facing_deg);
  const Eigen::Matrix3d R = poster.lies ? RotZ(yaw - M_PI / 2) : FacingRotation(yaw);
  const Vector3d center = poster.at + R.col(2) * poster.thickness_m / 2;
  AddBox(fmt::format("poster{}", hung_posters_++), Pose(R, center),
         {poster.size.x(), poster.size.y(), poster.thickness_m}, AddTexture(options, node), {0, 0}, {1, 1, 1}, false);
  if (!poster.lies) AddSpotBefore(poster.at.head<2>(), yaw, 0);
}

/// Where somebody stands who looks at what faces `yaw`. @param depth_m from its middle to its front.
void SceneBuilder::AddSpotBefore(const Vector2d& at, double yaw, double depth_m) {
  constexpr double kBefore_m = 0.9;
  const Vector2d front(std::cos(yaw), std::sin(yaw));
  scene_.spots.push_back({at + (depth_m + kBefore_m) * front, WrapAngle(yaw + M_PI), 0});
}

/// @returns the texture of a part, or -1 for plain colour.
int SceneBuilder::PartTexture(const FurnitureEntry& piece, const FurnitureKind& kind, const FurniturePart& part,
                              const OptionValue& node, int index, int number) {
  if (part.texture.empty()) return -1;
  TextureOptions options;
  if (part.texture == "main") {
    if (piece.texture.options || !piece.texture.name.empty()) return AddTexture(piece.texture);
    if (kind.texture.empty() || piece.rgb) return -1;
    options.kind = kind.texture;
    options.seed = piece.seed ? uint64_t(*piece.seed) : kind.own_texture ? 3000 + uint64_t(index) : 0;
  } else {  // a picture on its front: one of its own, as large as the front
    options.kind = part.texture;
    options.seed = 5000 + 100 * uint64_t(index) + uint64_t(number);
    options.size_m = {part.size.y(), part.size.z()};
    if (piece.rgb) options.rgb = *piece.rgb;
  }
  return AddTexture(options, node);
}

void SceneBuilder::AddFurniture(const FurnitureEntry& piece, const OptionValue& node, int index) {
  const auto kind = std::find_if(AllFurniture().begin(), AllFurniture().end(),
                                 [&](const FurnitureKind& k) { return k.name == piece.kind; });
  GAITCAM_ASSERT(kind != AllFurniture().end());
  const Vector3d size = piece.size.isZero() ? kind->size : piece.size;
  CheckPositive(node, "size", size);
  if (piece.rgb) CheckColor(node, "rgb", *piece.rgb);
  RandomStream random(file_.seed, fmt::format("place.furniture{}", index));
  const Pose X_WF(RotZ(Radians(piece.yaw_deg)), {piece.at.x(), piece.at.y(), piece.base_m});
  int number = 0;
  for (const FurniturePart& part : kind->make(size, random)) {
    const int texture = PartTexture(piece, *kind, part, node, index, number);
    const bool repeats = texture >= 0 && !part.texture_size_m.isZero();
    AddBox(fmt::format("{}{}.{}", piece.kind, index, number++),
           X_WF * Pose(Eigen::Quaterniond::Identity(), part.center), part.size, texture,
           repeats ? texture_keys_[texture].second : Vector2d(0, 0),
           part.texture == "main" && piece.rgb ? *piece.rgb : part.rgb);
  }
  if (piece.base_m > 0) return;
  if (kind->seat > 0) {
    constexpr double kElbows_m = 0.6;  // of a bench, for each who sits on it
    const int seats = std::max(1, int(size.y() / kElbows_m));
    for (int i = 0; i < seats; ++i) {
      const Vector3d seat = X_WF * Vector3d(0, ((i + 0.5) / seats - 0.5) * size.y(), 0);
      scene_.spots.push_back({seat.head<2>(), Radians(piece.yaw_deg), kind->seat * size.z()});
    }
  } else {
    AddSpotBefore(piece.at, Radians(piece.yaw_deg), size.x() / 2);
  }
}

void SceneBuilder::AddBoxEntry(const BoxEntry& box, const OptionValue& node, int index) {
  CheckPositive(node, "size", box.size);
  CheckColor(node, "rgb", box.rgb);
  AddBox(box.name.empty() ? fmt::format("box{}", index) : box.name, Pose(RotZ(Radians(box.yaw_deg)), box.at), box.size,
         AddTexture(box.texture), box.texture_size_m, box.rgb, box.collides);
}

Scene SceneBuilder::Build() {
  AddFloor();
  if (file_.ceiling) AddCeiling(*file_.ceiling);
  AddLights();
  const auto each = [&](const char* key, const auto& entries, auto add) {
    for (size_t i = 0; i < entries.size(); ++i) add(entries[i], root_.Child(key).Element(i), int(i));
  };
  each("walls", file_.walls, [&](const auto& e, const OptionValue& n, int i) { AddWall(e, n, i); });
  each("posters", file_.posters, [&](const PosterEntry& e, const OptionValue& n, int) {
    if (!e.texture.options && e.texture.name.empty()) n.Fail("texture: missing; a poster needs one");
    AddPoster(e, Resolve(e.texture), n);
  });
  ScatterPrints();
  each("walls", file_.walls, [&](const auto& e, const OptionValue& n, int i) { ScatterPosters(e, n, Pieces(e), i); });
  each("furniture", file_.furniture, [&](const auto& e, const OptionValue& n, int i) { AddFurniture(e, n, i); });
  each("boxes", file_.boxes, [&](const auto& e, const OptionValue& n, int i) { AddBoxEntry(e, n, i); });
  CheckColor(root_, "background_rgb", file_.background_rgb);
  scene_.background_rgb = file_.background_rgb;
  scene_.ambient = file_.ambient;
  scene_.light = file_.light;
  scene_.start = {file_.start.x(), file_.start.y(), Radians(file_.start.z())};
  scene_.crowd = file_.crowd;
  try {
    AddPeople(file_.people, scene_);
  } catch (const BadInput& e) {
    root_.Child("people").Fail(e.what());
  }
  return std::move(scene_);
}

}  // namespace

Scene BuildScene(const SceneFile& file, const OptionValue& root) { return SceneBuilder(root, file).Build(); }

}  // namespace gaitcam
