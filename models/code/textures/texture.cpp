#include "models/code/textures/texture.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/file_content.h"
#include "algorithms/core/file_names.h"
#include "models/code/textures/floor_textures.h"
#include "models/code/textures/picture_textures.h"
#include "models/code/textures/room_textures.h"
#include "models/code/textures/street_textures.h"
#include "models/code/textures/texture_noise.h"

namespace gaitcam {
namespace {

using Maker = cv::Mat (*)(const TextureOptions&, cv::Size, RandomStream&);

/// Defaults and generator of a kind. Pixel counts are rounded up to multiples of `step`, so that octaves of noise are
/// periodic.
struct Kind {
  std::string name;
  Eigen::Vector2d size_m;
  double px_per_m;
  double unit_m;
  Eigen::Vector3d rgb;
  int step;
  Maker make;
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds = {
      {"books", {0.8, 0.3}, 500, 0.032, {0.5, 0.5, 0.5}, 16, MakeBooks},
      {"car_body", {1.7, 0.7}, 250, 0, {0.7, 0.71, 0.73}, 16, MakeCarBody},
      {"cardboard", {0.5, 0.4}, 500, 0.008, {0.66, 0.5, 0.34}, 16, MakeCardboard},
      {"carpet", {4, 4}, 512, 0.5, {0.4, 0.42, 0.46}, 128, MakeCarpet},
      {"ceiling", {3.6, 3.6}, 160, 0.6, {0.9, 0.9, 0.88}, 16, MakeCeiling},
      {"cloth", {0.64, 0.64}, 800, 0.16, {0.8, 0.8, 0.8}, 128, MakeCloth},
      {"concrete", {4, 4}, 400, 0.3, {0.6, 0.59, 0.57}, 128, MakeConcrete},
      {"dead_leaves", {0.6, 0.8}, 500, 0.3, {0.5, 0.5, 0.5}, 16, MakeDeadLeaves},
      {"door", {1.0, 2.1}, 300, 0, {0.62, 0.5, 0.36}, 16, MakeDoor},
      {"field", {7.4, 5.6}, 320, 0.05, {0.16, 0.42, 0.2}, 128, MakeField},
      {"house_front", {8, 6}, 90, 2.8, {0.68, 0.65, 0.6}, 16, MakeHouseFront},
      {"image", {1, 1}, 0, 0, {0.5, 0.5, 0.5}, 1, nullptr},
      {"notice_board", {1.2, 0.9}, 500, 0.01, {0.62, 0.46, 0.3}, 16, MakeNoticeBoard},
      {"paint", {4, 4}, 256, 0.02, {0.86, 0.85, 0.82}, 256, MakePaint},
      {"pink", {0.6, 0.8}, 500, 0, {0.5, 0.5, 0.5}, 16, MakePink},
      {"planks", {4, 4}, 512, 0.115, {0.62, 0.47, 0.33}, 256, MakePlanks},
      {"poster", {0.6, 0.8}, 500, 0, {0.5, 0.5, 0.5}, 16, MakePoster},
      {"terrazzo", {2.4, 2.4}, 640, 0.02, {0.72, 0.7, 0.66}, 64, MakeTerrazzo},
      {"tiles", {3.6, 3.6}, 512, 0.3, {0.7, 0.67, 0.62}, 128, MakeTiles},
      {"wood", {1.2, 1.2}, 400, 0.045, {0.66, 0.5, 0.34}, 256, MakeWood},
  };
  return kinds;
}

const Kind& FindKind(const std::string& name) {
  for (const Kind& kind : Kinds()) {
    if (kind.name == name) return kind;
  }
  GAITCAM_ASSERT(!"an unchecked kind of texture");
  throw std::logic_error("unreachable");
}

void CheckVector(const std::string& field, const Eigen::Vector2d& value) {
  if (value.allFinite() && value.minCoeff() > 0) return;
  throw BadOption(field + ": [" + internal::NumberText(value.x()) + ", " + internal::NumberText(value.y()) +
                  "] is not permitted; expected two lengths above 0");
}

cv::Size PixelSize(const TextureOptions& o, int step) {
  const auto pixels = [&](double length) { return RoundUp(std::max(1, int(std::lround(length * o.px_per_m))), step); };
  return {pixels(o.size_m.x()), pixels(o.size_m.y())};
}

cv::Mat ReadImageFile(const TextureOptions& o, const std::filesystem::path& folder) {
  if (o.file.empty()) throw BadInput("file: missing; a texture of kind image needs the name of a picture file");
  const std::filesystem::path path = PictureFile(o, folder);
  if (!IsFile(path)) throw BadInput("file: " + path.string() + ": no such picture file");
  const std::string bytes = FileContent(path);
  cv::Mat image;
  if (!bytes.empty()) image = cv::imdecode(cv::_InputArray(bytes.data(), int(bytes.size())), cv::IMREAD_COLOR);
  if (image.empty()) throw BadInput("file: " + path.string() + ": not a picture that can be read (PNG, JPEG, ...)");
  return image;
}

}  // namespace

const std::vector<std::string>& TextureKinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Kind& kind : Kinds()) list.push_back(kind.name);
    return list;
  }();
  return names;
}

TextureOptions CompleteTexture(TextureOptions o) {
  CheckFields(o);
  const Kind& kind = FindKind(o.kind);
  if (o.size_m.isZero()) o.size_m = kind.size_m;
  CheckVector("size_m", o.size_m);
  if (o.px_per_m == 0) o.px_per_m = kind.px_per_m;
  if (o.unit_m == 0) o.unit_m = kind.unit_m;
  if (o.rgb.minCoeff() < 0) o.rgb = kind.rgb;
  if (!(o.rgb.maxCoeff() <= 1)) throw BadOption("rgb: expected three numbers from 0 to 1");
  constexpr double kMaxPixels = 64e6;
  const double pixels = (o.size_m * o.px_per_m).prod();
  if (pixels > kMaxPixels) {
    throw BadOption("px_per_m: " + internal::NumberText(o.px_per_m) + " gives " + internal::NumberText(pixels / 1e6) +
                    " million pixels; expected at most 64 million");
  }
  return o;
}

std::filesystem::path PictureFile(const TextureOptions& o, const std::filesystem::path& folder) {
  return FindKind(o.kind).make ? std::filesystem::path() : folder / o.file;  // an absolute file stays what it is
}

cv::Size TextureSize(const TextureOptions& o, const std::filesystem::path& folder) {
  const Kind& kind = FindKind(o.kind);
  return kind.make ? PixelSize(o, kind.step) : ReadImageFile(o, folder).size();
}

cv::Mat MakeTexture(const TextureOptions& o, const std::filesystem::path& folder) {
  const Kind& kind = FindKind(o.kind);
  if (!kind.make) return ReadImageFile(o, folder);
  RandomStream random(o.seed, "texture." + o.kind);
  return kind.make(o, PixelSize(o, kind.step), random);
}

}  // namespace gaitcam
