#include "results/scoring/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "algorithms/core/errors.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;

Baseline Example() {
  MeasuredRun good{1,
                   "abc",
                   RunState::kScored,
                   "",
                   {{"coverage_ratio", 1}, {"ate_rmse_m", 0.1 + 0.2}},
                   {{"ate_rmse_m", {0.1, 0.7}}}};
  MeasuredRun odd{18446744073709551615u,
                  "def",
                  RunState::kScored,
                  "",
                  {{"coverage_ratio", 0.5}, {"ate_rmse_m", std::numeric_limits<double>::quiet_NaN()}},
                  {}};
  MeasuredRun none{3, "ghi", RunState::kNotScored, "covers \"4\" %", {{"coverage_ratio", 0.04}}, {}};
  return {"smoke",
          "0.1.0",
          "finger",
          "llvmpipe (LLVM 15, 256 bits)",
          {{{"turn", "{name: x, ratio: 1}", {good, odd, none}}, "seed: 1\ngait:\n  preset: normal\n"}}};
}

class BaselineTest : public testing::Test {
 protected:
  void Write(const std::string& text) const { folder_.Write("baseline.json", text); }
  std::string Refusal(const std::string& text) const {
    Write(text);
    try {
      ReadBaseline(file_);
    } catch (const BadInput& e) {
      return e.what();
    }
    return "was read";
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "baseline.json";
};

TEST_F(BaselineTest, ComesBackToTheBit) {
  const std::string text = BaselineToJson(Example());
  Write(text);
  const Baseline read = ReadBaseline(file_);
  EXPECT_EQ(BaselineToJson(read), text);
  EXPECT_EQ(read.renderer, "llvmpipe (LLVM 15, 256 bits)");
  const BaselineEntry* entry = read.Find("turn", "{name: x, ratio: 1}");
  ASSERT_NE(entry, nullptr);
  EXPECT_EQ(entry->resolved, "seed: 1\ngait:\n  preset: normal\n");
  EXPECT_EQ(entry->measured.runs[0].Value("ate_rmse_m"), 0.1 + 0.2);
  EXPECT_EQ(entry->measured.runs[1].seed, 18446744073709551615u);
  EXPECT_TRUE(std::isnan(entry->measured.runs[1].Value("ate_rmse_m")));
  EXPECT_EQ(entry->measured.runs[2].state, RunState::kNotScored);
  EXPECT_EQ(entry->measured.runs[2].reason, "covers \"4\" %");
  EXPECT_EQ(read.Find("turn", "other"), nullptr);
}

TEST_F(BaselineTest, OneThatIsNotThereSaysHowToWriteIt) {
  try {
    ReadBaseline("/nowhere/smoke.json");
    FAIL();
  } catch (const BadInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("/nowhere/smoke.json: there is no such baseline; --update writes one"));
  }
}

TEST_F(BaselineTest, DamageIsNamedWithTheFile) {
  const std::string good = BaselineToJson(Example());
  for (const std::string& text : {std::string(), good.substr(0, good.size() / 2), std::string("[]"),
                                  std::string("{\"schema\": \"gaitcam.baseline.1\"}")}) {
    EXPECT_THAT(Refusal(text), HasSubstr(file_.string() + ": damaged")) << text.substr(0, 40);
  }
  for (const std::string seed : {"\"one\"", "1e30", "-1"}) {
    std::string wrong_seed = good;
    wrong_seed.replace(wrong_seed.find("\"seed\":1"), 8, "\"seed\":" + seed);
    EXPECT_THAT(Refusal(wrong_seed), HasSubstr(file_.string() + ": seed: expected a whole number")) << seed;
  }
  std::string wrong_state = good;
  wrong_state.replace(wrong_state.find("not_scored"), 10, "was_scored");
  EXPECT_THAT(Refusal(wrong_state), HasSubstr("\"was_scored\" is no status"));
  std::string twice = good;
  twice.replace(twice.find("\"seed\":3"), 8, "\"seed\":1");
  EXPECT_THAT(Refusal(twice), HasSubstr("seed 1 is there twice"));
}

TEST_F(BaselineTest, AnotherSchemaIsRefusedByName) {
  std::string text = BaselineToJson(Example());
  text.replace(text.find("baseline.1"), 10, "baseline.9");
  EXPECT_THAT(Refusal(text), HasSubstr("schema \"gaitcam.baseline.9\""));
}

TEST_F(BaselineTest, EveryByteOfANumberCounts) {
  Baseline a = Example(), b = Example();
  double& value = b.entries[0].measured.runs[0].values["ate_rmse_m"];
  value = std::nextafter(value, 1);
  EXPECT_NE(BaselineToJson(a), BaselineToJson(b));
}

}  // namespace
}  // namespace gaitcam
