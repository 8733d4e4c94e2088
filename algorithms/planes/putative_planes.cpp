#include "algorithms/planes/putative_planes.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

constexpr int kMinSide_px = 32;

void CheckOptions(const PutativePlaneOptions& o) {
  CheckFields(o, "putative_planes.");
  if (o.canny_low > o.canny_high) throw BadOption("putative_planes.canny_low must not exceed canny_high");
}

/// Grey and smoothed with sigma = 1 (thesis 6.3).
cv::Mat Smoothed(const cv::Mat& image) {
  if (image.type() != CV_8UC1 && image.type() != CV_8UC3) throw BadInput("putative planes need an 8-bit image");
  if (std::min(image.cols, image.rows) < kMinSide_px) {
    throw BadInput("putative planes need an image of at least " + std::to_string(kMinSide_px) + " px each way, not " +
                   std::to_string(image.cols) + " x " + std::to_string(image.rows));
  }
  cv::Mat grey = image, smooth;
  if (image.channels() == 3) cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.0);
  return smooth;
}

cv::Mat Square(int radius_px) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius_px + 1, 2 * radius_px + 1});
}

/// A connected region: its label in the image of labels, area and bounding box.
struct Region {
  int label = 0, area_px = 0;
  cv::Rect rectangle;
};

/// The connected regions of `free` (4-neighbours, which is flood fill) with at least that area, largest first.
std::vector<Region> LargestRegions(const cv::Mat& free, int min_area_px, int max_count, cv::Mat& labels) {
  cv::Mat stats, centroids;
  const int count = cv::connectedComponentsWithStats(free, labels, stats, centroids, 4, CV_32S);
  std::vector<Region> regions;
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    if (s[cv::CC_STAT_AREA] < min_area_px) continue;
    regions.push_back({i,
                       s[cv::CC_STAT_AREA],
                       {s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]}});
  }
  std::stable_sort(regions.begin(), regions.end(), [](const auto& a, const auto& b) { return a.area_px > b.area_px; });
  if (int(regions.size()) > max_count) regions.resize(size_t(max_count));
  return regions;
}

cv::Mat HolesFilled(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::drawContours(filled, contours, -1, cv::Scalar(255), cv::FILLED);
  return filled;
}

/// The band along a region's boundary. The image's own border is no boundary: beyond it, erosion sees the region and
/// dilation does not.
PutativePlane BoundaryOf(const cv::Mat& labels, const Region& region, int band_px) {
  // The edge itself, a line of one pixel, lies outside the region: of an odd thickness the outer part is the larger.
  const int inner_px = band_px / 2, outer_px = band_px - inner_px;
  const cv::Rect& r = region.rectangle;
  PutativePlane plane;
  plane.at = cv::Rect(r.x - outer_px, r.y - outer_px, r.width + 2 * outer_px, r.height + 2 * outer_px) &
             cv::Rect({0, 0}, labels.size());
  const cv::Mat inside = labels(plane.at) == region.label;
  cv::Mat grown, shrunk;
  cv::dilate(inside, grown, Square(outer_px));
  cv::erode(inside, shrunk, Square(inner_px));
  plane.pixels = grown & ~shrunk;
  plane.enclosed = HolesFilled(inside);
  plane.area_px = cv::countNonZero(plane.enclosed);
  return plane;
}

/// Thesis 6.3: Canny, dilation and erosion, flood fill, area, boundaries.
std::vector<PutativePlane> FindBoundaries(const cv::Mat& smooth, const PutativePlaneOptions& options) {
  cv::Mat edges, labels;
  cv::Canny(smooth, edges, options.canny_low, options.canny_high);
  if (options.closing_px > 0) cv::morphologyEx(edges, edges, cv::MORPH_CLOSE, Square(options.closing_px));
  const int min_area_px = int(options.min_area_ratio * double(smooth.total()));
  std::vector<PutativePlane> planes;
  for (const Region& region : LargestRegions(edges == 0, min_area_px, options.max_regions, labels)) {
    PutativePlane plane = BoundaryOf(labels, region, options.band_px);
    if (cv::countNonZero(plane.pixels) > 0) planes.push_back(std::move(plane));
  }
  return planes;
}

/// Pixels in whose neighbourhood enough pixels have a gradient.
cv::Mat DenseTexture(const cv::Mat& smooth, const PutativePlaneOptions& options) {
  cv::Mat du, dv, energy, density;
  cv::Sobel(smooth, du, CV_16S, 1, 0, 3);
  cv::Sobel(smooth, dv, CV_16S, 0, 1, 3);
  cv::Mat textured(smooth.size(), CV_8UC1);
  const double min_gradient = 8 * options.texture_gradient_grey;  // a ramp of 1 grey per pixel gives 8
  const int min_gradient2 = int(min_gradient * min_gradient);
  for (int v = 0; v < smooth.rows; ++v) {
    const short *a = du.ptr<short>(v), *b = dv.ptr<short>(v);
    uchar* out = textured.ptr<uchar>(v);
    for (int u = 0; u < smooth.cols; ++u) out[u] = int(a[u]) * a[u] + int(b[u]) * b[u] >= min_gradient2 ? 255 : 0;
  }
  const int side = options.texture_window_px | 1;
  cv::boxFilter(textured, density, CV_8U, {side, side});
  return density >= 255 * options.texture_density;
}

std::vector<PutativePlane> FindTextured(const cv::Mat& smooth, const PutativePlaneOptions& options) {
  cv::Mat dense = DenseTexture(smooth, options), labels;
  if (options.block_px > 0) {
    // Regions of a wall and of the floor in front of it often touch: blocks of them can be judged separately.
    for (int u = options.block_px; u < dense.cols; u += options.block_px) dense.col(u) = 0;
    for (int v = options.block_px; v < dense.rows; v += options.block_px) dense.row(v) = 0;
  }
  const int min_area_px = int(options.min_texture_ratio * double(smooth.total()));
  std::vector<PutativePlane> planes;
  for (const Region& region : LargestRegions(dense, min_area_px, options.max_regions, labels)) {
    PutativePlane plane;
    plane.kind = PutativePlane::Kind::kTexture;
    plane.at = region.rectangle;
    plane.pixels = labels(plane.at) == region.label;
    plane.enclosed = HolesFilled(plane.pixels);
    plane.area_px = cv::countNonZero(plane.enclosed);
    planes.push_back(std::move(plane));
  }
  return planes;
}

}  // namespace

std::vector<PutativePlane> FindPutativePlanes(const cv::Mat& image, const PutativePlaneOptions& options) {
  CheckOptions(options);
  const cv::Mat smooth = Smoothed(image);
  std::vector<PutativePlane> planes;
  if (options.selector != RegionSelector::kTexture) planes = FindBoundaries(smooth, options);
  if (options.selector != RegionSelector::kBoundary) {
    for (PutativePlane& plane : FindTextured(smooth, options)) planes.push_back(std::move(plane));
  }
  std::stable_sort(planes.begin(), planes.end(), [](const auto& a, const auto& b) { return a.area_px > b.area_px; });
  return planes;
}

cv::Mat UnionOfPixels(const std::vector<PutativePlane>& planes, cv::Size image_size) {
  cv::Mat all = cv::Mat::zeros(image_size, CV_8UC1);
  for (const PutativePlane& plane : planes) all(plane.at) |= plane.pixels;
  return all;
}

cv::Mat UnionOfEnclosed(const std::vector<PutativePlane>& planes, cv::Size image_size) {
  cv::Mat all = cv::Mat::zeros(image_size, CV_8UC1);
  for (const PutativePlane& plane : planes) all(plane.at) |= plane.enclosed;
  return all;
}

}  // namespace gaitcam
