#include "models/yaml_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gaitcam {
namespace {

struct Inner {
  using DescribedTag = void;
  double period_s = 0.35;
  std::string mode = "global";
};

template <class Visitor>
void VisitFields(Visitor& visit, Inner& o) {
  visit("period_s", o.period_s, Between(0.1, 3), "");
  visit("mode", o.mode, OneOf({"global", "rolling"}), "");
}

struct Outer {
  using DescribedTag = void;
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

std::string ErrorOf(const std::string& text, const std::vector<std::string>& sets = {}) {
  try {
    YamlNode node = YamlNode::FromText(text, "file.yaml");
    for (const std::string& set : sets) node.Set(set);
    Outer outer;
    ReadYaml(node, outer);
  } catch (const BadInput& e) {
    return e.what();
  }
  return "";
}

TEST(YamlFields, AbsentKeysKeepTheirDefaults) {
  Outer outer;
  ReadYaml(YamlNode::FromText("inner: {period_s: 0.5}\npoints: [[0, 1], [2, 3]]", "f"), outer);
  EXPECT_EQ(outer.count, 3);
  EXPECT_EQ(outer.inner.period_s, 0.5);
  EXPECT_EQ(outer.inner.mode, "global");
  ASSERT_EQ(outer.points.size(), 2u);
  EXPECT_EQ(outer.points[1], Eigen::Vector2d(2, 3));
}

TEST(YamlFields, ErrorsNameFileLineColumnKeyAndWhatWouldBeRight) {
  EXPECT_EQ(ErrorOf("count: 3\ninner:\n  periodd_s: 1"),
            "file.yaml:3:3: inner.periodd_s: unknown key; did you mean period_s?");
  EXPECT_EQ(ErrorOf("inner: {period_s: 9}"),
            "file.yaml:1:19: inner.period_s: 9 is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(ErrorOf("count: many"), "file.yaml:1:8: count: \"many\" is not a whole number");
  EXPECT_EQ(ErrorOf("count: .nan"), "file.yaml:1:8: count: \".nan\" is not a whole number");
  EXPECT_EQ(ErrorOf("inner: {period_s: .nan}"),
            "file.yaml:1:19: inner.period_s: nan is not permitted; expected a number from 0.1 to 3");
  EXPECT_EQ(ErrorOf("inner: {mode: roling}"),
            "file.yaml:1:15: inner.mode: \"roling\" is not permitted; expected one of global, rolling (did you mean "
            "rolling?)");
  EXPECT_EQ(ErrorOf("points: [[0, 1], [2]]"), "file.yaml:1:18: points[1]: expected a list of 2 numbers");
  EXPECT_EQ(ErrorOf("count: 3\ncount: 4"), "file.yaml:2:1: count: this key is given twice");
  EXPECT_THAT(ErrorOf("count: [3\n"), testing::StartsWith("file.yaml:2:1: not valid YAML"));
  EXPECT_THAT(ErrorOf("3"), testing::HasSubstr("expected a map"));
}

TEST(YamlFields, CommandLineValuesReplaceAndAreNamedInErrors) {
  Outer outer;
  YamlNode node = YamlNode::FromText("count: 3", "f");
  node.Set("inner.period_s=0.25");
  node.Set("count=4");
  node.Set("points=[[1, 2]]");
  ReadYaml(node, outer);
  EXPECT_EQ(outer.inner.period_s, 0.25);
  EXPECT_EQ(outer.count, 4);
  EXPECT_EQ(outer.points.size(), 1u);
  EXPECT_EQ(ErrorOf("", {"inner.period_s=9"}),
            "--set inner.period_s=9: 9 is not permitted; expected a number from 0.1 to 3");
  EXPECT_THAT(ErrorOf("", {"iner.period_s=1"}), testing::HasSubstr("did you mean inner?"));
  EXPECT_THAT(ErrorOf("", {"count"}), testing::HasSubstr("expected key=value"));
  EXPECT_THAT(ErrorOf("count: 3", {"count.x=1"}), testing::HasSubstr("count is not a map"));
}

TEST(YamlFields, WhatIsWrittenReadsBackTheSame) {
  Outer outer;
  outer.count = 7;
  outer.inner.period_s = 0.1 + 0.2;
  outer.points = {{0.1, -2.5}};
  YAML::Emitter out;
  WriteYaml(out, outer);
  Outer again;
  ReadYaml(YamlNode::FromText(out.c_str(), "f"), again);
  EXPECT_EQ(again.count, 7);
  EXPECT_EQ(again.inner.period_s, outer.inner.period_s);  // to the bit: shortest round-trip text
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

}  // namespace
}  // namespace gaitcam
