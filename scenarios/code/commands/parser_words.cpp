#include "scenarios/code/commands/parser_words.h"

#include <algorithm>

#include "algorithms/core/did_you_mean.h"

namespace gaitcam {
namespace {

const CLI::App* GivenVerb(const CLI::App& app) {
  const std::vector<CLI::App*> given = app.get_subcommands();
  return given.empty() ? nullptr : given.back();
}

void AddOptionNames(const CLI::App& app, std::vector<std::string>& names) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
}

}  // namespace

std::vector<const CLI::App*> VisibleVerbs(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

const CLI::App* FindVerb(const CLI::App& app, const std::string& name) {
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (verb->get_name() == name) return verb;
  }
  return nullptr;
}

std::vector<std::string> OptionNames(const CLI::App& app, const CLI::App& verb) {
  std::vector<std::string> names;
  AddOptionNames(verb, names);
  if (&app != &verb) AddOptionNames(app, names);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string NoSuchVerb(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* verb : VisibleVerbs(app)) known.push_back(verb->get_name());
  return word + ": no such verb; " + DidYouMean(word, known, "see gaitcam --help");
}

std::optional<std::string> UnknownVerb(const CLI::App& app, const std::vector<std::string>& words) {
  const auto word = std::find_if(words.begin(), words.end(), [](const auto& w) { return !w.starts_with("-"); });
  if (word == words.end() || FindVerb(app, *word) != nullptr) return std::nullopt;
  return *word;
}

std::string WhereToLook(const CLI::App& app) {
  const CLI::App* verb = GivenVerb(app);
  return verb == nullptr ? "see gaitcam --help" : "see gaitcam help " + verb->get_name();
}

std::string UnexpectedWord(const CLI::App& app) {
  const CLI::App* verb = GivenVerb(app);
  const std::string who = verb == nullptr ? "gaitcam" : verb->get_name(), help = WhereToLook(app);
  const std::vector<std::string> words = app.remaining(true);
  const auto word = std::find_if(words.begin(), words.end(), [](const auto& w) { return w.starts_with("-"); });
  if (word == words.end()) return who + ": " + (words.empty() ? "?" : words.front()) + " is a word too many; " + help;
  const std::string name = word->substr(0, word->find('='));
  return who + ": there is no option " + name + "; " +
         DidYouMean(name, OptionNames(app, verb == nullptr ? app : *verb), help);
}

std::vector<std::string> ShippedFoldersOf(const std::string& verb) {
  if (verb == "run") return {"scenarios"};
  if (verb == "record") return {"scenarios", "scenarios/matrices"};
  if (verb == "study") return {"scenarios/studies"};
  if (verb == "validate") return {"scenarios", "scenarios/matrices", "scenarios/studies"};
  if (verb == "check") return {"scenarios/suites"};
  return {};
}

}  // namespace gaitcam
