/// What there is to know of a described struct's fields without reading anything: for lists, schemas and messages.

#pragma once

#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "algorithms/core/fields.h"
#include "algorithms/core/option_value.h"

namespace gaitcam {

/// One number, flag, word or text of a described struct.
struct FieldInfo {
  std::string key;  ///< With those of the structs around it and dots: "matching.ratio".
  OptionValue default_value;
  std::string unit;                ///< UnitOfKey.
  std::string permitted;           ///< "a number from 0 to 1", "one of a, b", "true or false", "a text".
  std::vector<std::string> words;  ///< Of a closed set; else empty.
  std::string description;
};

namespace internal {

struct FieldLister {
  std::vector<FieldInfo>& fields;
  std::string prefix;

  template <class T, class Limits>
  void operator()(std::string_view key, T& value, const Limits& limits, std::string_view description) {
    const std::string name = prefix + std::string(key);
    const std::string unit(UnitOfKey(key)), text(description);
    if constexpr (Described<T>) {
      FieldLister inner{fields, name + "."};
      VisitFields(inner, value);
    } else if constexpr (std::is_same_v<T, bool>) {
      fields.push_back({name, value, unit, "true or false", {}, text});
    } else if constexpr (std::is_arithmetic_v<T>) {
      fields.push_back({name, value, unit, PermittedNumbers(limits, std::is_integral_v<T>), {}, text});
    } else if constexpr (DescribedEnum<T>) {
      const Words words = AsWords(EnumWords<T>());
      fields.push_back({name, std::string(ToWord(value)), unit, words.ToText(), words.words, text});
    } else if constexpr (std::is_same_v<T, std::string>) {
      fields.push_back({name, value, unit, limits.ToText(), limits.words, text});
    }
  }

 private:
  static std::string PermittedNumbers(const Interval& limits, bool) { return limits.ToText(); }
  static std::string PermittedNumbers(Nested, bool whole) { return whole ? "a whole number" : "a number"; }
};

}  // namespace internal

/// The numbers, flags, words and texts of a described struct and of those within it, in order; the values of `options`
/// are the defaults. Lists, vectors and optional members are left out.
template <Described T>
std::vector<FieldInfo> ListFields(const T& options) {
  std::vector<FieldInfo> fields;
  internal::FieldLister lister{fields, ""};
  VisitFields(lister, const_cast<T&>(options));  // the lister only reads
  return fields;
}

}  // namespace gaitcam
