// Files for tools that are not on every machine: container file, workflows, completion. Read as their tools read them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kSources = GAITCAM_SOURCE_DIR;
const fs::path kPackage = kSources / "scenarios/code/package";

struct Instruction {
  std::string name, arguments;
};

/// Instructions of a container file: comments gone, continued lines joined.
std::vector<Instruction> ReadContainerFile(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<Instruction> instructions;
  std::string line, whole;
  while (std::getline(stream, line)) {
    if (line.starts_with("#") || (line.empty() && whole.empty())) continue;
    whole += line;
    if (whole.ends_with("\\")) {
      whole.back() = ' ';
      continue;
    }
    const size_t end = whole.find(' ');
    instructions.push_back({whole.substr(0, end), end == std::string::npos ? "" : whole.substr(end + 1)});
    whole.clear();
  }
  EXPECT_EQ(whole, "") << "the last line is continued";
  return instructions;
}

class ShippedFileTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kPackage)) GTEST_SKIP() << "the sources are not here: these are installed tests";
  }
  const TemporaryFolder temporary_;
};

TEST_F(ShippedFileTest, TheContainerFileFollowsItsGrammarAndCopiesWhatIsThere) {
  const std::map<std::string, std::regex> grammar = {
      {"FROM", std::regex(R"([a-z0-9./-]+(:[a-zA-Z0-9._-]+)?( AS [a-z]+)?)")},
      {"COPY", std::regex(R"((--from=[a-z]+ )?\S+( \S+)* \S+)")},
      {"RUN", std::regex(R"(\S.*)")},
      {"ENV", std::regex(R"([A-Z_]+=\S+( [A-Z_]+=\S+)*)")},
      {"WORKDIR", std::regex(R"(/\S*)")},
      {"ENTRYPOINT", std::regex(R"(\[("[^"]+")(, "[^"]+")*\])")},
      {"CMD", std::regex(R"(\[("[^"]+")(, "[^"]+")*\])")}};
  const std::vector<Instruction> instructions = ReadContainerFile(kPackage / "Containerfile");
  ASSERT_GE(instructions.size(), 6u);
  EXPECT_EQ(instructions.front().name, "FROM");
  std::vector<std::string> stages;
  for (const Instruction& i : instructions) {
    ASSERT_TRUE(grammar.count(i.name)) << i.name << ": no such instruction";
    EXPECT_TRUE(std::regex_match(i.arguments, grammar.at(i.name))) << i.name << " " << i.arguments;
    if (const size_t as = i.arguments.find(" AS "); i.name == "FROM" && as != std::string::npos)
      stages.push_back(i.arguments.substr(as + 4));
    if (i.name == "COPY" && i.arguments.starts_with("--from=")) {
      EXPECT_THAT(stages, testing::Contains(i.arguments.substr(7, i.arguments.find(' ') - 7)));
    }
    if (i.name == "RUN") {
      const ProgramResult parsed = RunShell("bash -n -c '" + i.arguments + "'", temporary_.path());
      EXPECT_EQ(parsed.exit_code, 0) << i.arguments << "\n" << parsed.err;
    }
  }
}

TEST_F(ShippedFileTest, TheWorkflowsAreYamlAndUseThePackage) {
  if (RunShell("/usr/bin/python3 -c 'import yaml'", temporary_.path()).exit_code != 0)
    GTEST_SKIP() << "no python3-yaml on this machine";
  const std::string text = ReadText(kSources / "results/check.md");
  const std::regex block("```yaml\n([^`]*)```");
  int blocks = 0;
  for (std::sregex_iterator i(text.begin(), text.end(), block), end; i != end; ++i, ++blocks) {
    temporary_.Write("block.yaml", (*i)[1]);
    const ProgramResult parsed = RunShell(
        "/usr/bin/python3 -c 'import json, yaml; print(json.dumps(yaml.safe_load(open(\"block.yaml\")), default=str))'",
        temporary_.path());
    EXPECT_EQ(parsed.exit_code, 0) << parsed.err;
    EXPECT_THAT(parsed.out, HasSubstr("gaitcam package"));
    EXPECT_THAT(parsed.out, HasSubstr("apt-get install -y --no-install-recommends ./gaitcam.deb"));
    EXPECT_THAT(parsed.out, HasSubstr("gaitcam check smoke"));
  }
  EXPECT_EQ(blocks, 2);
}

TEST_F(ShippedFileTest, CompletionInBashAsksTheProgram) {
  fs::create_directories(temporary_.path() / "bin");
  temporary_.Write("bin/gaitcam",
                   "#!/bin/sh\nGAITCAM_DATA=" + TestData().string() + " exec " + Program() + " \"$@\"\n");
  fs::permissions(temporary_.path() / "bin/gaitcam", fs::perms(0755));
  const auto complete = [&](const std::string& words, int at) {
    return RunShell("PATH=$PWD/bin:$PATH; bash -c '. " + (kPackage / "completion.bash").string() + "; COMP_WORDS=(" +
                        words + "); COMP_CWORD=" + std::to_string(at) + "; _gaitcam; echo \"${COMPREPLY[*]}\"'",
                    temporary_.path())
        .out;
  };
  EXPECT_EQ(complete("gaitcam ru", 1), "run\n");
  EXPECT_EQ(complete("gaitcam run --see", 2), "--seed\n");
  EXPECT_EQ(complete("gaitcam run quick", 2), "quickstart\n");
  EXPECT_EQ(complete("gaitcam run ./", 2), "\n");
}

}  // namespace
}  // namespace gaitcam
