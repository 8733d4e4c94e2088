/// The words by which users name the values of an enum.
///
/// An enum is described by a table found by argument-dependent lookup:
///
///   enum class Shutter { kGlobal, kRolling };
///   constexpr auto WordsOf(Shutter) {
///     return std::array{EnumWord{Shutter::kGlobal, "global"}, EnumWord{Shutter::kRolling, "rolling"}};
///   }
///
/// A field of that type is described as `visit("shutter", o.shutter, EnumWords<Shutter>(), "...")` (fields.h); files,
/// settings, lists and schemas then know it by its words.

#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace gaitcam {

template <class Enum>
struct EnumWord {
  Enum value;
  std::string_view word;
};
template <class Enum>
EnumWord(Enum, const char*) -> EnumWord<Enum>;

template <class T>
concept DescribedEnum = std::is_enum_v<T> && requires(T value) {
  WordsOf(value);
};

/// The word of a value; "" for one that is not in the table.
template <DescribedEnum Enum>
constexpr std::string_view ToWord(Enum value) {
  for (const auto& entry : WordsOf(value)) {
    if (entry.value == value) return entry.word;
  }
  return {};
}

/// The value of a word; nothing where no value has it.
template <DescribedEnum Enum>
constexpr std::optional<Enum> FromWord(std::string_view word) {
  for (const auto& entry : WordsOf(Enum())) {
    if (entry.word == word) return entry.value;
  }
  return std::nullopt;
}

/// Limits of a field of an enum's type: the values of its table.
template <DescribedEnum Enum>
struct EnumWords {
  static std::vector<std::string> List() {
    std::vector<std::string> words;
    for (const auto& entry : WordsOf(Enum())) words.emplace_back(entry.word);
    return words;
  }
  bool Contains(Enum value) const { return FromWord<Enum>(ToWord(value)) == value; }
};

}  // namespace gaitcam
