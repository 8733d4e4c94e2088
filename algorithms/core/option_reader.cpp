#include "algorithms/core/option_reader.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

/// A scalar of a kind; `permitted` follows the refusal of one that is not.
template <class T>
void ReadScalar(const OptionValue& node, T& value, const std::optional<T>& read, const char* kind,
                const std::string& permitted = "") {
  if (!node.IsScalar()) node.Fail(std::string("expected ") + (permitted.empty() ? kind : permitted));
  if (!read) node.Fail('"' + node.text() + "\" is not " + kind + (permitted.empty() ? "" : "; expected " + permitted));
  value = *read;
}

template <class Number>
void RefuseOutside(const OptionValue& node, Number value, const Interval& limits) {
  if (limits.Contains(double(value))) return;
  throw BadOption(node.Located(internal::NumberText(double(value)) + " is not permitted; expected " + limits.ToText()));
}

template <int N>
void ReadNumbers(const OptionValue& node, Eigen::Matrix<double, N, 1>& value) {
  if (node.size() != N) node.Fail("expected a list of " + std::to_string(N) + " numbers");
  for (int i = 0; i < N; ++i) ReadOption(node.Element(size_t(i)), value[i]);
}

/// No quantity that is read is larger, and arithmetic with two such numbers stays finite.
constexpr double kLargest = 1e9;

void RefuseHuge(const OptionValue& node, double value) {
  if (std::abs(value) <= kLargest) return;  // not a number is not
  throw BadOption(node.Located(node.text() + " is not permitted; expected a number from -1e9 to 1e9"));
}

constexpr const char* kNumber = "a number";
constexpr const char* kWhole = "a whole number";
constexpr const char* kUnsigned = "a whole number of at least 0";

}  // namespace

void ReadOption(const OptionValue& node, double& value) {
  ReadScalar(node, value, node.AsNumber(), kNumber);
  RefuseHuge(node, value);
}
void ReadOption(const OptionValue& node, int& value) { ReadScalar(node, value, node.AsInt(), kWhole); }
void ReadOption(const OptionValue& node, uint64_t& value) { ReadScalar(node, value, node.AsUnsigned(), kUnsigned); }
void ReadOption(const OptionValue& node, bool& value) { ReadScalar(node, value, node.AsFlag(), "true or false"); }
void ReadOption(const OptionValue& node, std::string& value) {
  ReadScalar(node, value, std::optional<std::string>(node.text()), "a text");
}
void ReadOption(const OptionValue& node, Eigen::Vector2d& value) { ReadNumbers<2>(node, value); }
void ReadOption(const OptionValue& node, Eigen::Vector3d& value) { ReadNumbers<3>(node, value); }

void ReadOption(const OptionValue& node, std::map<std::string, double>& value) {
  if (!node.IsMap()) node.Fail("expected a map of names and numbers");
  value.clear();
  for (const auto& entry : node.entries()) ReadOption(node.Child(entry.key), value[entry.key]);
}

void ReadOption(const OptionValue& node, double& value, const Interval& limits) {
  ReadScalar(node, value, node.AsNumber(), kNumber, limits.ToText());
  RefuseOutside(node, value, limits);
  RefuseHuge(node, value);
}

void ReadOption(const OptionValue& node, int& value, const Interval& limits) {
  ReadScalar(node, value, node.AsInt(), kWhole, limits.ToText());
  RefuseOutside(node, value, limits);
}

void ReadOption(const OptionValue& node, uint64_t& value, const Interval& limits) {
  ReadScalar(node, value, node.AsUnsigned(), kWhole, limits.ToText());
  RefuseOutside(node, value, limits);
}

void ReadOption(const OptionValue& node, std::string& value, const Words& limits) {
  ReadScalar(node, value, std::optional<std::string>(node.text()), "a text", limits.ToText());
  if (!limits.Contains(value)) throw BadOption(node.Located(limits.Refusal(value)));
}

void RefuseUnknownKeys(const OptionValue& node, const std::vector<std::string>& known,
                       const std::vector<RenamedKey>& renamed) {
  if (!node.IsMap()) node.Fail("expected a map of keys and values");
  std::set<std::string> seen;
  for (const auto& [key, origin, value] : node.entries()) {
    const OptionValue here = OptionValue::Nothing(origin).WithPath(node.path().empty() ? key : node.path() + "." + key);
    if (!seen.insert(key).second) here.Fail("this key is given twice");
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    for (const RenamedKey& rename : renamed) {
      if (rename.old_key == key) here.Fail("this key is called " + std::string(rename.new_key) + " now");
    }
    here.Fail("unknown key; " + DidYouMean(key, known, "known here: " + JoinWords(known)));
  }
}

}  // namespace gaitcam
