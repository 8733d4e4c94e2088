/// Described structs: one description of an options struct serves everything that reads, checks, lists or writes it.
///
/// A struct is described by a function found by argument-dependent lookup:
///
///   struct ExposureOptions { using DescribedTag = void; double exposure_ms = 20; ... };
///   template <class Visitor> void VisitFields(Visitor& visit, ExposureOptions& o) {
///     visit("exposure_ms", o.exposure_ms, Between(0.0, 1000.0), "shutter open to close");
///     visit("shutter", o.shutter, EnumWords<Shutter>(), "shutter kind");
///     visit("noise", o.noise, Nested(), "sensor noise");
///   }
///
/// A visitor is called with (key, reference to the member, limits, description). The description is the only one that
/// the field has: meaning, source, and unit where the key does not end in it (UnitOfKey). A member's own comment says
/// only what a user need not know.
///
/// Readers: option_reader.h. Lists: field_list.h. YAML output: models/code/yaml. JSON Schema: scenarios/code/commands.

#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/enum_words.h"
#include "algorithms/core/errors.h"

namespace gaitcam {

/// Permitted interval of a number, ends included unless said otherwise.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< True: `low` itself is not permitted.

  bool Contains(double value) const {
    return std::isfinite(value) && (low_open ? value > low : value >= low) && value <= high;
  }
  std::string ToText() const;
};

inline Interval Between(double low, double high) { return {low, high, false}; }
inline Interval AtLeast(double low) { return {low, std::numeric_limits<double>::infinity(), false}; }
inline Interval Positive() { return {0.0, std::numeric_limits<double>::infinity(), true}; }
inline Interval AnyNumber() { return {}; }

/// Permitted words of a string; empty permits any.
struct Words {
  std::vector<std::string> words;
  bool Contains(const std::string& value) const;
  std::string ToText() const;
  /// "\"value\" is not permitted; expected one of a, b", with the nearest of them.
  std::string Refusal(const std::string& value) const;
};

inline Words OneOf(std::vector<std::string> words) { return {std::move(words)}; }
inline Words AnyText() { return {}; }
template <DescribedEnum Enum>
Words AsWords(EnumWords<Enum>) {
  return {EnumWords<Enum>::List()};
}

/// No limits of its own: a flag, a vector, or a struct that has VisitFields.
struct Nested {};

/// A struct announces that it has VisitFields by `using DescribedTag = void;`.
template <class T>
concept Described = requires {
  typename T::DescribedTag;
};

namespace internal {

[[noreturn]] void ThrowOutOfRange(const std::string& field, const std::string& value, const std::string& permitted);
std::string NumberText(double value);

/// Visits every field and throws at the first that is out of its limits.
class RangeChecker {
 public:
  explicit RangeChecker(std::string prefix) : prefix_(std::move(prefix)) {}

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void operator()(std::string_view key, Number& value, const Interval& limits, std::string_view) {
    if (!limits.Contains(double(value))) ThrowOutOfRange(Name(key), NumberText(double(value)), limits.ToText());
  }
  void operator()(std::string_view key, std::string& value, const Words& limits, std::string_view) {
    if (!limits.Contains(value)) ThrowOutOfRange(Name(key), '"' + value + '"', limits.ToText());
  }
  template <DescribedEnum Enum>
  void operator()(std::string_view key, Enum& value, const EnumWords<Enum>& limits, std::string_view) {
    if (!limits.Contains(value)) ThrowOutOfRange(Name(key), std::to_string(int(value)), AsWords(limits).ToText());
  }
  template <class T>
  void operator()(std::string_view key, T& value, Nested, std::string_view) {
    if constexpr (Described<T>) {
      RangeChecker inner(Name(key) + ".");
      VisitFields(inner, value);
    }
  }

 private:
  std::string Name(std::string_view key) const { return prefix_ + std::string(key); }
  std::string prefix_;
};

}  // namespace internal

/// Checks every field of a described struct against its limits.
/// @throws BadOption naming field (`prefix` before it), value and what is permitted.
template <class T>
void CheckFields(const T& options, const std::string& prefix = "") {
  internal::RangeChecker checker(prefix);
  VisitFields(checker, const_cast<T&>(options));  // the checker only reads
}

/// The unit that a key's suffix says: "m" of `length_m`, "m/s" of `speed_m_s`, "%" of `margin_pct`; "" where it says
/// none.
std::string_view UnitOfKey(std::string_view key);

}  // namespace gaitcam
