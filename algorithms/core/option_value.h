/// A tree of option values as a user wrote them: in a YAML file, in a `--set key=value`, or as a system's settings.
///
/// Each value knows its origin, so that whoever finds fault with it can name file, line, column and key. What the
/// values mean is decided by the struct that reads them (option_reader.h). Values are immutable but for Set() at the
/// root, and cheap to copy.

#pragma once

#include <concepts>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace gaitcam {

/// Where a value was written.
struct OptionOrigin {
  std::string file;          ///< Path as the user gave it; empty: no file.
  int line = 0, column = 0;  ///< From 1; 0: not known.
  std::string assignment;    ///< "--set gait.period_s=9"; empty: not from an assignment. Takes precedence over `file`.
  std::string assigned_key;  ///< Dotted key of that assignment.
};

class OptionValue {
 public:
  enum class Kind { kNothing, kScalar, kList, kMap };
  struct Entry;

  OptionValue() = default;  ///< Nothing: as if the key were absent.
  explicit OptionValue(std::string text, OptionOrigin origin);
  OptionValue(std::string text) : OptionValue(std::move(text), {}) {}  // NOLINT: settings are written as literals
  OptionValue(const char* text) : OptionValue(std::string(text)) {}    // NOLINT
  template <class Number>
  requires std::is_arithmetic_v<Number> OptionValue(Number number) : OptionValue(TextOf(number)) {}  // NOLINT
  static OptionValue Nothing(OptionOrigin origin);
  static OptionValue List(std::vector<OptionValue> elements, OptionOrigin origin);
  static OptionValue Map(std::vector<Entry> entries, OptionOrigin origin);

  Kind kind() const { return kind_; }
  bool IsScalar() const { return kind_ == Kind::kScalar; }
  bool IsList() const { return kind_ == Kind::kList; }
  bool IsMap() const { return kind_ == Kind::kMap; }
  const OptionOrigin& origin() const { return origin_; }
  /// The dotted key that leads here ("gait.period_s", "people[1].path"); empty at the root.
  const std::string& path() const { return path_; }
  /// The same value under another path, which messages then name.
  OptionValue WithPath(std::string path) const;
  OptionValue WithOrigin(OptionOrigin origin) const;
  /// Folder of the file that this was written in.
  std::filesystem::path folder() const { return std::filesystem::path(origin_.file).parent_path(); }

  /// A scalar as it is written, without quotation marks; "" for anything else.
  const std::string& text() const { return text_; }
  std::optional<double> AsNumber() const;
  /// A whole number within the range of the type: "12", "1e3", "0x1f".
  std::optional<int> AsInt() const;
  std::optional<uint64_t> AsUnsigned() const;
  /// true, yes, on, y, 1 and false, no, off, n, 0.
  std::optional<bool> AsFlag() const;
  /// As a message shows a scalar: numbers and flags as they are, other texts in quotation marks.
  std::string Shown() const;

  /// Elements of a list; 0 for anything else.
  size_t size() const;
  OptionValue Element(size_t index) const;
  /// Entries of a map in the order of the file, a key that is given twice included.
  const std::vector<Entry>& entries() const;
  bool Has(const std::string& key) const;
  /// The value of a key; Nothing, with this map's origin, if it is absent.
  OptionValue Child(const std::string& key) const;

  /// Replaces or adds the value at a dotted key, making the maps that lead to it.
  /// @throws BadInput if the key leads through something that is not a map.
  void Set(const std::string& dotted_key, const OptionValue& value);

  /// "file:line:column: key: message", or "--set key=value: message", or "key: message".
  std::string Located(const std::string& message) const;
  /// @throws BadInput with the located message.
  [[noreturn]] void Fail(const std::string& message) const;

  /// Equal content, wherever it was written.
  bool operator==(const OptionValue& other) const;

 private:
  template <class Number>
  static std::string TextOf(Number number) {
    if constexpr (std::is_same_v<Number, bool>) {
      return number ? "true" : "false";
    } else if constexpr (std::is_integral_v<Number>) {
      return std::to_string(number);
    } else {
      return TextOfDouble(double(number));
    }
  }
  static std::string TextOfDouble(double number);

  Kind kind_ = Kind::kNothing;
  std::string text_, path_;
  OptionOrigin origin_;
  std::shared_ptr<const std::vector<OptionValue>> elements_;
  std::shared_ptr<const std::vector<Entry>> entries_;
};

struct OptionValue::Entry {
  std::string key;
  OptionOrigin origin;  ///< Of the key.
  OptionValue value;
};

}  // namespace gaitcam
