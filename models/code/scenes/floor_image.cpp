#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "algorithms/core/errors.h"
#include "models/code/scenes/scene.h"

namespace gaitcam {
namespace {

/// Boxes with an upper face no higher than this belong to the floor's image: prints, lines, tape.
constexpr double kFlat_m = 0.005;

/// `texture` shrunk so that its pixels are no smaller than the picture's: averaged, not skipped.
cv::Mat Coarsened(const cv::Mat& texture, const Eigen::Vector2d& size_px) {
  if (size_px.x() >= texture.cols && size_px.y() >= texture.rows) return texture;
  const auto side = [](double wanted, int there) {
    return std::max(1, int(std::lround(std::min(wanted, double(there)))));
  };
  cv::Mat coarse;
  cv::resize(texture, coarse, {side(size_px.x(), texture.cols), side(size_px.y(), texture.rows)}, 0, 0, cv::INTER_AREA);
  return coarse;
}

/// A pixel coordinate of a repeating texture, taken into its first repeat.
double Wrapped(double u, int size) { return u - size * std::floor(u / size); }

cv::Mat BareFloor(const Scene& scene, double pixels_per_m) {
  GAITCAM_ASSERT(scene.floor_texture >= 0 && size_t(scene.floor_texture) < scene.textures.size());
  const Eigen::Vector2d wanted = scene.floor_texture_size_m * pixels_per_m;
  const cv::Mat repeat = Coarsened(scene.textures[scene.floor_texture].Bgr(), wanted);
  const Eigen::Vector2d extent = scene.floor_max - scene.floor_min;
  const cv::Size size(int(std::lround(extent.x() * pixels_per_m)), int(std::lround(extent.y() * pixels_per_m)));
  const double scale_x = repeat.cols / wanted.x(), scale_y = repeat.rows / wanted.y();
  // Coordinates are wrapped into the first repeat before interpolation: cv::remap's fixed-point coordinates have too
  // few bits for many repeats. Row by row: maps of the whole floor would take several times the memory of its image.
  cv::Mat map_x(1, size.width, CV_32FC1), map_y(1, size.width, CV_32FC1), image(size, CV_8UC3);
  for (int x = 0; x < size.width; ++x) {
    map_x.at<float>(0, x) = float(Wrapped((x + 0.5) * scale_x, repeat.cols) - 0.5);
  }
  for (int y = 0; y < size.height; ++y) {
    const double up = (extent.y() * pixels_per_m - y - 0.5) * scale_y;  // texels above the repeat's lower edge
    map_y.setTo(repeat.rows - Wrapped(up, repeat.rows) - 0.5);
    cv::remap(repeat, image.row(y), map_x, map_y, cv::INTER_LINEAR, cv::BORDER_WRAP);
  }
  return image;
}

/// The upper face of a box that lies flat, as SceneBox describes its pictures.
struct LyingFace {
  Eigen::Vector2d middle, right, up;  ///< In the world; unit vectors along the picture's right and up.
  Eigen::Vector2d size_m;             ///< Along them.
  double top_m = 0;

  /// Bounding box of the four corners.
  Eigen::Vector2d Reach() const { return (right.cwiseAbs() * size_m.x() + up.cwiseAbs() * size_m.y()) / 2; }
};

std::optional<LyingFace> LyingFaceOf(const SceneBox& box) {
  const Eigen::Matrix3d R = box.X_WB.rotation.toRotationMatrix();
  int axis = 0;
  R.row(2).cwiseAbs().maxCoeff(&axis);
  LyingFace face;
  face.top_m = box.X_WB.translation.z() + box.size[axis] / 2;
  const bool level = std::abs(R(2, axis)) > 1 - 1e-9;
  if (!level || face.top_m <= 0 || face.top_m > kFlat_m) return std::nullopt;
  const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis) * (R(2, axis) > 0 ? 1 : -1);
  const Eigen::Vector3d up = Eigen::Vector3d::Unit(axis == 2 ? 1 : 2), right = up.cross(normal);
  face.middle = box.X_WB.translation.head<2>();
  face.right = (R * right).head<2>();
  face.up = (R * up).head<2>();
  face.size_m = {std::abs(right.dot(box.size)), std::abs(up.dot(box.size))};
  return face;
}

/// A face's picture at the pixels `area` of the floor's image, and how much of each pixel it covers.
struct DrawnFace {
  cv::Mat bgr;    ///< CV_8UC3
  cv::Mat cover;  ///< CV_32FC1, 0..1
};

DrawnFace Draw(const Scene& scene, const SceneBox& box, const LyingFace& face, const cv::Rect& area,
               double pixels_per_m) {
  const Eigen::Vector2d repeat_m = box.texture_size_m.isZero() ? face.size_m : box.texture_size_m;
  cv::Mat picture(1, 1, CV_8UC3, cv::Scalar(box.rgb.z() * 255, box.rgb.y() * 255, box.rgb.x() * 255));
  if (box.texture >= 0) picture = Coarsened(scene.textures[size_t(box.texture)].Bgr(), repeat_m * pixels_per_m);
  DrawnFace drawn{{}, cv::Mat(area.size(), CV_32FC1)};
  cv::Mat map_x(area.size(), CV_32FC1), map_y(area.size(), CV_32FC1);
  for (int v = 0; v < area.height; ++v) {
    for (int u = 0; u < area.width; ++u) {
      const Eigen::Vector2d p(scene.floor_min.x() + (area.x + u + 0.5) / pixels_per_m,
                              scene.floor_max.y() - (area.y + v + 0.5) / pixels_per_m);
      const Eigen::Vector2d from_middle = p - face.middle;
      const Eigen::Vector2d at(face.right.dot(from_middle), face.up.dot(from_middle));
      const Eigen::Vector2d inside = (face.size_m / 2 - at.cwiseAbs()) * pixels_per_m;
      drawn.cover.at<float>(v, u) =
          float(std::clamp(inside.x() + 0.5, 0.0, 1.0) * std::clamp(inside.y() + 0.5, 0.0, 1.0));
      const Eigen::Vector2d corner = (at + face.size_m / 2).cwiseMax(1e-9).cwiseMin(face.size_m * (1 - 1e-9));
      const Eigen::Vector2d texel = corner.cwiseQuotient(repeat_m);  // in repeats, from the lower left corner
      map_x.at<float>(v, u) = float(Wrapped(texel.x() * picture.cols, picture.cols) - 0.5);
      map_y.at<float>(v, u) = float(picture.rows - Wrapped(texel.y() * picture.rows, picture.rows) - 0.5);
    }
  }
  const int border = box.texture_size_m.isZero() ? cv::BORDER_REPLICATE : cv::BORDER_WRAP;
  cv::remap(picture, drawn.bgr, map_x, map_y, cv::INTER_LINEAR, border);
  return drawn;
}

void Blend(const DrawnFace& face, cv::Mat floor) {
  for (int v = 0; v < floor.rows; ++v) {
    for (int u = 0; u < floor.cols; ++u) {
      const float a = face.cover.at<float>(v, u);
      cv::Vec3b& pixel = floor.at<cv::Vec3b>(v, u);
      const cv::Vec3b& over = face.bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<uchar>((1 - a) * float(pixel[c]) + a * float(over[c]));
    }
  }
}

}  // namespace

cv::Mat FloorImage(const Scene& scene, double pixels_per_m) {
  if (!(pixels_per_m > 0)) throw BadOption("pixels_per_m: expected a number above 0");
  cv::Mat image = BareFloor(scene, pixels_per_m);
  std::vector<std::pair<const SceneBox*, LyingFace>> lying;
  for (const SceneBox& box : scene.boxes) {
    if (const std::optional<LyingFace> face = LyingFaceOf(box)) lying.emplace_back(&box, *face);
  }
  std::stable_sort(lying.begin(), lying.end(),
                   [](const auto& a, const auto& b) { return a.second.top_m < b.second.top_m; });
  for (const auto& [box, face] : lying) {
    const Eigen::Vector2d low = (face.middle - face.Reach() - scene.floor_min) * pixels_per_m;
    const Eigen::Vector2d high = (face.middle + face.Reach() - scene.floor_min) * pixels_per_m;
    const double height = (scene.floor_max - scene.floor_min).y() * pixels_per_m;
    const cv::Rect whole({int(std::floor(low.x())) - 1, int(std::floor(height - high.y())) - 1},
                         cv::Point(int(std::ceil(high.x())) + 1, int(std::ceil(height - low.y())) + 1));
    const cv::Rect area = whole & cv::Rect({0, 0}, image.size());
    if (!area.empty()) Blend(Draw(scene, *box, face, area, pixels_per_m), image(area));
  }
  return image;
}

}  // namespace gaitcam
