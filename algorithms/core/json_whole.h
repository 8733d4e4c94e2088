/// Whole numbers of JSON that somebody else wrote. The conversions of nlohmann-json cast any number, and a cast of one
/// that does not fit is undefined.

#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "algorithms/core/errors.h"

namespace gaitcam {

/// A whole number that fits. Written as 12.0 it is one, too.
/// @param json a basic_json of nlohmann
/// @throws BadInput "WHAT: expected a whole number", also for one beyond the range of Whole
template <class Whole, class Json>
Whole WholeOf(const Json& json, std::string_view what) {
  constexpr double kMostExact = 1e15;
  const auto fail = [&] { throw BadInput(std::string(what) + ": expected a whole number"); };
  if (json.is_number_unsigned()) {
    const auto number = json.template get<uint64_t>();
    if (!std::in_range<Whole>(number)) fail();
    return Whole(number);
  }
  if (json.is_number_float()) {
    const auto number = json.template get<double>();
    if (!(std::abs(number) < kMostExact) || number != std::trunc(number)) fail();
    if (!std::in_range<Whole>(int64_t(number))) fail();
    return Whole(number);
  }
  if (!json.is_number_integer() || !std::in_range<Whole>(json.template get<int64_t>())) fail();
  return Whole(json.template get<int64_t>());
}

}  // namespace gaitcam
