#include "scenarios/code/systems/served_system.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>

#include "algorithms/core/errors.h"
#include "scenarios/code/systems/frame_protocol.h"
#include "scenarios/code/systems/private_folder.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const SystemPlugin& LoadPlugin(const fs::path& library) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw BadInput(dlerror());
  const auto layout = reinterpret_cast<uint64_t (*)()>(dlsym(handle, "gaitcam_plugin_layout"));
  const auto plugin = reinterpret_cast<const void* (*)()>(dlsym(handle, "gaitcam_plugin"));
  if (layout == nullptr || plugin == nullptr) {
    throw BadInput(library.string() +
                   ": offers no system; it has to end with GAITCAM_SYSTEM_PLUGIN (algorithms/slam/plugin.h)");
  }
  if (layout() != PluginLayout()) {
    throw BadInput(library.string() + ": was built with headers of another gaitcam; build it again with this one's");
  }
  return *static_cast<const SystemPlugin*>(plugin());
}

namespace {

/// Standard output for answers alone.
class AnswerStream {
 public:
  AnswerStream() {
    std::fflush(stdout);
    file_ = fdopen(dup(STDOUT_FILENO), "w");
    dup2(STDERR_FILENO, STDOUT_FILENO);
  }
  ~AnswerStream() { std::fclose(file_); }
  AnswerStream(const AnswerStream&) = delete;
  AnswerStream& operator=(const AnswerStream&) = delete;

  void Say(const std::string& line) {
    std::fputs((line + "\n").c_str(), file_);
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
};

/// Reads the first line and makes the system. @returns none, and says why, if it refuses.
std::unique_ptr<System> Start(const std::string& line,
                              const std::function<std::unique_ptr<System>(const SystemSetup&)>& make,
                              std::unique_ptr<SharedFrames>& frames, AnswerStream& answers) {
  try {
    fs::path file;
    const SystemSetup setup = ReadStart(line, file);
    frames = std::make_unique<SharedFrames>(file);
    std::unique_ptr<System> system = make(setup);
    answers.Say(Json{{"ready", true}}.dump());
    return system;
  } catch (const BadInput& e) {
    answers.Say(Json{{"error", e.what()}}.dump());
    return nullptr;
  }
}

}  // namespace

int ServeSystem(const std::function<std::unique_ptr<System>(const SystemSetup&)>& make, bool acts) {
  AnswerStream answers;
  std::unique_ptr<SharedFrames> frames;
  std::unique_ptr<System> system;
  try {
    for (std::string line; std::getline(std::cin, line);) {
      const FrameEvent event = EventOf(line);
      if (event == FrameEvent::kStart) {
        system = Start(line, make, frames, answers);
        if (!system) return 0;
      } else if (!system) {
        throw BadInput("the first line has to be the start");
      } else if (event == FrameEvent::kFrame) {
        FrameAnswer answer{system->Track(ReadFrame(line, *frames)), FollowPath()};
        if (acts) answer.command = system->Command();
        answers.Say(AnswerMessage(answer));
      } else {
        answers.Say(FinalMessage(system->Finish()));
        return 0;
      }
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}

std::string PluginInfoText(const SystemInfo& info) {
  Json json{{"name", info.name}, {"description", info.description}, {"acts", info.acts}};
  json["needs"] = Json::array();
  for (const SensorNeed need : info.needs) json["needs"].push_back(std::string(ToWord(need)));
  json["options"] = Json::array();
  for (const FieldInfo& option : info.options) {
    json["options"].push_back({{"key", option.key},
                               {"default", option.default_value.text()},
                               {"unit", option.unit},
                               {"permitted", option.permitted},
                               {"words", option.words},
                               {"description", option.description}});
  }
  return json.dump();
}

namespace {

SystemInfo InfoOf(const Json& json) {
  SystemInfo info{json.at("name"), json.at("description"), {}, {}, json.at("acts")};
  for (const std::string word : json.at("needs")) {
    if (const auto need = FromWord<SensorNeed>(word)) info.needs.push_back(*need);
  }
  for (const Json& option : json.at("options")) {
    info.options.push_back({option.at("key"), OptionValue(option.at("default").get<std::string>()), option.at("unit"),
                            option.at("permitted"), option.at("words"), option.at("description")});
  }
  return info;
}

SystemInfo AskOnce(const fs::path& library, const std::vector<fs::path>& readable) {
  const PrivateFolder folder;
  const fs::path log = folder.path() / "log";
  std::vector<std::string> words = WordsToServe(library);
  words.emplace_back("--info");
  if (WhyNoSandbox().empty()) words = Sandboxed(words, {readable, {folder.path()}, folder.path()});
  Subprocess program(
      words,
      SubprocessStreams{.log = log, .max_memory_mb = ForeignMemory_mb(0), .max_processes = kMaxForeignProcesses});
  constexpr double kLimit_s = 60;
  const std::optional<Ending> ending = program.Wait(kLimit_s);
  const std::string said = LastLine(log);
  if (!ending) throw BadInput(library.string() + ": did not load within a minute");
  if (!ending->ok()) throw BadInput(said.empty() ? library.string() + ": " + ending->ToText() : said);
  try {
    return InfoOf(Json::parse(said));
  } catch (const nlohmann::json::exception&) {
    throw BadInput(library.string() + ": what its system is cannot be read: " + said);
  }
}

}  // namespace

SystemInfo AskPluginInfo(const fs::path& library, const std::vector<fs::path>& readable) {
  static std::mutex mutex;
  static std::map<std::pair<fs::path, fs::file_time_type>, SystemInfo> known;
  const std::lock_guard lock(mutex);
  const std::pair key(library, fs::last_write_time(library));
  const auto there = known.find(key);
  return there != known.end() ? there->second : known.emplace(key, AskOnce(library, readable)).first->second;
}

std::vector<std::string> WordsToServe(const fs::path& library) {
  const char* named = std::getenv("GAITCAM_PROGRAM");
  const fs::path program = named != nullptr ? fs::path(named) : fs::read_symlink("/proc/self/exe");
  return {program.string(), "serve", "--plugin", library.string()};
}

}  // namespace gaitcam
