#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "algorithms/core/did_you_mean.h"
#include "algorithms/core/errors.h"
#include "algorithms/core/field_list.h"
#include "algorithms/core/file_content.h"
#include "algorithms/slam/system.h"
#include "models/code/robots/robot.h"
#include "models/code/scenes/scene.h"
#include "models/code/yaml/yaml_reader.h"
#include "scenarios/code/commands/commands.h"
#include "scenarios/code/files/folders.h"
#include "scenarios/code/runs/terminal_text.h"
#include "scenarios/code/systems/chosen_system.h"

namespace gaitcam {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr size_t kColumns = 100;     // of a screen
constexpr size_t kNameColumns = 16;  // of names, after two blanks

Json JsonOf(const FieldInfo& option) {
  Json json;
  const OptionValue& value = option.default_value;
  if (const std::optional<double> number = value.AsNumber()) {
    json["default"] = *number;
  } else if (option.permitted == "true or false") {
    json["default"] = *value.AsFlag();
  } else {
    json["default"] = value.text();
  }
  if (!option.unit.empty()) json["unit"] = option.unit;
  json["permitted"] = option.permitted;
  if (!option.words.empty()) json["words"] = option.words;
  json["description"] = option.description;
  return json;
}

Json JsonOf(const SystemInfo& system) {
  Json json{{"description", system.description}, {"needs", Json::array()}};
  for (const SensorNeed need : system.needs) json["needs"].push_back(ToString(need));
  json["acts"] = system.acts;
  json["options"] = Json::object();
  for (const FieldInfo& option : system.options) json["options"][option.key] = JsonOf(option);
  return json;
}

Json JsonOf(const Robot& robot) {
  Json json{{"mass_kg", robot.TotalMass()}, {"gaits", Json::object()}};
  for (const auto& [name, gait] : robot.gaits) {
    for (const FieldInfo& option : ListFields(gait)) {
      json["gaits"][name][option.key] = *option.default_value.AsNumber();
    }
  }
  return json;
}

/// What a file's opening comment says, as one line. @throws BadInput.
std::string OpeningComment(const fs::path& file) {
  std::istringstream stream(FileContent(file));
  std::string text, line;
  while (std::getline(stream, line) && line.starts_with("# ")) text += (text.empty() ? "" : " ") + line.substr(2);
  return text;
}

Json SceneEntry(const std::string& name) {
  const fs::path file = ModelsFolder() / "scenes" / (name + ".yaml");
  return {{"description", OpeningComment(file)}, {"file", file.string()}};
}

Json ScenarioEntry(const std::string& name) {
  const fs::path file = DataFolder() / "scenarios" / (name + ".yaml");
  return {{"description", LoadYaml(file).Child("description").text()}, {"file", file.string()}};
}

Json EntryOf(const std::string& kind, const std::string& name) {
  if (kind == "robots") return JsonOf(ReadRobot(name, ModelsFolder()));
  if (kind == "scenes") return SceneEntry(name);
  if (kind == "systems") return JsonOf(InfoOf(ParseSystemChoice(name)));
  return ScenarioEntry(name);
}

Json EntriesOf(const std::string& kind) {
  Json entries = Json::object();
  for (const std::string& name : ListedNames(kind)) entries[name] = EntryOf(kind, name);
  return entries;
}

/// At most `columns` of `text`, cut between words.
std::string Shortened(const std::string& text, size_t columns) {
  if (text.size() <= columns) return text;
  return text.substr(0, text.rfind(' ', columns - 3)) + "...";
}

/// What a list says of one robot, scene, system or scenario in a line.
std::string InOneLine(const std::string& kind, const Json& entry) {
  if (kind != "robots") {
    const std::string description = entry["description"];
    return kind == "scenes" ? description.substr(0, description.find(". ")) : description;
  }
  std::string gaits;
  for (const auto& [name, options] : entry["gaits"].items()) gaits += (gaits.empty() ? "; gaits " : ", ") + name;
  return fmt::format("{:.2f} kg{}", entry["mass_kg"].get<double>(), gaits);
}

void PrintLines(const std::string& kind, const Json& entries) {
  for (const auto& [name, entry] : entries.items()) {
    const size_t left = std::max(name.size(), kNameColumns) + 3;
    fmt::print("  {:<{}} {}\n", name, kNameColumns, Shortened(InOneLine(kind, entry), kColumns - left));
  }
}

void PrintHeading(std::string kind) {
  kind[0] = char(std::toupper(kind[0]));
  fmt::print("{}\n", Bold(kind, stdout));
}

/// "  a, b, c", as many lines as it takes.
void PrintNames(const std::vector<std::string>& names) {
  std::string line = " ";
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string word = " " + names[i] + (i + 1 < names.size() ? "," : "");
    if (line.size() + word.size() > kColumns) {
      fmt::print("{}\n", line);
      line = " ";
    }
    line += word;
  }
  fmt::print("{}\n", line);
}

/// Fits a screen: scenarios, of which there are most, by their names alone.
void PrintAll() {
  for (const std::string& kind : ListedKinds()) {
    PrintHeading(kind);
    if (kind == "scenarios") {
      PrintNames(ListedNames(kind));
    } else {
      PrintLines(kind, EntriesOf(kind));
    }
  }
  fmt::print("\nMore of one: gaitcam list systems mobif_vo; what scenarios do: gaitcam list scenarios\n");
}

/// "  ratio = 0.8 (a number from 0.1 to 1): best over second-best distance".
void PrintOption(const std::string& name, const Json& option) {
  const Json& value = option["default"];
  std::string text = name + " = ";
  text += value.is_number()   ? fmt::format("{:g}", value.get<double>())
          : value.is_string() ? value.get<std::string>()
                              : value.dump();
  if (option.contains("unit")) text += " " + option["unit"].get<std::string>();
  text += " (" + option["permitted"].get<std::string>() + ")";
  const std::string description = option["description"];
  fmt::print("  {}{}{}\n", text, description.empty() ? "" : ": ", description);
}

void PrintSystem(const Json& system) {
  std::string needs;
  for (const auto& need : system["needs"]) needs += (needs.empty() ? "" : ", ") + need.get<std::string>();
  if (!needs.empty()) fmt::print("needs {}\n", needs);
  if (system["acts"].get<bool>()) fmt::print("commands the robot\n");
  if (!system["options"].empty()) PrintHeading("options");
  for (const auto& [key, option] : system["options"].items()) PrintOption(key, option);
}

/// A row per parameter, a column per gait.
void PrintGaits(const Json& gaits) {
  if (gaits.empty()) return;
  std::string heading = fmt::format("  {:<24}", "");
  for (const auto& [name, gait] : gaits.items()) heading += fmt::format("{:>8}", name);
  PrintHeading("gaits");
  fmt::print("{}\n", heading);
  for (const FieldInfo& option : ListFields(GaitOptions())) {
    fmt::print("  {:<24}", option.key);
    for (const auto& [name, gait] : gaits.items()) fmt::print("{:>8.4g}", gait[option.key].get<double>());
    fmt::print("  {}\n", option.description);
  }
}

void PrintEntry(const std::string& kind, const std::string& name, const Json& entry) {
  if (kind == "robots") {
    fmt::print("{}: {:.2f} kg\n", Bold(name, stdout), entry["mass_kg"].get<double>());
    return PrintGaits(entry["gaits"]);
  }
  fmt::print("{}: {}\n", Bold(name, stdout), entry["description"].get<std::string>());
  if (kind == "systems") return PrintSystem(entry);
  fmt::print("{}\n", entry["file"].get<std::string>());
}

/// A shared library, a file, or a map: somebody else's.
bool IsForeignSystem(const ListArguments& arguments) {
  const std::string& name = arguments.name;
  return arguments.kind == "systems" && (name.ends_with(".so") || name.ends_with(".yaml") || name.starts_with("{"));
}

/// @throws BadInput naming the nearest kind or name that there is.
void CheckWords(const ListArguments& arguments) {
  const auto check = [](const std::string& word, const std::vector<std::string>& known, const std::string& what) {
    if (std::find(known.begin(), known.end(), word) != known.end()) return;
    throw BadInput(fmt::format("list: there is no {} \"{}\"; {}", what, word, DidYouMean(word, known)));
  };
  if (arguments.kind.empty()) return;
  check(arguments.kind, ListedKinds(), "kind");
  if (arguments.name.empty() || IsForeignSystem(arguments)) return;
  check(arguments.name, ListedNames(arguments.kind), arguments.kind.substr(0, arguments.kind.size() - 1));
}

}  // namespace

const std::vector<std::string>& ListedKinds() {
  static const std::vector<std::string> kinds{"robots", "scenes", "systems", "scenarios"};
  return kinds;
}

std::vector<std::string> ListedNames(const std::string& kind) {
  if (kind == "robots") return ListRobots(ModelsFolder());
  if (kind == "scenes") return ListScenes(ModelsFolder());
  if (kind == "scenarios") return ShippedNames("scenarios");
  std::vector<std::string> names;
  if (kind == "systems") {
    for (const SystemInfo& system : ListSystems()) names.push_back(system.name);
  }
  return names;
}

int ListCommand(const ListArguments& arguments, const CommonOptions& common) {
  CheckWords(arguments);
  const auto& [kind, name] = arguments;
  if (common.json) {
    Json json;
    for (const std::string& each : ListedKinds()) {
      if (kind.empty()) json[each] = EntriesOf(each);
    }
    if (!kind.empty()) json = name.empty() ? EntriesOf(kind) : EntryOf(kind, name);
    fmt::print("{}\n", json.dump(2));
  } else if (kind.empty()) {
    PrintAll();
  } else if (name.empty()) {
    PrintLines(kind, EntriesOf(kind));
  } else {
    PrintEntry(kind, name, EntryOf(kind, name));
  }
  return 0;
}

}  // namespace gaitcam
