#include "results/reports/html_page.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "results/reports/page_file.h"

namespace gaitcam::internal {
namespace {

std::string Base64(const std::vector<uchar>& bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // EVP_EncodeBlock ends with a null byte
  const int length = EVP_EncodeBlock(reinterpret_cast<uchar*>(text.data()), bytes.data(), int(bytes.size()));
  text.resize(size_t(length));
  return text;
}

/// JSON inside a script element must not hold the text that would close it.
std::string ScriptSafe(std::string json) {
  for (size_t at = json.find("</"); at != std::string::npos; at = json.find("</", at + 3)) json.insert(at + 1, "\\");
  return json;
}

}  // namespace

std::string JpegUri(const cv::Mat& picture, int max_width_px) {
  cv::Mat shown = picture;
  if (picture.cols > max_width_px) {
    cv::resize(picture, shown, {max_width_px, int(std::lround(double(picture.rows) * max_width_px / picture.cols))}, 0,
               0, cv::INTER_AREA);
  }
  std::vector<uchar> bytes;
  cv::imencode(".jpg", shown, bytes, {cv::IMWRITE_JPEG_QUALITY, 88});
  return "data:image/jpeg;base64," + Base64(bytes);
}

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

std::string ReadChartLibrary(const std::filesystem::path& wanted) {
  std::vector<std::filesystem::path> places = {wanted};
  if (wanted.empty()) {
    places = {"/usr/share/javascript/chart.js/chart.min.js", "/usr/share/nodejs/chart.js/dist/chart.min.js"};
  }
  for (const std::filesystem::path& place : places) {
    try {
      return FileContent(place);
    } catch (const BadInput&) {  // the next place, then
    }
  }
  throw MissingResource("the report needs Chart.js at " + places.front().string() +
                        "; install the Debian package libjs-chart.js");
}

std::string Banner(const std::string& kind, const std::string& head, const std::string& text) {
  return fmt::format("<div class=\"banner {}\" role=\"alert\"><b>{}</b>{}</div>\n", kind, Escape(head), Escape(text));
}

std::string ThreeDigits(double value) {
  if (value == std::floor(value) || std::abs(value) >= 100) return fmt::format("{:.0f}", value);
  return fmt::format("{:#.3g}", value);
}

std::string Card(const std::string& name, double value, const std::string& unit, const std::string& hint) {
  return fmt::format("<div><dt>{}</dt><dd class=\"value\">{}<small>{}</small></dd><dd class=\"hint\">{}</dd></div>\n",
                     Escape(name), std::isfinite(value) ? ThreeDigits(value) : "&ndash;",
                     std::isfinite(value) ? Escape(unit) : "", Escape(hint));
}

std::string Key(const std::vector<KeyEntry>& entries, const std::string& charts) {
  std::string html = fmt::format("<ul class=\"key\" data-for=\"{}\">", charts);
  for (const KeyEntry& e : entries) {
    const std::string text =
        e.series.empty() ? Escape(e.text)
                         : fmt::format("<button type=\"button\" data-series=\"{}\" title=\"hide or show\">{}</button>",
                                       Escape(e.series), Escape(e.text));
    html += fmt::format("<li class=\"{}\" style=\"--c: var(--{})\">{}</li>", e.kind, e.colour, text);
  }
  return html + "</ul>\n";
}

std::string Panel(const std::string& chart, const std::string& title, const std::vector<KeyEntry>& key, int height_px) {
  return fmt::format(
      "<section class=\"panel\"><h3>{}</h3>\n{}<div class=\"chart\" style=\"height: {}px\"><canvas data-chart=\"{}\" "
      "role=\"img\" aria-label=\"{}\"></canvas></div></section>\n",
      Escape(title), key.empty() ? "" : Key(key, chart), height_px, chart, Escape(title));
}

std::string Facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  std::string html = "<section class=\"panel\"><dl class=\"facts\">\n";
  for (const auto& [name, value] : facts) html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", Escape(name), Escape(value));
  return html + "</dl></section>\n";
}

std::string PageHtml(const HtmlPage& page, const std::filesystem::path& chart_library) {
  const std::string library = ReadChartLibrary(chart_library);
  std::string html = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  html += "<link rel=\"icon\" href=\"data:,\">\n";
  html += "<title>" + Escape(page.title) + " - gaitcam</title>\n<style>" + std::string(PageFile("page.css")) +
          std::string(page.style) + "</style>\n";
  html += "</head>\n<body>\n<main>\n" + page.body;
  html += "<footer>Written by gaitcam. Charts by Chart.js (MIT licence), inlined.</footer>\n</main>\n";
  html += "<script type=\"application/json\" id=\"data\">" + ScriptSafe(page.data) + "</script>\n";
  html += "<script>" + library + "</script>\n<script>" + std::string(PageFile("page.js")) + std::string(page.script) +
          "</script>\n";
  return html + "</body>\n</html>\n";
}

}  // namespace gaitcam::internal
