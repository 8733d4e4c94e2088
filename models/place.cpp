#include "models/place.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "models/place_builder.h"
#include "models/place_file.h"

namespace gaitcam {
namespace {

std::filesystem::path FindPlaceFile(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const std::filesystem::path path(name_or_path);
  if (path.has_parent_path() || path.extension() == ".yaml" || path.extension() == ".yml") return path;
  const std::filesystem::path shipped = models_folder / "places" / (name_or_path + ".yaml");
  if (std::filesystem::is_regular_file(shipped)) return shipped;
  const std::vector<std::string> places = ListPlaces(models_folder);
  const std::string near = NearestWord(name_or_path, places);
  std::string all;
  for (const std::string& place : places) all += (all.empty() ? "" : ", ") + place;
  throw BadInput(
      "place \"" + name_or_path + "\": no such place; " +
      (near.empty() ? "shipped are " + all + "; or give the path of a YAML file" : "did you mean " + near + "?"));
}

}  // namespace

Place ReadPlace(const std::string& name_or_path, const std::filesystem::path& models_folder) {
  const YamlNode root = YamlNode::LoadFile(FindPlaceFile(name_or_path, models_folder));
  PlaceFile file;
  ReadYaml(root, file);
  return BuildPlace(file, root);
}

std::vector<std::string> ListPlaces(const std::filesystem::path& models_folder) {
  std::vector<std::string> names;
  std::error_code missing;  // no folder: no places
  for (const auto& entry : std::filesystem::directory_iterator(models_folder / "places", missing)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

cv::Mat FloorImage(const Place& place, double pixels_per_m) {
  if (!(pixels_per_m > 0)) throw BadOption("pixels_per_m: expected a number above 0");
  GAITCAM_ASSERT(place.floor_texture >= 0 && size_t(place.floor_texture) < place.textures.size());
  cv::Mat repeat = place.textures[place.floor_texture].bgr;
  const Eigen::Vector2d wanted = place.floor_texture_size_m * pixels_per_m;
  if (wanted.x() < repeat.cols || wanted.y() < repeat.rows) {  // coarser than the texture: average, don't skip
    const cv::Size size(std::max(1, int(std::lround(std::min(wanted.x(), double(repeat.cols))))),
                        std::max(1, int(std::lround(std::min(wanted.y(), double(repeat.rows))))));
    cv::resize(repeat, repeat, size, 0, 0, cv::INTER_AREA);
  }
  const Eigen::Vector2d extent = place.floor_max - place.floor_min;
  const cv::Size size(int(std::lround(extent.x() * pixels_per_m)), int(std::lround(extent.y() * pixels_per_m)));
  const double scale_x = repeat.cols / wanted.x(), scale_y = repeat.rows / wanted.y();
  // Coordinates are taken into the first repeat before interpolation: remap's own have too few bits for many repeats.
  // Row by row, as maps of the whole floor would take several times its memory.
  cv::Mat map_x(1, size.width, CV_32FC1), map_y(1, size.width, CV_32FC1), image(size, CV_8UC3);
  for (int x = 0; x < size.width; ++x) {
    const double right = (x + 0.5) * scale_x;
    map_x.at<float>(0, x) = float(right - repeat.cols * std::floor(right / repeat.cols) - 0.5);
  }
  for (int y = 0; y < size.height; ++y) {
    const double up = (extent.y() * pixels_per_m - y - 0.5) * scale_y;  // texels above the repeat's lower edge
    map_y.setTo(repeat.rows - (up - repeat.rows * std::floor(up / repeat.rows)) - 0.5);
    cv::remap(repeat, image.row(y), map_x, map_y, cv::INTER_LINEAR, cv::BORDER_WRAP);
  }
  return image;
}

}  // namespace gaitcam
