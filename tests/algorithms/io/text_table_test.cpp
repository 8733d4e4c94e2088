#include "algorithms/io/text_table.h"

#include <gtest/gtest.h>

#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

TEST(Seconds, EveryStampComesBackExactly) {
  RandomStream random(1, "text_table_test");
  for (const int64_t edge : {int64_t(0), int64_t(1), int64_t(-1), std::numeric_limits<int64_t>::max(),
                             std::numeric_limits<int64_t>::min() + 1, int64_t(999'999'999), int64_t(-1'000'000'000)}) {
    int64_t read = 12345;
    ASSERT_TRUE(ParseSeconds(SecondsText(edge), read)) << edge;
    EXPECT_EQ(read, edge);
  }
  for (int i = 0; i < 1000; ++i) {
    const auto stamp = int64_t(random.Bits() >> (1 + random.Index(62)));
    int64_t read = 0;
    ASSERT_TRUE(ParseSeconds(SecondsText(stamp), read));
    EXPECT_EQ(read, stamp);
  }
}

TEST(Seconds, AnyDecimalNotationIsRead) {
  const auto ns = [](const char* text) {
    int64_t value = -77;
    EXPECT_TRUE(ParseSeconds(text, value)) << text;
    return value;
  };
  EXPECT_EQ(ns("1.5"), 1'500'000'000);
  EXPECT_EQ(ns("+.5"), 500'000'000);
  EXPECT_EQ(ns("3."), 3'000'000'000);
  EXPECT_EQ(ns("1.036224e-01"), 103'622'400);
  EXPECT_EQ(ns("0.0000000004"), 0);
  EXPECT_EQ(ns("0.0000000005"), 1);
  EXPECT_EQ(ns("-0.9999999996"), -1'000'000'000);
  EXPECT_EQ(ns("0e5"), 0);
  EXPECT_EQ(ns("1e-30"), 0);
}

TEST(Seconds, WhatIsNotATimeIsRefused) {
  int64_t value = 0;
  for (const char* text : {"", ".", "-", "1.2.3", "0x10", "1,5", "nan", "1e", "1e+", "99999999999999999999", "1e12",
                           "9223372036.8547758079"}) {
    EXPECT_FALSE(ParseSeconds(text, value)) << text;
  }
}

TEST(ExactText, DoublesComeBackToTheBit) {
  RandomStream random(2, "text_table_test");
  for (int i = 0; i < 1000; ++i) {
    const double value = random.Normal() * std::pow(10.0, random.Uniform(-30, 30));
    EXPECT_EQ(std::stod(ExactText(value)), value);
  }
}

TEST(TextTable, AFileThatCannotBeReadToItsEndIsNotTakenForAShortOne) {
  TextTable table("/proc/self/mem", ' ');  // opens, and cannot be read: nothing is at address 0
  EXPECT_THROW(table.Next(), BadInput);
}

}  // namespace
}  // namespace gaitcam
