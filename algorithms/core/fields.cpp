#include "algorithms/core/fields.h"

#include <algorithm>
#include <charconv>

namespace gaitcam {

std::string Interval::ToText() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (!has_low && !has_high) return "a finite number";
  if (!has_high) return (low_open ? "a number greater than " : "a number of at least ") + internal::NumberText(low);
  if (!has_low) return "a number of at most " + internal::NumberText(high);
  return (low_open ? "a number greater than " : "a number from ") + internal::NumberText(low) +
         (low_open ? " and at most " : " to ") + internal::NumberText(high);
}

bool Words::Contains(const std::string& value) const {
  return words.empty() || std::find(words.begin(), words.end(), value) != words.end();
}

std::string Words::ToText() const {
  if (words.empty()) return "a text";
  return "one of " + JoinWords(words);
}

std::string Words::Refusal(const std::string& value) const {
  const std::string suggestion = DidYouMean(value, words, "");
  return '"' + value + "\" is not permitted; expected " + ToText() +
         (suggestion.empty() ? "" : " (" + suggestion + ")");
}

namespace internal {

void ThrowOutOfRange(const std::string& field, const std::string& value, const std::string& permitted) {
  throw BadOption(field + ": " + value + " is not permitted; expected " + permitted);
}

std::string NumberText(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return {buffer, end};
}

}  // namespace internal

std::string_view UnitOfKey(std::string_view key) {
  struct Suffix {
    std::string_view ending, unit;
  };
  static constexpr Suffix kSuffixes[] = {
      // longer endings first
      {"_deg_per_m", "deg/m"}, {"_pct_per_m", "%/m"}, {"_m2", "m²"},
      {"_px_per_m", "px/m"},   {"_rad_s2", "rad/s²"}, {"_rad_s", "rad/s"},
      {"_deg_s", "deg/s"},     {"_m_s2", "m/s²"},     {"_m_s", "m/s"},
      {"_deg", "deg"},         {"_rad", "rad"},       {"_pct", "%"},
      {"_hz", "Hz"},           {"_kg", "kg"},         {"_nm", "N m"},
      {"_px", "px"},           {"_ms", "ms"},         {"_ns", "ns"},
      {"_mm", "mm"},           {"_m", "m"},           {"_s", "s"},
      {"_e", "electrons"},
  };
  for (const Suffix& suffix : kSuffixes) {
    if (key.ends_with(suffix.ending) || key == suffix.ending.substr(1)) return suffix.unit;
  }
  return {};
}

}  // namespace gaitcam
