// Trees of option values, and what is known of a described struct without reading anything.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "algorithms/core/errors.h"
#include "algorithms/core/field_list.h"
#include "algorithms/core/option_reader.h"
#include "tests/error_of.h"

namespace gaitcam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

enum class Shade { kLight, kDark };
constexpr auto WordsOf(Shade) { return std::array{EnumWord{Shade::kLight, "light"}, EnumWord{Shade::kDark, "dark"}}; }

struct Lamp {
  using DescribedTag = void;
  double reach_m = 2;
  Shade shade = Shade::kDark;
};
template <class Visitor>
void VisitFields(Visitor& visit, Lamp& o) {
  visit("reach_m", o.reach_m, Positive(), "how far it shines");
  visit("shade", o.shade, EnumWords<Shade>(), "of its light");
}

struct Hall {
  using DescribedTag = void;
  int lamps = 3;
  bool open = true;
  std::string name;
  Lamp lamp;
  uint64_t seed = 1;
};
template <class Visitor>
void VisitFields(Visitor& visit, Hall& o) {
  visit("lamps", o.lamps, Between(0, 10), "how many");
  visit("open", o.open, Nested(), "");
  visit("name", o.name, AnyText(), "");
  visit("lamp", o.lamp, Nested(), "each of them");
  visit("seed", o.seed, AtLeast(0), "");
}

OptionValue Tree(const std::vector<std::pair<std::string, OptionValue>>& settings) {
  OptionValue tree = OptionValue::Map({}, {});
  for (const auto& [key, value] : settings) tree.Set(key, value);
  return tree;
}

TEST(EnumWords, WordAndValueAreEachOthersInverse) {
  for (const Shade shade : {Shade::kLight, Shade::kDark}) EXPECT_EQ(FromWord<Shade>(ToWord(shade)), shade);
  EXPECT_EQ(FromWord<Shade>("Light"), std::nullopt);
  EXPECT_EQ(ToWord(Shade(9)), "");
  EXPECT_FALSE(EnumWords<Shade>().Contains(Shade(9)));
  EXPECT_THAT(EnumWords<Shade>::List(), ElementsAre("light", "dark"));
}

TEST(OptionValue, NumbersSurviveToTheBit) {
  for (const double number : {0.1 + 0.2, -1e-300, 1e300, 3.0, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(OptionValue(number).AsNumber(), number);
  EXPECT_EQ(OptionValue(std::numeric_limits<uint64_t>::max()).AsUnsigned(), std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(OptionValue(std::numeric_limits<int>::min()).AsInt(), std::numeric_limits<int>::min());
  EXPECT_EQ(OptionValue("18446744073709551616").AsUnsigned(), std::nullopt);
  EXPECT_EQ(OptionValue("-1").AsUnsigned(), std::nullopt);
  EXPECT_EQ(OptionValue("1e300").AsInt(), std::nullopt);
  EXPECT_EQ(OptionValue("2147483648.0").AsInt(), std::nullopt);
}

TEST(OptionValue, SetMakesTheMapsThatLeadThereAndLeavesCopiesAlone) {
  OptionValue tree = Tree({{"a.b.c", 1}});
  const OptionValue before = tree;
  tree.Set("a.b.d", 2);
  tree.Set("a.b.c", 3);
  EXPECT_EQ(tree.Child("a").Child("b").Child("c").AsInt(), 3);
  EXPECT_EQ(tree.Child("a").Child("b").Child("d").AsInt(), 2);
  EXPECT_EQ(before.Child("a").Child("b").Child("c").AsInt(), 1);
  EXPECT_FALSE(before.Child("a").Child("b").Has("d"));
  EXPECT_EQ(tree.Child("a").Child("b").Child("d").path(), "a.b.d");
  EXPECT_THAT(ErrorOf([&] { tree.Set("a.b.c.d", 1); }), HasSubstr("c is not a map and has no key d"));
}

TEST(ReadOption, TakesAStructFromATreeAndKeepsWhatIsAbsent) {
  Hall hall;
  ReadOption(Tree({{"lamp.shade", "light"}, {"open", 0}, {"name", 7}}), hall);
  EXPECT_EQ(hall.lamp.shade, Shade::kLight);
  EXPECT_FALSE(hall.open);
  EXPECT_EQ(hall.name, "7");
  EXPECT_EQ(hall.lamps, 3);
  EXPECT_EQ(hall.lamp.reach_m, 2);
}

TEST(ReadOption, RefusesWithTheKeyAndWhatWouldBeRight) {
  const auto error = [](const std::string& key, const OptionValue& value) {
    return ErrorOf([&] {
      Hall hall;
      ReadOption(Tree({{key, value}}), hall);
    });
  };
  EXPECT_EQ(error("lamps", 11), "lamps: 11 is not permitted; expected a number from 0 to 10");
  EXPECT_EQ(error("lamps", 1.5), "lamps: \"1.5\" is not a whole number; expected a number from 0 to 10");
  EXPECT_EQ(error("lamp.reach_m", 0), "lamp.reach_m: 0 is not permitted; expected a number greater than 0");
  EXPECT_EQ(error("lamp.shade", "drak"),
            "lamp.shade: \"drak\" is not permitted; expected one of light, dark (did you mean dark?)");
  EXPECT_EQ(error("open", "perhaps"), "open: \"perhaps\" is not true or false");
  EXPECT_EQ(error("lamp", 1), "lamp: expected a map of keys and values");
  EXPECT_EQ(error("lmap.shade", "dark"), "lmap: unknown key; did you mean lamp?");
  EXPECT_THAT(error("x", 1), HasSubstr("x: unknown key; known here: lamps, open, name, lamp, seed"));
  EXPECT_THROW(
      {
        Hall hall;
        ReadOption(Tree({{"lamps", 11}}), hall);
      },
      BadOption);
}

TEST(ListFields, TellsKeyDefaultUnitRangeAndWords) {
  const std::vector<FieldInfo> fields = ListFields(Hall());
  ASSERT_EQ(fields.size(), 6U);
  EXPECT_EQ(fields[0].key, "lamps");
  EXPECT_EQ(fields[0].default_value, OptionValue(3));
  EXPECT_EQ(fields[0].permitted, "a number from 0 to 10");
  EXPECT_EQ(fields[1].permitted, "true or false");
  EXPECT_EQ(fields[1].default_value, OptionValue(true));
  EXPECT_EQ(fields[3].key, "lamp.reach_m");
  EXPECT_EQ(fields[3].unit, "m");
  EXPECT_EQ(fields[3].description, "how far it shines");
  EXPECT_EQ(fields[4].default_value, OptionValue("dark"));
  EXPECT_THAT(fields[4].words, ElementsAre("light", "dark"));
}

TEST(UnitOfKey, TakesTheLongestEndingThatItKnows) {
  EXPECT_EQ(UnitOfKey("speed_m_s"), "m/s");
  EXPECT_EQ(UnitOfKey("settle_s"), "s");
  EXPECT_EQ(UnitOfKey("px_per_m"), "px/m");
  EXPECT_EQ(UnitOfKey("margin_pct"), "%");
  EXPECT_EQ(UnitOfKey("systems"), "");
  EXPECT_EQ(UnitOfKey("ratio"), "");
}

TEST(DidYouMean, SuggestsOnlyWhatIsNear) {
  EXPECT_EQ(DidYouMean("sytem", {"seed", "system"}), "did you mean system?");
  EXPECT_EQ(DidYouMean("cartographer", {"seed", "system"}), "known: seed, system");
  EXPECT_EQ(DidYouMean("cartographer", {"seed", "system"}, "see the list"), "see the list");
}

}  // namespace
}  // namespace gaitcam
