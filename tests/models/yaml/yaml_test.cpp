#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"

namespace gaitcam {
namespace {

enum class Mode { kGlobal, kRolling };
constexpr auto WordsOf(Mode) {
  return std::array{EnumWord{Mode::kGlobal, "global"}, EnumWord{Mode::kRolling, "rolling"}};
}

struct Inner {
  using DescribedTag = void;
  double period_s = 0.35;
  Mode mode = Mode::kGlobal;
  std::string colour = "red";
};

template <class Visitor>
void VisitFields(Visitor& visit, Inner& o) {
  visit("period_s", o.period_s, Between(0.1, 3), "");
  visit("mode", o.mode, EnumWords<Mode>(), "");
  visit("colour", o.colour, OneOf({"red", "blue"}), "");
}

struct Outer {
  using DescribedTag = void;
  static constexpr std::array kRenamedKeys{RenamedKey{"number", "count"}};
  int count = 3;
  Inner inner;
  std::vector<Eigen::Vector2d> points;
};

template <class Visitor>
void VisitFields(Visitor& visit, Outer& o) {
  visit("count", o.count, Between(1, 10), "");
  visit("inner", o.inner, Nested(), "");
  visit("points", o.points, Nested(), "");
}

std::string YamlError(const std::string& text, const std::vector<std::string>& sets = {}) {
  try {
    OptionValue node = ParseYaml(text, "file.yaml");
    for (const std::string& set : sets) SetOption(node, set);
    Outer outer;
    ReadOption(node, outer);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "";
}

TEST(YamlFields, AbsentKeysKeepTheirDefaults) {
  Outer outer;
  ReadOption(ParseYaml("inner: {period_s: 0.5}\npoints: [[0, 1], [2, 3]]", "f"), outer);
  EXPECT_EQ(outer.count, 3);
  EXPECT_EQ(outer.inner.period_s, 0.5);
  EXPECT_EQ(outer.inner.mode, Mode::kGlobal);
  ASSERT_EQ(outer.points.size(), 2u);
  EXPECT_EQ(outer.points[1], Eigen::Vector2d(2, 3));
}

TEST(YamlFields, ErrorsNameFileLineColumnKeyAndWhatWouldBeRight) {
  EXPECT_EQ(YamlError("count: 3\ninner:\n  periodd_s: 1"),
            "file.yaml:3:3: inner.periodd_s: unknown key; did you mean period_s?");
  EXPECT_EQ(YamlError("inner: {period_s: 9}"),
            "file.yaml:1:19: inner.period_s: 9 is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(YamlError("count: many"),
            "file.yaml:1:8: count: \"many\" is not a whole number; expected a number from 1 to 10");
  EXPECT_EQ(YamlError("count: .nan"),
            "file.yaml:1:8: count: \".nan\" is not a whole number; expected a number from 1 to 10");
  EXPECT_EQ(YamlError("inner: {period_s: .nan}"),
            "file.yaml:1:19: inner.period_s: nan is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(YamlError("inner: {mode: roling}"),
            "file.yaml:1:15: inner.mode: \"roling\" is not permitted; expected one of global, rolling (did you mean "
            "rolling?)");
  EXPECT_EQ(YamlError("inner: {mode: 1}"),
            "file.yaml:1:15: inner.mode: \"1\" is not permitted; expected one of global, rolling");
  EXPECT_EQ(YamlError("inner: {mode: [rolling]}"), "file.yaml:1:15: inner.mode: expected one of global, rolling");
  EXPECT_EQ(YamlError("inner: {colour: blu}"),
            "file.yaml:1:17: inner.colour: \"blu\" is not permitted; expected one of red, blue (did you mean blue?)");
  EXPECT_EQ(YamlError("points: [[0, 1], [2]]"), "file.yaml:1:18: points[1]: expected a list of 2 numbers");
  EXPECT_EQ(YamlError("count: 3\ncount: 4"), "file.yaml:2:1: count: this key is given twice");
  EXPECT_THAT(YamlError("count: [3\n"), testing::StartsWith("file.yaml:2:1: not valid YAML"));
  EXPECT_THAT(YamlError("3"), testing::HasSubstr("expected a map"));
}

TEST(YamlFields, AKeyThatWasRenamedIsRefusedByItsNewName) {
  EXPECT_EQ(YamlError("number: 3"), "file.yaml:1:1: number: this key is called count now");
  EXPECT_EQ(YamlError("", {"number=3"}), "--set number=3: this key is called count now");
}

TEST(YamlFields, NumbersReadAsYamlWritesThem) {
  const auto number = [](const std::string& text) {
    Outer outer;
    ReadOption(ParseYaml("count: " + text, "f"), outer);
    return outer.count;
  };
  EXPECT_EQ(number("7"), 7);
  EXPECT_EQ(number("+7"), 7);
  EXPECT_EQ(number("'7'"), 7);
  EXPECT_EQ(number("7.0"), 7);
  EXPECT_EQ(number("1e1"), 10);
  EXPECT_EQ(number("0x9"), 9);
  EXPECT_EQ(number("~"), 3);  // nothing: the default
  for (const char* text : {"7.5", "99999999999", "1_0", "nan", ".inf", "''", "7 8", "[7]", "true"})
    EXPECT_NE(YamlError(std::string("count: ") + text), "") << text;
}

TEST(YamlFields, AnAliasWithinItselfIsRefused) {
  EXPECT_THAT(YamlError("points: &a [*a]"), testing::HasSubstr("nested too deeply"));
}

TEST(YamlFields, CommandLineValuesReplaceAndAreNamedInErrors) {
  Outer outer;
  OptionValue node = ParseYaml("count: 3", "f");
  SetOption(node, "inner.period_s=0.25");
  SetOption(node, "count=4");
  SetOption(node, "points=[[1, 2]]");
  ReadOption(node, outer);
  EXPECT_EQ(outer.inner.period_s, 0.25);
  EXPECT_EQ(outer.count, 4);
  EXPECT_EQ(outer.points.size(), 1u);
  EXPECT_EQ(YamlError("", {"inner.period_s=9"}),
            "--set inner.period_s=9: 9 is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(YamlError("", {"iner.period_s=1"}), "--set iner.period_s=1: iner: unknown key; did you mean inner?");
  EXPECT_EQ(YamlError("", {"inner={period_s: 9}"}),
            "--set inner={period_s: 9}: inner.period_s: 9 is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(YamlError("", {"inner.period_s=9", "inner.period_s=1"}), "");
  EXPECT_THAT(YamlError("", {"count"}), testing::HasSubstr("expected key=value"));
  EXPECT_THAT(YamlError("count: 3", {"count.x=1"}), testing::HasSubstr("count is not a map"));
}

TEST(YamlFields, WhatIsWrittenReadsBackTheSame) {
  Outer outer;
  outer.count = 7;
  outer.inner.period_s = 0.1 + 0.2;
  outer.inner.mode = Mode::kRolling;
  outer.points = {{0.1, -2.5}};
  YAML::Emitter out;
  WriteYaml(out, outer);
  Outer again;
  ReadOption(ParseYaml(out.c_str(), "f"), again);
  EXPECT_EQ(again.count, 7);
  EXPECT_EQ(again.inner.period_s, outer.inner.period_s);  // to the bit: shortest round-trip text
  EXPECT_EQ(again.inner.mode, Mode::kRolling);
  EXPECT_EQ(again.points, outer.points);
}

TEST(YamlFields, CheckFieldsNamesTheNestedField) {
  Outer outer;
  outer.inner.period_s = -1;
  try {
    CheckFields(outer);
    FAIL();
  } catch (const BadOption& e) {
    EXPECT_STREQ(e.what(), "inner.period_s: -1 is not permitted; expected a number from 0.1 to 3");
  }
}

TEST(YamlFields, CheckFieldsRefusesAnEnumWithoutAWord) {
  Inner inner;
  inner.mode = Mode(7);
  try {
    CheckFields(inner);
    FAIL();
  } catch (const BadOption& e) {
    EXPECT_STREQ(e.what(), "mode: 7 is not permitted; expected one of global, rolling");
  }
}

}  // namespace
}  // namespace gaitcam
