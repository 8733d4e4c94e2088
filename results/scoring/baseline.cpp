#include "results/scoring/baseline.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/core/json_whole.h"

namespace gaitcam {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "gaitcam.baseline.1";

const char* NameOf(RunState state) {
  return state == RunState::kScored ? "scored" : state == RunState::kNotScored ? "not_scored" : "crashed";
}

RunState StateOf(const std::string& name) {
  for (const RunState state : {RunState::kScored, RunState::kNotScored, RunState::kCrashed}) {
    if (name == NameOf(state)) return state;
  }
  throw BadInput("\"" + name + "\" is no status of a run; expected scored, not_scored or crashed");
}

Json ToJson(const MeasuredRun& run) {
  Json json{{"seed", run.seed}, {"hash", run.hash}, {"status", NameOf(run.state)}};
  if (!run.reason.empty()) json["reason"] = run.reason;
  json["values"] = Json::object();
  for (const auto& [name, value] : run.values) json["values"][name] = value;  // NaN becomes null
  for (const auto& [name, values] : run.history) json["history"][name] = values;
  return json;
}

MeasuredRun RunFrom(const Json& json) {
  MeasuredRun run;
  run.seed = WholeOf<uint64_t>(json.at("seed"), "seed");
  run.hash = json.at("hash").get<std::string>();
  run.state = StateOf(json.at("status").get<std::string>());
  run.reason = json.value("reason", "");
  for (const auto& [name, value] : json.at("values").items()) {
    run.values[name] = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  }
  if (!json.contains("history")) return run;
  for (const auto& [name, values] : json.at("history").items()) {
    for (const Json& value : values) {
      run.history[name].push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
    }
  }
  return run;
}

BaselineEntry EntryFrom(const Json& json) {
  BaselineEntry entry;
  entry.measured.scenario = json.at("scenario").get<std::string>();
  entry.measured.system = json.at("system").get<std::string>();
  for (const Json& line : json.at("resolved")) entry.resolved += line.get<std::string>() + "\n";
  for (const Json& run : json.at("runs")) {
    const MeasuredRun read = RunFrom(run);
    for (const MeasuredRun& other : entry.measured.runs) {
      if (other.seed == read.seed) throw BadInput("seed " + std::to_string(read.seed) + " is there twice");
    }
    entry.measured.runs.push_back(read);
  }
  return entry;
}

/// One run per line, so that a diff shows which moved.
std::string EntryText(const BaselineEntry& entry) {
  std::string text = "    {\"scenario\": " + Json(entry.measured.scenario).dump() +
                     ", \"system\": " + Json(entry.measured.system).dump() + ",\n     \"runs\": [";
  const char* separator = "\n";
  for (const MeasuredRun& run : entry.measured.runs) {
    text += separator + ("      " + ToJson(run).dump());
    separator = ",\n";
  }
  text += "],\n     \"resolved\": [";
  std::istringstream lines(entry.resolved);
  separator = "\n";
  for (std::string line; std::getline(lines, line);) {
    text += separator + ("      " + Json(line).dump());
    separator = ",\n";
  }
  return text + "]}";
}

}  // namespace

const BaselineEntry* Baseline::Find(const std::string& scenario, const std::string& system) const {
  for (const BaselineEntry& entry : entries) {
    if (entry.measured.scenario == scenario && entry.measured.system == system) return &entry;
  }
  return nullptr;
}

std::string BaselineToJson(const Baseline& baseline) {
  std::string text = "{\n";
  const std::vector<std::pair<const char*, std::string>> facts{{"schema", kSchema},
                                                               {"suite", baseline.suite},
                                                               {"program_version", baseline.program_version},
                                                               {"frames_fingerprint", baseline.frames_fingerprint},
                                                               {"renderer", baseline.renderer}};
  for (const auto& [key, value] : facts) text += "  \"" + std::string(key) + "\": " + Json(value).dump() + ",\n";
  text += "  \"entries\": [";
  const char* separator = "\n";
  for (const BaselineEntry& entry : baseline.entries) {
    text += separator + EntryText(entry);
    separator = ",\n";
  }
  return text + "]\n}\n";
}

Baseline ReadBaseline(const std::filesystem::path& file) {
  const std::optional<std::string> text = FindFileContent(file);
  if (!text) throw BadInput(file.string() + ": there is no such baseline; --update writes one");
  try {
    const Json json = Json::parse(*text);
    const std::string schema = json.at("schema").get<std::string>();
    if (schema != kSchema) {
      throw BadInput("schema \"" + schema + "\", where this program reads \"" + kSchema +
                     "\"; --update writes a new one");
    }
    Baseline baseline{
        json.at("suite"), json.at("program_version"), json.at("frames_fingerprint"), json.at("renderer"), {}};
    for (const Json& entry : json.at("entries")) baseline.entries.push_back(EntryFrom(entry));
    return baseline;
  } catch (const nlohmann::json::exception& e) {
    throw BadInput(file.string() + ": damaged: " + e.what());
  } catch (const BadInput& e) {
    throw BadInput(file.string() + ": " + e.what());
  }
}

}  // namespace gaitcam
