#include "algorithms/io/occupancy_grid_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/image_file.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;

constexpr uchar kUnknown = 128;
constexpr double kNearest = 1.0 / 510;  ///< To 0 and 1: half a grey level.

uchar GreyOf(float log_odds) {
  if (log_odds == 0) return kUnknown;
  return uchar(std::lround(255 * (1 - OccupancyGrid::Probability(double(log_odds)))));
}

float LogOddsOf(uchar grey, bool negate) {
  if (grey == kUnknown) return 0;
  const double free = grey / 255.0, p = std::clamp(negate ? free : 1 - free, kNearest, 1 - kNearest);
  return float(std::log(p / (1 - p)));
}

[[noreturn]] void Fail(const fs::path& file, const YAML::Node& node, const std::string& message) {
  const int line = node.IsDefined() && !node.Mark().is_null() ? node.Mark().line : 0;
  throw BadInput(file.string() + ":" + std::to_string(line + 1) + ": " + message);
}

template <class T>
T Required(const fs::path& file, const YAML::Node& root, const std::string& key, const std::string& expected) {
  const YAML::Node node = root[key];
  if (!node.IsDefined()) Fail(file, root, "the key " + key + " is missing; expected " + expected);
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    Fail(file, node, key + ": expected " + expected);
  }
}

YAML::Node Load(const fs::path& file) {
  YAML::Node root;
  try {
    root = YAML::Load(FileContent(file));
  } catch (const YAML::ParserException& e) {
    throw BadInput(file.string() + ":" + std::to_string(e.mark.line + 1) + ": not valid YAML: " + e.msg);
  }
  if (!root.IsMap()) Fail(file, root, "expected a map of keys and values");
  return root;
}

}  // namespace

void WriteOccupancyGrid(const fs::path& yaml, const OccupancyGrid& grid) {
  GAITCAM_ASSERT(grid.log_odds.type() == CV_32FC1 && !grid.empty() && grid.cell_m > 0);
  cv::Mat image(grid.log_odds.size(), CV_8UC1);
  for (int row = 0; row < image.rows; ++row) {
    for (int col = 0; col < image.cols; ++col) image.at<uchar>(row, col) = GreyOf(grid.log_odds.at<float>(row, col));
  }
  const fs::path picture = fs::path(yaml).replace_extension(".png");
  WritePng(picture, image, 1);
  const double left = grid.corner_m.x() - 0.5 * grid.cell_m;
  const double bottom = grid.corner_m.y() - (image.rows - 0.5) * grid.cell_m;
  WriteWholeFile(yaml, "image: " + picture.filename().string() + "\nresolution: " + ExactText(grid.cell_m) +
                           "\norigin: [" + ExactText(left) + ", " + ExactText(bottom) +
                           ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

OccupancyGrid ReadOccupancyGrid(const fs::path& yaml) {
  const YAML::Node root = Load(yaml);
  OccupancyGrid grid;
  const fs::path name = Required<std::string>(yaml, root, "image", "the name of an image file");
  grid.cell_m = Required<double>(yaml, root, "resolution", "the side of a cell in m");
  if (!(grid.cell_m > 0)) Fail(yaml, root["resolution"], "resolution: expected a side above 0 m");
  const std::string expected = "[x, y, yaw] of the lower left corner";
  const auto origin = Required<std::vector<double>>(yaml, root, "origin", expected);
  if (origin.size() != 3) Fail(yaml, root["origin"], "origin: expected " + expected);
  if (origin[2] != 0) Fail(yaml, root["origin"], "origin: expected yaw 0; turned grids are not supported");
  const bool negate = Required<int>(yaml, root, "negate", "0 or 1") != 0;
  const cv::Mat image = ReadImage(name.is_absolute() ? name : yaml.parent_path() / name, yaml.string());
  if (image.type() != CV_8UC1) Fail(yaml, root["image"], "image: expected a grey image of 8 bits");
  grid.log_odds.create(image.size(), CV_32FC1);
  for (int row = 0; row < image.rows; ++row) {
    for (int col = 0; col < image.cols; ++col) {
      grid.log_odds.at<float>(row, col) = LogOddsOf(image.at<uchar>(row, col), negate);
    }
  }
  grid.corner_m = {origin[0] + 0.5 * grid.cell_m, origin[1] + (image.rows - 0.5) * grid.cell_m};
  return grid;
}

}  // namespace gaitcam
