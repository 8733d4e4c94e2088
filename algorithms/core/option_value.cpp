#include "algorithms/core/option_value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"

namespace gaitcam {
namespace {

std::optional<double> NumberOfText(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  if (text == ".inf" || text == ".Inf" || text == ".INF") {
    value = std::numeric_limits<double>::infinity();
  } else if (text == ".nan" || text == ".NaN" || text == ".NAN") {
    value = std::numeric_limits<double>::quiet_NaN();
  } else {
    if (text.empty() || !(text[0] == '.' || (text[0] >= '0' && text[0] <= '9'))) return std::nullopt;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  }
  return negative ? -value : value;
}

template <class Whole>
std::optional<Whole> WholeOfText(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x");
  const std::string_view digits = text.substr(hexadecimal ? 2 : text.starts_with('+') ? 1 : 0);
  Whole value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, hexadecimal ? 16 : 10);
  if (error == std::errc() && end == digits.data() + digits.size()) return value;
  const std::optional<double> number = NumberOfText(text);  // "1e3", "300.0"
  if (!number || *number != std::floor(*number)) return std::nullopt;
  if (*number < double(std::numeric_limits<Whole>::min())) return std::nullopt;
  if (*number >= std::ldexp(1.0, std::numeric_limits<Whole>::digits)) return std::nullopt;
  return Whole(*number);
}

}  // namespace

OptionValue::OptionValue(std::string text, OptionOrigin origin)
    : kind_(Kind::kScalar), text_(std::move(text)), origin_(std::move(origin)) {}

OptionValue OptionValue::Nothing(OptionOrigin origin) {
  OptionValue value;
  value.origin_ = std::move(origin);
  return value;
}

OptionValue OptionValue::List(std::vector<OptionValue> elements, OptionOrigin origin) {
  OptionValue value = Nothing(std::move(origin));
  value.kind_ = Kind::kList;
  value.elements_ = std::make_shared<const std::vector<OptionValue>>(std::move(elements));
  return value;
}

OptionValue OptionValue::Map(std::vector<Entry> entries, OptionOrigin origin) {
  OptionValue value = Nothing(std::move(origin));
  value.kind_ = Kind::kMap;
  value.entries_ = std::make_shared<const std::vector<Entry>>(std::move(entries));
  return value;
}

std::string OptionValue::TextOfDouble(double number) {
  if (std::isnan(number)) return ".nan";
  if (std::isinf(number)) return number > 0 ? ".inf" : "-.inf";
  return internal::NumberText(number);
}

OptionValue OptionValue::WithPath(std::string path) const {
  OptionValue copy = *this;
  copy.path_ = std::move(path);
  return copy;
}

OptionValue OptionValue::WithOrigin(OptionOrigin origin) const {
  OptionValue copy = *this;
  copy.origin_ = std::move(origin);
  return copy;
}

std::optional<double> OptionValue::AsNumber() const { return IsScalar() ? NumberOfText(text_) : std::nullopt; }
std::optional<int> OptionValue::AsInt() const { return IsScalar() ? WholeOfText<int>(text_) : std::nullopt; }
std::optional<uint64_t> OptionValue::AsUnsigned() const {
  return IsScalar() ? WholeOfText<uint64_t>(text_) : std::nullopt;
}

std::optional<bool> OptionValue::AsFlag() const {
  std::string lower = text_;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  for (const char* word : {"true", "yes", "on", "y", "1"}) {
    if (IsScalar() && lower == word) return true;
  }
  for (const char* word : {"false", "no", "off", "n", "0"}) {
    if (IsScalar() && lower == word) return false;
  }
  return std::nullopt;
}

std::string OptionValue::Shown() const {
  return AsNumber() || text_ == "true" || text_ == "false" ? text_ : '"' + text_ + '"';
}

size_t OptionValue::size() const { return elements_ ? elements_->size() : 0; }

OptionValue OptionValue::Element(size_t index) const {
  GAITCAM_ASSERT(index < size());
  return (*elements_)[index].WithPath(path_ + "[" + std::to_string(index) + "]");
}

const std::vector<OptionValue::Entry>& OptionValue::entries() const {
  static const std::vector<Entry> none;
  return entries_ ? *entries_ : none;
}

bool OptionValue::Has(const std::string& key) const {
  return std::any_of(entries().begin(), entries().end(),
                     [&](const Entry& e) { return e.key == key && e.value.kind_ != Kind::kNothing; });
}

OptionValue OptionValue::Child(const std::string& key) const {
  const std::string path = path_.empty() ? key : path_ + "." + key;
  for (const Entry& entry : entries()) {
    if (entry.key == key) return entry.value.WithPath(path);
  }
  return Nothing(origin_).WithPath(path);
}

void OptionValue::Set(const std::string& dotted_key, const OptionValue& value) {
  const size_t dot = dotted_key.find('.');
  const std::string key = dotted_key.substr(0, dot);
  std::vector<Entry> changed = entries();
  if (kind_ == Kind::kNothing) *this = Map({}, value.origin_).WithPath(path_);
  auto at = std::find_if(changed.begin(), changed.end(), [&](const Entry& entry) { return entry.key == key; });
  if (at == changed.end()) at = changed.insert(at, {key, value.origin_, Nothing(value.origin_)});
  if (dot == std::string::npos) {
    at->value = value;
  } else {
    if (at->value.kind_ != Kind::kNothing && !at->value.IsMap()) {
      const std::string& assignment = value.origin_.assignment;
      const size_t next_dot = dotted_key.find('.', dot + 1);
      throw BadInput((assignment.empty() ? path_ : assignment) + ": " + key + " is not a map and has no key " +
                     dotted_key.substr(dot + 1, next_dot == std::string::npos ? next_dot : next_dot - dot - 1));
    }
    at->value.Set(dotted_key.substr(dot + 1), value);
  }
  entries_ = std::make_shared<const std::vector<Entry>>(std::move(changed));
}

std::string OptionValue::Located(const std::string& message) const {
  if (!origin_.assignment.empty())
    return origin_.assignment + ": " + (path_ == origin_.assigned_key ? "" : path_ + ": ") + message;
  std::string where = origin_.file;
  if (origin_.line > 0) where += ":" + std::to_string(origin_.line) + ":" + std::to_string(origin_.column);
  return (where.empty() ? "" : where + ": ") + (path_.empty() ? "" : path_ + ": ") + message;
}

void OptionValue::Fail(const std::string& message) const { throw BadInput(Located(message)); }

bool OptionValue::operator==(const OptionValue& other) const {
  if (kind_ != other.kind_ || text_ != other.text_ || size() != other.size()) return false;
  if (elements_ && *elements_ != *other.elements_) return false;
  return std::equal(entries().begin(), entries().end(), other.entries().begin(), other.entries().end(),
                    [](const Entry& a, const Entry& b) { return a.key == b.key && a.value == b.value; });
}

}  // namespace gaitcam
