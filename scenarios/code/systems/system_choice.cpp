#include "scenarios/code/systems/system_choice.h"

#include <algorithm>
#include <set>

#include "algorithms/core/file_names.h"
#include "algorithms/io/checksum.h"
#include "models/code/yaml/yaml_reader.h"
#include "models/code/yaml/yaml_writer.h"
#include "scenarios/code/systems/sandbox.h"
#include "scenarios/code/systems/subprocess.h"

namespace gaitcam {
namespace fs = std::filesystem;

namespace {

void AddSettings(const OptionValue& node, const std::string& prefix, const std::vector<std::string>& except,
                 SystemSettings& settings) {
  for (const auto& entry : node.entries()) {
    if (prefix.empty() && std::find(except.begin(), except.end(), entry.key) != except.end()) continue;
    const OptionValue child = node.Child(entry.key);
    if (child.IsMap()) {
      AddSettings(child, prefix + entry.key + ".", except, settings);
    } else {
      if (!child.IsScalar()) child.Fail("expected a number or a word");
      settings[prefix + entry.key] = OptionValue(child.text());  // the system's errors name it, not the file
    }
  }
}

/// "my_slam" of [python3, -u, my_slam.py]: the first word that is no interpreter and no switch.
std::string NameOf(const std::vector<std::string>& words) {
  const std::string first = fs::path(words.front()).stem().string();
  const bool interprets = first.starts_with("python") || first == "sh" || first == "bash" || first == "env";
  for (size_t i = 1; interprets && i < words.size(); ++i) {
    if (!words[i].starts_with("-")) return fs::path(words[i]).stem().string();
  }
  return first;
}

void CheckWords(const OptionValue& node, const std::string& key, const std::vector<std::string>& words) {
  if (words.empty() || words.front().empty()) node.Child(key).Fail("expected a program and its arguments");
}

/// "my_slam" of "./libmy_slam.so".
std::string NameOfLibrary(const std::string& file) {
  const std::string name = fs::path(file).stem().string();
  return name.starts_with("lib") ? name.substr(3) : name;
}

void ReadPlugin(const OptionValue& node, SystemChoice& value) {
  std::vector<std::string> known = FieldKeys<PluginChoice>();
  internal::FieldReader reader{node};
  VisitFields(reader, value.plugin.emplace());
  known.push_back("name");
  value.settings = ReadSettings(node, known);
  value.name = NameOfLibrary(value.plugin->plugin);
  if (node.Has("name")) ReadOption(node.Child("name"), value.name);
}

void WriteSetting(YAML::Emitter& out, const OptionValue& value) {
  if (const std::optional<double> number = value.AsNumber()) {
    WriteYaml(out, *number);
  } else {
    WriteYaml(out, value.text());
  }
}

void WriteSettings(YAML::Emitter& out, const SystemSettings& settings) {
  for (const auto& [key, setting] : settings) {
    out << YAML::Key << key << YAML::Value;
    WriteSetting(out, setting);
  }
}

}  // namespace

SystemSettings ReadSettings(const OptionValue& node, const std::vector<std::string>& except) {
  SystemSettings settings;
  AddSettings(node, "", except, settings);
  return settings;
}

void ReadOption(const OptionValue& node, SystemSettings& value) {
  if (!node.IsMap()) node.Fail("expected a map of names and values");
  value = ReadSettings(node, {});
}

void ReadOption(const OptionValue& node, SystemChoice& value) {
  value = {};
  if (node.IsScalar() && node.text().ends_with(".so")) {
    value.plugin.emplace().plugin = node.text();
    value.name = NameOfLibrary(node.text());
    return;
  }
  if (node.IsScalar()) {
    ReadOption(node, value.name);
    return;
  }
  if (!node.IsMap()) node.Fail("expected the name of a system, or a map {name: ..., setting: ...}");
  if (node.Has("command")) {
    CommandChoice& command = value.command.emplace();
    ReadOption(node, command);
    CheckWords(node, "command", command.command);
    if (command.name.empty()) command.name = NameOf(command.command);
    value.name = command.name;
  } else if (node.Has("process")) {
    ProcessChoice& process = value.process.emplace();
    ReadOption(node, process);
    CheckWords(node, "process", process.process);
    if (process.name.empty()) process.name = NameOf(process.process);
    value.name = process.name;
  } else if (node.Has("plugin")) {
    ReadPlugin(node, value);
  } else {
    if (!node.Has("name"))
      node.Fail("expected the key `name` beside the settings, or `plugin`, `process` or `command`");
    ReadOption(node.Child("name"), value.name);
    value.settings = ReadSettings(node);
  }
}

void WriteYaml(YAML::Emitter& out, const SystemSettings& value) {
  out << YAML::BeginMap;
  WriteSettings(out, value);
  out << YAML::EndMap;
}

void WriteYaml(YAML::Emitter& out, const SystemChoice& value) {
  if (value.command) return WriteYaml(out, *value.command);
  if (value.process) return WriteYaml(out, *value.process);
  if (!value.plugin && value.settings.empty()) return WriteYaml(out, value.name);
  out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << value.name;
  if (value.plugin) {
    internal::YamlFieldWriter writer{out};
    VisitFields(writer, const_cast<PluginChoice&>(*value.plugin));  // the writer only reads
  }
  WriteSettings(out, value.settings);
  out << YAML::EndMap;
}

namespace {

/// Beside the file that says it, else below the working folder; nothing if it is neither. A folder is meant only where
/// the word has a "/": "tum" is a word.
std::optional<std::string> FindFile(const std::string& word, const fs::path& folder) {
  const bool may_be_folder = word.find('/') != std::string::npos;
  for (const fs::path& file : {folder / word, fs::path(word)}) {
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored) || (may_be_folder && fs::is_directory(file, ignored))) {
      return fs::absolute(file).lexically_normal().string();
    }
  }
  return std::nullopt;
}

/// A program with a "/" in its name is looked for beside the file, any other in PATH.
void ResolveProgram(const OptionValue& word, const fs::path& folder, std::string& program) {
  if (program.find('/') != std::string::npos) {
    program = FindFile(program, folder).value_or(program);
    if (!FindProgram(program)) word.Fail(program + ": there is no such program, or it may not be executed");
    return;
  }
  const std::optional<fs::path> found = FindProgram(program);
  if (!found) word.Fail(program + ": there is no such program in PATH; one beside this file is written ./" + program);
  program = fs::absolute(*found).string();
}

void ResolveWords(const OptionValue& list, const fs::path& folder, std::vector<std::string>& words) {
  ResolveProgram(list.Element(0), folder, words.front());
  for (size_t i = 1; i < words.size(); ++i) {
    if (const auto file = FindFile(words[i], folder)) words[i] = *file;
  }
}

void ResolveDepends(const OptionValue& node, const fs::path& folder, std::optional<std::vector<std::string>>& depends) {
  for (size_t i = 0; depends && i < depends->size(); ++i) {
    const OptionValue word = node.Child("depends").Element(i);
    const auto file = FindFile((*depends)[i], folder);
    if (!file) word.Fail((*depends)[i] + ": there is no such file or folder");
    (*depends)[i] = *file;
  }
}

void ResolveCommand(const OptionValue& node, const fs::path& folder, CommandChoice& choice) {
  const OptionValue list = node.Child("command");
  for (const char* needed : {"{dataset}", "{output}"}) {
    const auto has = [&](const std::string& word) { return word.find(needed) != std::string::npos; };
    if (choice.interface == CommandInterface::kPlaceholders &&
        std::none_of(choice.command.begin(), choice.command.end(), has)) {
      list.Fail(std::string("expected ") + needed + " in one of the arguments");
    }
  }
  ResolveWords(list, folder, choice.command);
  ResolveDepends(node, folder, choice.depends);
}

/// Words that are files; the program is the first of them.
void AddFiles(const std::vector<std::string>& words, const std::optional<std::vector<std::string>>& depends,
              std::vector<fs::path>& files) {
  std::error_code ignored;
  for (const std::string& word : words) {
    if (fs::path(word).is_absolute() && fs::exists(word, ignored)) files.emplace_back(word);
  }
  if (depends) files.insert(files.end(), depends->begin(), depends->end());
}

void CutFolders(std::vector<std::string>& words) {
  for (std::string& word : words) {
    if (fs::path(word).is_absolute()) word = fs::path(word).filename().string();
  }
}

/// Of a file; of a folder that of all files below it, with their names.
std::string Sha256Of(const fs::path& path) {
  if (!IsFolder(path)) return Sha256OfFile(path);
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files.insert(entry.path());
  }
  std::string text;
  for (const fs::path& file : files) text += file.lexically_relative(path).string() + " " + Sha256OfFile(file) + "\n";
  return Sha256(text);
}

}  // namespace

void ResolveFiles(const OptionValue& node, const fs::path& folder, SystemChoice& choice) {
  if (choice.command) ResolveCommand(node, folder, *choice.command);
  if (choice.process) {
    ResolveWords(node.Child("process"), folder, choice.process->process);
    ResolveDepends(node, folder, choice.process->depends);
  }
  if (choice.plugin) {
    const OptionValue word = node.IsMap() ? node.Child("plugin") : node;
    const auto file = FindFile(choice.plugin->plugin, folder);
    if (!file) word.Fail(choice.plugin->plugin + ": there is no such shared library");
    choice.plugin->plugin = *file;
    ResolveDepends(node, folder, choice.plugin->depends);
  }
}

SystemChoice ParseSystemChoice(const std::string& text, const std::vector<std::string>& sets) {
  const bool is_file = text.ends_with(".yaml");
  OptionValue root =
      is_file ? OptionValue::Map({{"system", {}, LoadYaml(text)}}, {}) : ParseYaml("system: " + text, "--system");
  if (!sets.empty() && root.Child("system").IsScalar()) {
    const char* const key = text.ends_with(".so") ? "plugin" : "name";
    root.Set("system", OptionValue::Map({{key, {}, root.Child("system")}}, {}));
  }
  for (const std::string& assignment : sets) SetOption(root, "system." + assignment);
  SystemChoice choice;
  ReadOption(root.Child("system"), choice);
  ResolveFiles(root.Child("system"), is_file ? fs::path(text).parent_path() : fs::path(), choice);
  return choice;
}

std::vector<fs::path> FilesOf(const SystemChoice& choice) {
  std::vector<fs::path> files;
  if (choice.command) AddFiles(choice.command->command, choice.command->depends, files);
  if (choice.process) AddFiles(choice.process->process, choice.process->depends, files);
  if (choice.plugin) AddFiles({choice.plugin->plugin}, choice.plugin->depends, files);
  return files;
}

SystemChoice WithoutFolders(SystemChoice choice) {
  const auto cut = [](auto& words, auto& depends) {
    CutFolders(words);
    if (depends) CutFolders(*depends);
  };
  if (choice.command) cut(choice.command->command, choice.command->depends);
  if (choice.process) cut(choice.process->process, choice.process->depends);
  if (choice.plugin) {
    choice.plugin->plugin = fs::path(choice.plugin->plugin).filename().string();
    if (choice.plugin->depends) CutFolders(*choice.plugin->depends);
  }
  return choice;
}

bool IsFingerprintComplete(const SystemChoice& choice) {
  const auto says = [](const auto& kind) { return kind && kind->depends; };
  return !choice.IsForeign() || says(choice.command) || says(choice.process) || says(choice.plugin) ||
         WhyNoSandbox().empty();
}

std::string FingerprintOf(const SystemChoice& choice) {
  if (!choice.IsForeign()) return "";
  std::string text;
  for (const fs::path& file : FilesOf(choice)) text += Sha256Of(file) + "\n";
  return Sha256(text);
}

}  // namespace gaitcam
