#include "algorithms/core/json_whole.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace gaitcam {
namespace {

template <class Whole>
Whole Read(const std::string& text) {
  return WholeOf<Whole>(nlohmann::json::parse(text), "count");
}

TEST(WholeOf, TakesWholeNumbersUpToTheEndsOfTheirRange) {
  EXPECT_EQ(Read<int>("0"), 0);
  EXPECT_EQ(Read<int>("-2147483648"), std::numeric_limits<int>::min());
  EXPECT_EQ(Read<int>("2147483647"), std::numeric_limits<int>::max());
  EXPECT_EQ(Read<int64_t>("-9223372036854775808"), std::numeric_limits<int64_t>::min());
  EXPECT_EQ(Read<uint64_t>("18446744073709551615"), std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(Read<int>("12.0"), 12);
  EXPECT_EQ(Read<int>("-1e3"), -1000);
}

TEST(WholeOf, RefusesWhatDoesNotFitOrIsNotWhole) {
  for (const std::string text : {"2147483648", "-2147483649", "2147483648.0", "1e21", "-1e300", "999999999999999999999",
                                 "0.5", "null", "true", "\"1\"", "[1]", "{}"}) {
    try {
      ADD_FAILURE() << text << " was read as " << Read<int>(text);
    } catch (const BadInput& e) {
      EXPECT_STREQ(e.what(), "count: expected a whole number") << text;
    }
  }
  EXPECT_THROW(Read<uint64_t>("-1"), BadInput);
  EXPECT_THROW(Read<uint64_t>("-1.0"), BadInput);
  EXPECT_THROW(Read<int64_t>("9223372036854775808"), BadInput);
  EXPECT_THROW(Read<int64_t>("1e18"), BadInput);  // a double of this size need not be the number that was written
}

}  // namespace
}  // namespace gaitcam
