#include "scenarios/code/runs/place_cache.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/checksum.h"
#include "scenarios/code/files/versions.h"
#include "scenarios/code/runs/cache_entry.h"
#include "scenarios/code/runs/file_lock.h"
#include "scenarios/code/runs/output_folder.h"
#include "scenarios/code/runs/renderer_record.h"
#include "sim/camera/egl_context.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string PanoramaName(size_t i) { return fmt::format("panorama_{:04}.png", i); }
std::string ImageName(size_t i) { return fmt::format("image_{:05}.png", i); }
std::string ViewName(size_t i) { return fmt::format("view_{:05}.png", i); }

Json JsonOf(const PlaceReference& r) {
  return {r.position_m.x(), r.position_m.y(), r.heading_rad, r.frames, r.seam_error_px};
}

PlaceReference ReferenceOf(const Json& j) {
  PlaceReference r;
  r.position_m = {j.at(0).get<double>(), j.at(1).get<double>()};
  r.heading_rad = j.at(2);
  r.frames = j.at(3);
  r.seam_error_px = j.at(4);
  return r;
}

Json JsonOf(const PlaceQuery& q) {
  return {q.condition, q.position_m.x(), q.position_m.y(), q.heading_rad, q.covered_ratio, q.blur_px};
}

PlaceQuery QueryOf(const Json& j) {
  PlaceQuery q;
  q.condition = j.at(0);
  q.position_m = {j.at(1).get<double>(), j.at(2).get<double>()};
  q.heading_rad = j.at(3);
  q.covered_ratio = j.at(4);
  q.blur_px = j.at(5);
  return q;
}

void WriteImage(const fs::path& file, const cv::Mat& image) {
  if (!cv::imwrite(file.string(), image)) throw MissingResource("cannot write " + file.string());
}

cv::Mat ReadImage(const fs::path& file) {
  cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  if (image.empty()) throw BadInput(file.string() + ": damaged; remove this folder");
  return image;
}

void WriteAll(const PlaceViews& views, const OutputFolder& folder) {
  Json about;
  about["layout"] = {views.layout.width_px, views.layout.height_px, views.layout.tan_low, views.layout.tan_high};
  about["view_width_px"] = views.view_width_px;
  WriteRenderer(views.renderer, about);
  about["references"] = about["queries"] = Json::array();
  for (size_t i = 0; i < views.references.size(); ++i) {
    about["references"].push_back(JsonOf(views.references[i]));
    WriteImage(folder.path() / PanoramaName(i), views.references[i].panorama);
  }
  for (size_t i = 0; i < views.queries.size(); ++i) {
    about["queries"].push_back(JsonOf(views.queries[i]));
    WriteImage(folder.path() / ImageName(i), views.queries[i].image);
    WriteImage(folder.path() / ViewName(i), views.queries[i].view);
  }
  NoteCacheEntrySize(folder);
  folder.WriteText(kCacheEntryAbout, about.dump());
}

}  // namespace

PlaceCache::PlaceCache(const fs::path& folder, const ResolvedScenario& resolved) {
  if (folder.empty()) return;
  const std::string renderer = RendererKey(resolved.scenario.camera.renderer);
  const std::string key = Sha256(FramesHashOf(resolved) + ProgramFingerprint() + renderer).substr(0, 32);
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) entry_ = fs::absolute(folder) / ("places-" + key);
}

std::optional<PlaceViews> PlaceCache::Read() const {
  if (entry_.empty() || !fs::exists(entry_ / kCacheEntryAbout)) return std::nullopt;
  const FileLock lock(CacheEntryLock(entry_), FileLock::Kind::kShared);
  const std::optional<std::string> text = FindFileContent(entry_ / kCacheEntryAbout);
  if (!text) return std::nullopt;  // removed meanwhile
  const Json about = Json::parse(*text, nullptr, false);
  if (about.is_discarded()) throw BadInput((entry_ / kCacheEntryAbout).string() + ": damaged; remove this folder");
  fs::last_write_time(entry_ / kCacheEntryAbout, fs::file_time_type::clock::now());  // used just now
  PlaceViews views;
  views.layout = {about["layout"][0], about["layout"][1], about["layout"][2], about["layout"][3]};
  views.view_width_px = about["view_width_px"];
  views.renderer = ReadRenderer(about);
  for (const Json& json : about["references"]) {
    views.references.push_back(ReferenceOf(json));
    views.references.back().panorama = ReadImage(entry_ / PanoramaName(views.references.size() - 1));
  }
  for (const Json& json : about["queries"]) {
    views.queries.push_back(QueryOf(json));
    views.queries.back().image = ReadImage(entry_ / ImageName(views.queries.size() - 1));
    views.queries.back().view = ReadImage(entry_ / ViewName(views.queries.size() - 1));
  }
  return views;
}

void PlaceCache::Write(const PlaceViews& views) const {
  if (entry_.empty()) return;
  try {
    const FileLock lock(CacheEntryLock(entry_), FileLock::Kind::kExclusive);
    RemoveUnfinished(entry_);
    OutputFolder folder(entry_, kCacheEntryAbout);
    WriteAll(views, folder);
    folder.Commit();
  } catch (const MissingResource&) {  // a full disk: the next run renders again
  }
}

}  // namespace gaitcam
