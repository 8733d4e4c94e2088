/// Textures generated from a seed: floors, walls, posters and furniture with the image statistics of real ones.
///
/// Every texture shows something of a real size, so sizes are metres and resolution is pixels per metre. Floors, walls
/// and plain surfaces wrap around without a seam; pictures (posters, books) do not.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "algorithms/core/fields.h"

namespace gaitcam {

/// Names of the kinds of texture, sorted.
const std::vector<std::string>& TextureKinds();

/// Parameters of a texture. A zero stands for the default of its kind.
struct TextureOptions {
  using DescribedTag = void;

  std::string kind = "planks";
  Eigen::Vector2d size_m{0, 0};
  double px_per_m = 0;
  double unit_m = 0;
  double contrast = 1;
  Eigen::Vector3d rgb{-1, -1, -1};
  uint64_t seed = 0;
  std::string file;
};

template <class Visitor>
void VisitFields(Visitor& visit, TextureOptions& o) {
  visit("kind", o.kind, OneOf(TextureKinds()), "what it looks like");
  visit("size_m", o.size_m, Nested(),
        "width and height of one repeat, or of the whole picture; 0: as is usual for the kind");
  visit("px_per_m", o.px_per_m, Between(0, 20000), "resolution; 0: as is usual for the kind");
  visit("unit_m", o.unit_m, Between(0, 10),
        "width of a board, edge of a tile, largest chip or leaf, height of a letter; 0: as is usual for the kind");
  visit("contrast", o.contrast, Between(0, 3), "factor on the variation around the mean colour");
  visit("rgb", o.rgb, Nested(), "mean colour, display values 0..1; negative: as is usual for the kind");
  visit("seed", o.seed, AtLeast(0), "two textures of the same seed and options are the same");
  visit("file", o.file, AnyText(), "picture file, relative to the scene's folder, for the kind image");
}

/// The options with the defaults of their kind in place of zeros.
/// @throws BadOption naming field, value and range; also if the picture would have more than 64 million pixels.
TextureOptions CompleteTexture(TextureOptions options);

/// The file that a texture of the kind `image` shows; empty for the kinds that are generated.
std::filesystem::path PictureFile(const TextureOptions& options, const std::filesystem::path& folder);

/// Size of the picture that MakeTexture makes of completed options; of the kind `image`, as many pixels as the file
/// has.
/// @throws BadInput as MakeTexture does.
cv::Size TextureSize(const TextureOptions& options, const std::filesystem::path& folder = {});

/// Makes the picture of completed options: CV_8UC3, display (sRGB) values, row 0 on top, bit-identical for equal
/// options.
/// @throws BadInput for the kind `image` if the file is missing or is no picture.
cv::Mat MakeTexture(const TextureOptions& options, const std::filesystem::path& folder = {});

}  // namespace gaitcam
