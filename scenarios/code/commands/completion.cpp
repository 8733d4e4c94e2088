#include "scenarios/code/commands/completion.h"

#include <algorithm>

#include "scenarios/code/commands/commands.h"
#include "scenarios/code/commands/parser_words.h"
#include "scenarios/code/files/folders.h"

namespace gaitcam {
namespace {

using Texts = std::vector<std::string>;

/// The words of a closed set, which the parser keeps in an option's type: "TEXT:{tum,euroc}".
Texts PermittedWords(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const size_t begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

/// The option of `verb` that `word` names and whose value comes next; null if it takes none.
const CLI::Option* AwaitingValue(const CLI::App& verb, const std::string& word) {
  if (!word.starts_with("-")) return nullptr;
  for (const CLI::Option* option : verb.get_options()) {
    if (option->check_name(word) && option->get_items_expected_max() > 0) return option;
  }
  return nullptr;
}

Texts VerbNames(const CLI::App& app) {
  Texts names;
  for (const CLI::App* verb : VisibleVerbs(app)) names.push_back(verb->get_name());
  return names;
}

/// @param given operands and options that stand before it.
Texts Operands(const CLI::App& app, const CLI::App& verb, const Texts& given) {
  const std::string& name = verb.get_name();
  if (name == "help") return VerbNames(app);
  if (name == "list") return given.empty() ? ListedKinds() : ListedNames(given.back());
  Texts words;
  for (const CLI::Option* option : verb.get_options()) {
    if (option->get_positional()) words = PermittedWords(*option);
  }
  for (const std::string& folder : ShippedFoldersOf(name)) {
    for (const std::string& shipped : ShippedNames(folder)) words.push_back(shipped);
  }
  return words;
}

Texts Candidates(const CLI::App& app, const Texts& before, bool option) {
  const auto is_verb = [](const std::string& word) { return !word.starts_with("-"); };
  const auto at = std::find_if(before.begin(), before.end(), is_verb);
  if (at == before.end()) return option ? OptionNames(app, app) : VerbNames(app);
  const CLI::App* verb = FindVerb(app, *at);
  if (verb == nullptr) return {};
  if (const CLI::Option* awaiting = AwaitingValue(*verb, before.back()))
    return awaiting->check_name("--system") ? ListedNames("systems") : PermittedWords(*awaiting);
  return option ? OptionNames(app, *verb) : Operands(app, *verb, Texts(at + 1, before.end()));
}

}  // namespace

Texts Completions(const CLI::App& app, const Texts& words) {
  if (words.empty()) return VerbNames(app);
  const std::string& current = words.back();
  Texts found = Candidates(app, Texts(words.begin(), words.end() - 1), current.starts_with("-"));
  std::erase_if(found, [&](const std::string& word) { return !word.starts_with(current); });
  return found;
}

}  // namespace gaitcam
