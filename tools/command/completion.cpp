// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma completion prints the script of a shell; stroma __complete answers it. The scripts know nothing of options: all
// that a shell offers comes from the tables of the subcommands.
#include "tools/command/completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "framework/scene/modules.h"
#include "tools/command/words.h"

namespace stroma::command {
namespace {

using CandidateKind = Candidate::Kind;
using Option = po::option_description;

/// The name of a value in help: of "[=FILE(=-)]" FILE.
std::string valueName(const Option& option) {
  std::string name = option.semantic()->name();
  if (name.starts_with("[=")) name = name.substr(2, name.find_first_of("(]", 2) - 2);
  return name.substr(0, name.find(" ("));
}

bool takesValue(const Option& option) { return option.semantic()->max_tokens() > 0; }
bool needsValue(const Option& option) { return option.semantic()->min_tokens() > 0; }

/// The option that a word on the line names, without what follows "=".
const Option* optionOf(const OptionList& options, const std::string& word) {
  if (word.size() < 2 || word[0] != '-') return nullptr;
  const std::string name = word.substr(0, word.find('='));
  for (const auto& option : options.options())
    if (name == "--" + option->long_name() ||
        name == option->canonical_display_name(po::command_line_style::allow_dash_for_short))
      return option.get();
  return nullptr;
}

/// Only letters and marks that mean nothing to any shell. A scene of somebody else may have other names; they are not
/// offered, whatever a shell would do with them.
bool isPlain(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) {
    return (c < 0x80 && std::isalnum(c)) || std::string_view("_.:+-/=@,%").find(char(c)) != std::string_view::npos;
  });
}

/// Without control characters, in ASCII and of UTF-8: terminals obey them.
std::string withoutControls(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]),
               next = static_cast<unsigned char>(text[std::min(i + 1, text.size() - 1)]);
    if (c < 0x20 || c == 0x7f) text[i] = ' ';
    if (c == 0xc2 && next < 0xa0) text.replace(i, 2, " ");
  }
  return text;
}

/// Up to the end of its first part: descriptions stand beside the words.
std::string briefly(const std::string& text) { return text.substr(0, text.find_first_of(";(\n")); }

/// What is on the line before the cursor.
struct Line {
  std::vector<std::string> positions;  ///< positional arguments
  const Option* open = nullptr;        ///< the option whose value is at the cursor
};

Line read(const CommandLine& command, const std::vector<std::string>& words) {
  Line line;
  for (std::size_t i = 1; i + 1 < words.size(); ++i) {
    const Option* option = optionOf(command.options, words[i]);
    if (!option && !words[i].starts_with('-')) line.positions.push_back(words[i]);
    if (!option || !needsValue(*option) || words[i].find('=') != std::string::npos) continue;
    if (i + 2 == words.size()) line.open = option;
    ++i;  // its value
  }
  return line;
}

std::vector<Candidate> subcommandNames() {
  std::vector<Candidate> list;
  for (const Subcommand* one : subcommands())
    if (one->group != Group::hidden) list.push_back({one->name, one->purpose});
  return list;
}

std::vector<Candidate> optionNames(const OptionList& options) {
  std::vector<Candidate> list{{"--help", "print the options and examples"}};
  for (const auto& option : options.options())
    list.push_back({"--" + option->long_name(), briefly(option->description())});
  return list;
}

/// From the index, without opening a module.
std::vector<Candidate> componentNames() {
  Factory factory;
  const Modules modules(factory);
  std::vector<Candidate> list;
  for (const auto& entry : modules.index()) list.push_back({std::string(entry.type), std::string(entry.help)});
  return list;
}

void addTopics(std::vector<Candidate>& list) {
  for (const Topic& topic : topics())
    if (topic.name.find(' ') == std::string::npos)
      list.push_back({topic.name, topic.is_missing ? "topic: not yet" : "topic"});
}

std::vector<Candidate> valuesOf(const Option& option, const Line& line, const std::string& typed) {
  const std::string name = valueName(option);
  if (name.starts_with("PATH."))
    return line.positions.empty() ? std::vector<Candidate>{} : settings(line.positions[0], typed);
  return candidatesFor(name);
}

std::vector<Candidate> atCursor(const std::vector<std::string>& words) {
  const std::string& typed = words.back();
  if (words.size() == 1) {
    auto list = subcommandNames();
    for (const char* option : {"--help", "--version"}) list.push_back({option, ""});
    return list;
  }
  const Subcommand* subcommand = findSubcommand(words[0]);
  if (!subcommand) return {};
  const CommandLine command = subcommand->line();
  const Line line = read(command, words);
  if (line.open) return valuesOf(*line.open, line, typed);
  if (const auto equals = typed.find('='); typed.starts_with("--") && equals != std::string::npos) {
    const Option* option = optionOf(command.options, typed);
    if (!option || !takesValue(*option)) return {};
    auto list = valuesOf(*option, line, typed.substr(equals + 1));
    for (Candidate& candidate : list)
      if (candidate.kind == CandidateKind::word || candidate.kind == CandidateKind::start)
        candidate.text = typed.substr(0, equals + 1) + candidate.text;
    return list;
  }
  if (typed.starts_with("-")) return optionNames(command.options);
  if (line.positions.size() < command.positions.size()) return candidatesFor(command.positions[line.positions.size()]);
  return {};
}

}  // namespace

std::vector<Candidate> candidatesFor(const std::string& name) {
  static const std::map<std::string, std::string, std::less<>> meanings{
      {"SCENE", "*.xml *.scn *.py"},
      {"INPUT", "*.nii *.nii.gz *.mhd *.mha *.vti *.obj *.stl *.vtk *.vtp"},
      {"MESH", "*.msh *.vtu"},
      {"SHELL", "bash|zsh|fish"},
      {"FILE", "*"},
      {"LIST", "*"},
  };
  if (name == "NAME...") {
    auto list = componentNames();
    list.push_back({"scene", "the file format"});
    addTopics(list);
    return list;
  }
  if (name == "WORD...") {
    std::vector<Candidate> list;
    addTopics(list);
    return list;
  }
  if (name == "SUBCOMMAND") return subcommandNames();
  if (name == "DIR" || name == "FOLDER") return {{"", "", CandidateKind::folders}};
  if (name.starts_with("FILE.")) return {{"*" + name.substr(4), "", CandidateKind::files}};
  const auto found = meanings.find(name);
  const std::string meaning = found == meanings.end() ? name : found->second;
  if (meaning.starts_with('*')) return {{meaning, "", CandidateKind::files}};
  if (meaning.find('|') == std::string::npos) return {};  // a number, a text
  std::vector<Candidate> list;
  for (std::size_t at = 0; at <= meaning.size();) {
    const std::size_t end = std::min(meaning.find('|', at), meaning.size());
    list.push_back({meaning.substr(at, end - at), ""});
    at = end + 1;
  }
  return list;
}

std::vector<Candidate> complete(const std::vector<std::string>& words) {
  if (words.empty()) return {};
  try {
    std::vector<Candidate> list = atCursor(words);
    std::erase_if(list, [&](const Candidate& candidate) {
      return (candidate.kind == CandidateKind::word || candidate.kind == CandidateKind::start) &&
             !(candidate.text.starts_with(words.back()) && isPlain(candidate.text));
    });
    return list;
  } catch (const std::exception&) {
    return {};  // whoever presses a key wants no sentence in the middle of the line
  }
}

namespace {

/// One line per candidate: its kind, its text, a tab and its description. `=` a word, `+` a beginning, `f` files, `d` folders.
void print(const Candidate& candidate) {
  static constexpr const char* marks = "=+fd";
  fmt::print("{}{}\t{}\n", marks[int(candidate.kind)], candidate.text, withoutControls(candidate.description));
}

CommandLine hiddenLine() { return {{}, OptionList("options"), {}}; }

int answerShell(const Arguments& words) {
  for (const Candidate& candidate : complete(words)) print(candidate);
  return exit_done;
}

const Manual completion_manual{
    "stroma completion bash|zsh|fish",
    "Prints the script that lets a shell complete subcommands, options with what they do, values, scenes, names of\n"
    "components, and --set from the scene on the line. An installed Stroma needs none: its scripts lie where the "
    "shells\n"
    "look. They ask the command itself, so that they never grow old.",
    "  source <(stroma completion bash)                   in ~/.bashrc\n"
    "  source <(stroma completion zsh)                    in ~/.zshrc, after compinit\n"
    "  stroma completion fish | source                    in ~/.config/fish/config.fish\n"};

CommandLine completionLine() { return {completion_manual, OptionList("options"), {"SHELL"}}; }

int printScript(const Arguments& arguments) {
  const auto values = parseOptions(completionLine(), arguments);
  if (!values) return exit_done;
  const std::string shell = required(*values, "SHELL", completion_manual);
  const std::string_view script = completionScript(shell);
  if (script.empty()) throw UsageError(fmt::format("there is no script for '{}' (expected bash, zsh or fish)", shell));
  fmt::print("{}", script);
  return exit_done;
}

}  // namespace

const Subcommand completion_command{"completion", "print the script that completes the command in a shell",
                                    Group::command, printScript, completionLine};
const Subcommand complete_command{"__complete", "", Group::hidden, answerShell, hiddenLine};

}  // namespace stroma::command
