/// The content of a scene's YAML file. `ReadScene` builds a Scene from it.
///
///   seed: 1
///   textures:                         # names for textures that are used below; a bare kind is a texture, too
///     oak: {kind: planks, size_m: [6, 6], px_per_m: 480}
///   floor: {extent: [[-3, -3], [3, 3]], texture: oak}
///   walls:
///     - {points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true, height_m: 2.5, texture: paint}
///   posters:
///     - {at: [3, 0, 1.2], facing_deg: 180, size: [0.6, 0.8], texture: dead_leaves}
///   furniture:
///     - {kind: table, at: [1, 1], yaw_deg: 30, size: [1.2, 0.7, 0.72], texture: wood}
///   boxes:
///     - {at: [0, 2, 0.2], size: [0.4, 0.4, 0.4], texture: cardboard}
///   people:
///     - {path: [[1, -2], [1, 2]], repeat: true, speed_m_s: 1.1}
///   crowd: {count: 20, talking: 0.3}
///
/// With `base: lab` it is that scene but for the keys that it gives: maps are laid over the base's, lists and single
/// values replace it. Pictures that it shows lie beside its own file.

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/option_reader.h"
#include "models/code/scenes/scene.h"
#include "models/code/textures/texture.h"

namespace gaitcam {

/// A texture as it is named in a file: a kind ("paint"), a name out of `textures`, or a map of TextureOptions.
struct TextureUse {
  std::string name;                       ///< Empty: no texture; "none" likewise.
  std::optional<TextureOptions> options;  ///< Written out on the spot.
  std::optional<OptionValue> node;        ///< Where it stands, for errors.
};
void ReadOption(const OptionValue& node, TextureUse& use);

/// Flat prints at random positions on the floor, without overlap. Robots walk over them unhindered.
struct PrintScatter {
  using DescribedTag = void;
  int count = 0;
  std::vector<std::string> textures{"poster"};
  Eigen::Vector2d width_m{0.2, 0.4};
};

/// Corners of the floor: [[min x, min y], [max x, max y]].
struct FloorEntry {
  using DescribedTag = void;
  std::vector<Eigen::Vector2d> extent{{-3, -3}, {3, 3}};
  TextureUse texture;
  double friction = 0.8;
  PrintScatter prints;
};

/// Posters at random positions on a wall, without overlap.
struct PosterScatter {
  using DescribedTag = void;
  int count = 0;
  std::vector<std::string> textures{"dead_leaves"};
  Eigen::Vector2d width_m{0.4, 0.8};
  Eigen::Vector2d bottom_m{0.2, 1.0};
  double top_m = 2.2;
};

/// A polyline of walls; points lie on the visible surface, which is on the left when going from one to the next.
struct WallEntry {
  using DescribedTag = void;
  std::vector<Eigen::Vector2d> points;
  bool closed = false;
  double base_m = 0;
  double height_m = 2.5;
  double thickness_m = 0.1;
  TextureUse texture;
  Eigen::Vector3d rgb{0.82, 0.81, 0.77};
  double skirting_m = 0;
  Eigen::Vector3d skirting_rgb{0.35, 0.27, 0.2};
  PosterScatter posters;
};

/// A slab over the whole floor.
struct CeilingEntry {
  using DescribedTag = void;
  double height_m = 2.6;
  TextureUse texture;
};

/// Something printed that hangs on a wall or lies on a table. `at` is the middle of its back.
struct PosterEntry {
  using DescribedTag = void;
  Eigen::Vector3d at{0, 0, 1};
  double facing_deg = 0;
  bool lies = false;
  Eigen::Vector2d size{0.6, 0.8};
  double thickness_m = 0.008;
  TextureUse texture;
  std::optional<int> seed;
};

struct BoxEntry {
  using DescribedTag = void;
  std::string name;
  Eigen::Vector3d at{0, 0, 0.25};
  Eigen::Vector3d size{0.5, 0.5, 0.5};
  double yaw_deg = 0;
  TextureUse texture;
  Eigen::Vector2d texture_size_m{0, 0};
  Eigen::Vector3d rgb{0.7, 0.7, 0.7};
  bool collides = true;
};

/// Several boxes that make a piece of furniture; see `FurnitureKinds`.
struct FurnitureEntry {
  using DescribedTag = void;
  std::string kind = "table";
  Eigen::Vector2d at{0, 0};
  double base_m = 0;
  double yaw_deg = 0;
  Eigen::Vector3d size{0, 0, 0};
  TextureUse texture;
  std::optional<Eigen::Vector3d> rgb;
  std::optional<int> seed;
};

struct LightEntry {
  using DescribedTag = void;
  Eigen::Vector3d position{0, 0, 2.5};
  Eigen::Vector3d direction{0, 0, -1};
  bool directional = false;
  double brightness = 0.5;
  bool casts_shadow = false;
};

struct SceneFile {
  using DescribedTag = void;
  std::string base;
  uint64_t seed = 0;
  std::map<std::string, TextureOptions> textures;
  FloorEntry floor;
  std::optional<CeilingEntry> ceiling;
  std::vector<WallEntry> walls;
  std::vector<PosterEntry> posters;
  std::vector<FurnitureEntry> furniture;
  std::vector<BoxEntry> boxes;
  std::vector<LightEntry> lights;
  double ambient = 0.4;
  double light = 1;
  Eigen::Vector3d background_rgb{0.55, 0.65, 0.75};
  Eigen::Vector3d start{0, 0, 0};
  std::vector<PersonOptions> people;
  std::optional<CrowdEntry> crowd;
};
void ReadOption(const OptionValue& node, std::map<std::string, TextureOptions>& textures);

/// Names of the kinds of furniture, sorted.
const std::vector<std::string>& FurnitureKinds();

template <class Visitor>
void VisitFields(Visitor& visit, PrintScatter& o) {
  visit("count", o.count, Between(0, 80), "how many");
  visit("textures", o.textures, Nested(), "kinds of texture, in turn");
  visit("width_m", o.width_m, Nested(), "narrowest, widest");
}

template <class Visitor>
void VisitFields(Visitor& visit, FloorEntry& o) {
  visit("extent", o.extent, Nested(), "[[min x, min y], [max x, max y]], m");
  visit("texture", o.texture, Nested(), "what it looks like");
  visit("friction", o.friction, Between(0.01, 5), "sliding friction");
  visit("prints", o.prints, Nested(), "flat prints at random positions on it");
}

template <class Visitor>
void VisitFields(Visitor& visit, CeilingEntry& o) {
  visit("height_m", o.height_m, Positive(), "of its underside over the floor");
  visit("texture", o.texture, Nested(), "what it looks like");
}

template <class Visitor>
void VisitFields(Visitor& visit, PosterScatter& o) {
  visit("count", o.count, Between(0, 80), "how many");
  visit("textures", o.textures, Nested(), "kinds of texture, in turn");
  visit("width_m", o.width_m, Nested(), "narrowest, widest");
  visit("bottom_m", o.bottom_m, Nested(), "height of the lower edge over the floor: lowest, highest");
  visit("top_m", o.top_m, Positive(), "no poster reaches higher");
}

template <class Visitor>
void VisitFields(Visitor& visit, WallEntry& o) {
  visit("points", o.points, Nested(), "corners of the visible surface, which is on the left when going along them");
  visit("closed", o.closed, Nested(), "the last point is joined with the first");
  visit("base_m", o.base_m, Between(-10, 10), "height of its lower edge over the floor");
  visit("height_m", o.height_m, Positive(), "height of its upper edge over the floor");
  visit("thickness_m", o.thickness_m, Between(0.005, 5), "behind the visible surface");
  visit("texture", o.texture, Nested(), "what it looks like");
  visit("rgb", o.rgb, Nested(), "colour without a texture");
  visit("skirting_m", o.skirting_m, Between(0, 1), "height of the skirting board; 0: none");
  visit("skirting_rgb", o.skirting_rgb, Nested(), "its colour");
  visit("posters", o.posters, Nested(), "posters at random positions on this wall");
}

template <class Visitor>
void VisitFields(Visitor& visit, PosterEntry& o) {
  visit("at", o.at, Nested(), "middle of its back");
  visit("facing_deg", o.facing_deg, AnyNumber(),
        "where the picture looks, 0 is +x; lying: where its upper edge points");
  visit("lies", o.lies, Nested(), "on its back, picture up");
  visit("size", o.size, Nested(), "width, height");
  visit("thickness_m", o.thickness_m, Between(0.0005, 1), "of the board");
  visit("texture", o.texture, Nested(), "what it shows");
  visit("seed", o.seed, Nested(), "of its texture; otherwise each poster of a scene has its own");
}

template <class Visitor>
void VisitFields(Visitor& visit, BoxEntry& o) {
  visit("name", o.name, AnyText(), "for error messages");
  visit("at", o.at, Nested(), "middle");
  visit("size", o.size, Nested(), "full edges");
  visit("yaw_deg", o.yaw_deg, AnyNumber(), "about the vertical, positive to the left");
  visit("texture", o.texture, Nested(), "on all six faces");
  visit("texture_size_m", o.texture_size_m, Nested(), "one repeat; 0: the picture is stretched over each face");
  visit("rgb", o.rgb, Nested(), "colour without a texture");
  visit("collides", o.collides, Nested(), "whether robots bump into it");
}

template <class Visitor>
void VisitFields(Visitor& visit, FurnitureEntry& o) {
  visit("kind", o.kind, OneOf(FurnitureKinds()), "what it is");
  visit("at", o.at, Nested(), "middle of its footprint; its front is +x at yaw 0");
  visit("base_m", o.base_m, AtLeast(0), "height of its foot over the floor");
  visit("yaw_deg", o.yaw_deg, AnyNumber(), "0: its front looks to +x");
  visit("size", o.size, Nested(), "depth, width, height; 0: as is usual");
  visit("texture", o.texture, Nested(), "otherwise as is usual");
  visit("rgb", o.rgb, Nested(), "colour of a kind that has no texture");
  visit("seed", o.seed, Nested(), "of its texture");
}

template <class Visitor>
void VisitFields(Visitor& visit, LightEntry& o) {
  visit("position", o.position, Nested(), "m");
  visit("direction", o.direction, Nested(), "where the light goes");
  visit("directional", o.directional, Nested(), "parallel light, from far away");
  visit("brightness", o.brightness, Between(0, 1), "diffuse");
  visit("casts_shadow", o.casts_shadow, Nested(), "costs much time in software rendering");
}

template <class Visitor>
void VisitFields(Visitor& visit, SceneFile& o) {
  visit("base", o.base, AnyText(), "shipped scene, or path of a scene YAML, that this one is but for its own keys");
  visit("seed", o.seed, AtLeast(0), "of all textures and random positions");
  visit("textures", o.textures, Nested(), "names of textures");
  visit("floor", o.floor, Nested(), "");
  visit("ceiling", o.ceiling, Nested(), "none unless given");
  visit("walls", o.walls, Nested(), "");
  visit("posters", o.posters, Nested(), "");
  visit("furniture", o.furniture, Nested(), "");
  visit("boxes", o.boxes, Nested(), "");
  visit("lights", o.lights, Nested(), "");
  visit("ambient", o.ambient, Between(0, 1), "light from everywhere");
  visit("light", o.light, Between(0.001, 100),
        "factor on all light that reaches a camera; 1: display white is just white at camera.reference_exposure_ms");
  visit("background_rgb", o.background_rgb, Nested(), "beyond everything");
  visit("start", o.start, Nested(), "x, y in m, yaw in degrees");
  visit("people", o.people, Nested(), "who walks or stands there");
  visit("crowd", o.crowd, Nested(),
        "how many more walk there to goals of their own, stand and talk; none unless given");
}

}  // namespace gaitcam
