/// One description of an options struct serves everything: reading it from YAML, writing it back, checking its ranges,
/// listing its keys and, for editors, its schema.
///
/// A struct is described by a function found by argument-dependent lookup:
///
///   struct ExposureOptions { using DescribedTag = void; double exposure_ms = 20; ... };
///   template <class Visitor> void VisitFields(Visitor& visit, ExposureOptions& o) {
///     visit("exposure_ms", o.exposure_ms, Between(0.0, 1000.0), "shutter open to close");
///     visit("mode", o.mode, OneOf({"global", "rolling"}), "shutter kind");
///     visit("noise", o.noise, Nested(), "sensor noise");
///   }
///
/// A visitor is called with (key, reference to the member, limits, description).

#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

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
};

inline Words OneOf(std::vector<std::string> words) { return {std::move(words)}; }
inline Words AnyText() { return {}; }

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

/// The candidate nearest to `word` by edit distance, or "" when none is near enough to be a slip of the hand.
std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace gaitcam
