// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma man: the pages for `man`, made of the same tables as --help. The build writes them all.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>

#include "framework/scene/output_file.h"
#include "tools/command/help.h"
#include "tools/command/markdown.h"
#include "tools/command/options.h"
#include "tools/command/words.h"

namespace stroma::command {
namespace {

struct Page {
  std::string name;  ///< "stroma-run"
  int section = 1;
  std::string text;

  std::string file() const { return fmt::format("{}.{}", name, section); }
};

/// The date of a page is that of the build's source, so that two builds of one source are equal.
constexpr const char* page_date = STROMA_PAGE_DATE;

std::string head(const std::string& name, int section, const std::string& purpose) {
  std::string title = name;
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  return fmt::format(".TH {} {} {} \"Stroma {}\" \"Stroma\"\n.SH NAME\n{}\n", escaped(title), section, page_date,
                     STROMA_VERSION, brokenForTroff(escaped(name) + " \\- " + escaped(purpose)));
}

/// "  3    no result" to ("3", "no result"); an empty name where a line is none of a list.
std::pair<std::string, std::string> listed(const std::string& line) {
  const auto start = line.find_first_not_of(' '), end = line.find("  ", start);
  if (start != 2 || end == std::string::npos || line.substr(start, end - start).find(' ') != std::string::npos)
    return {};
  return {line.substr(start, end - start), line.substr(line.find_first_not_of(' ', end))};
}

/// The text of --help as troff has it: paragraphs are filled, indented lines stay as they are, and a list of names with
/// what they mean, such as exit codes, becomes one.
class HelpText {
 public:
  std::string read(std::string_view text) {
    std::istringstream in{std::string(text)};
    for (std::string line; std::getline(in, line);) take(line);
    close();
    return std::move(out_);
  }

 private:
  enum class Mode { none, paragraph, item, lines };

  void take(const std::string& line) {
    if (line.empty()) return close();
    const bool is_indented = line.starts_with("  ");
    if (const auto [name, meaning] = listed(line); !name.empty()) {
      close();
      out_ += ".TP\n" + escaped(name) + "\n";
      mode_ = Mode::item, text_ = meaning;
    } else if (is_indented && mode_ == Mode::item) {
      text_ += line;
    } else if (is_indented) {
      if (mode_ != Mode::lines) {
        close();
        out_ += ".RS 2\n.nf\n";
        mode_ = Mode::lines;
      }
      out_ += escaped(line.substr(2)) + "\n";
    } else {
      if (mode_ != Mode::paragraph) close();
      mode_ = Mode::paragraph, (text_ += ' ') += line;
    }
  }

  void close() {
    if (mode_ == Mode::lines) out_ += ".fi\n.RE\n";
    if (mode_ == Mode::paragraph && has_paragraph_) out_ += ".PP\n";
    if (mode_ == Mode::paragraph) has_paragraph_ = true;
    if (!text_.empty()) out_ += brokenForTroff(escaped(text_)) + "\n";
    mode_ = Mode::none, text_.clear();
  }

  std::string out_, text_;
  Mode mode_ = Mode::none;
  bool has_paragraph_ = false;
};

std::string filled(std::string_view text) { return HelpText().read(text); }

std::string optionText(const po::option_description& option) {
  const std::string names = option.format_name(), value = option.format_parameter();
  std::string short_name, long_name = "--" + option.long_name();
  if (names.starts_with("-") && !names.starts_with("--")) short_name = names.substr(0, 2);
  std::string out = ".TP\n";
  if (!short_name.empty()) out += "\\fB" + escaped(short_name) + "\\fP, ";
  out += "\\fB" + escaped(long_name) + "\\fP";
  if (!value.empty()) out += " \\fI" + escaped(value) + "\\fP";
  return out + "\n" + brokenForTroff(escaped(option.description())) + "\n";
}

std::string seeAlso() {
  std::vector<std::string> names{"\\fBstroma\\fP(1)", "\\fBstroma\\-scene\\fP(5)"};
  return fmt::format(".SH SEE ALSO\n{}\n", fmt::join(names, ",\n"));
}

Page pageOf(const Subcommand& subcommand) {
  const CommandLine line = subcommand.line();
  Page page{fmt::format("stroma-{}", subcommand.name), 1, {}};
  page.text = head(page.name, 1, subcommand.purpose);
  page.text += ".SH SYNOPSIS\n\\fB" + escaped(line.manual.usage) + "\\fP\n";
  page.text += ".SH DESCRIPTION\n" + filled(line.manual.purpose);
  page.text += ".SH OPTIONS\n";
  for (const auto& option : line.options.options()) page.text += optionText(*option);
  page.text += ".TP\n\\fB\\-h\\fP, \\fB\\-\\-help\\fP\nprint the options and examples\n";
  page.text += ".SH EXAMPLES\n" + filled(line.manual.examples);
  page.text += seeAlso();
  return page;
}

std::string tagged(const std::string& tag, const std::string& text) {
  return ".TP\n\\fB" + escaped(tag) + "\\fP\n" + brokenForTroff(escaped(text)) + "\n";
}

Page overview() {
  Page page{"stroma", 1, head("stroma", 1, "soft tissue from an XML scene")};
  page.text += ".SH SYNOPSIS\n\\fBstroma\\fP \\fISUBCOMMAND\\fP ...\n.SH DESCRIPTION\n";
  page.text +=
      brokenForTroff(escaped(
          "Stroma simulates soft tissue. A scene in XML names a mesh, a material, loads and a solver; the command runs "
          "it "
          "and writes results. Each subcommand has a page of its own, as in stroma-run(1), and --help with examples.\n"
          "The file format is in stroma-scene(5); `stroma doc NAME` prints the page of a component or of a topic.")) +
      "\n";
  for (const auto& [group, title] : groupNames()) {
    page.text += fmt::format(".SS {}\n", escaped(title));
    for (const Subcommand* subcommand : subcommands())
      if (subcommand->group == group) page.text += tagged(subcommand->name, subcommand->purpose);
  }
  page.text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : std::initializer_list<std::pair<const char*, const char*>>{
           {"0", "done"},
           {"1", "a comparison failed"},
           {"2", "bad input, or an output that cannot be written; nothing was run"},
           {"3",
            "no result: the simulation diverged, statics found no equilibrium, or a position constraint was violated; the last "
            "state is written and named"},
           {"4", "writing an output failed; all files are complete up to that point"},
           {"129", "ended by SIGHUP, with the last whole step"},
           {"130", "interrupted with Ctrl-C, likewise"},
           {"143", "ended by SIGTERM, likewise"}})
    page.text += tagged(code, meaning);
  page.text += ".SH ENVIRONMENT\n";
  for (const auto& [name, meaning] : std::initializer_list<std::pair<const char*, const char*>>{
           {"STROMA_MODULE_PATH", "folders of modules built outside of Stroma, with colons between"},
           {"STROMA_DATA_PATH, SOFA_DATA_PATH", "folders in which files of scenes are searched, after the scene's own"},
           {"STROMA_LEVEL", "a lower instruction set than the machine's best: x86-64-v4, x86-64-v3 or x86-64-v2"},
           {"XDG_CACHE_HOME", "where condensed solvers keep inverted matrices for a cacheFolder that starts with it"},
           {"DISPLAY, WAYLAND_DISPLAY", "with one of them, stroma view opens the browser"}})
    page.text += tagged(name, meaning);
  page.text += ".SH FILES\n";
  for (const auto& [name, meaning] : std::initializer_list<std::pair<const char*, const char*>>{
           {"SCENE.xml", "a scene, see stroma-scene(5)"},
           {"DIR/NAME.state.gz", "positions and velocities of a state, of stroma run --record DIR"},
           {"DIR/last.checkpoint", "the file from which --resume continues"},
           {"results/STEM/last/run.instants",
            "positions and velocities at a few times of a run without --record, below the current folder; stroma view "
            "and "
            "stroma picture open results/STEM/last"}})
    page.text += tagged(name, meaning);
  page.text += ".SH SEE ALSO\n";
  std::vector<std::string> names;
  for (const Subcommand* subcommand : subcommands())
    if (subcommand->group != Group::hidden) names.push_back(fmt::format("\\fBstroma\\-{}\\fP(1)", subcommand->name));
  names.emplace_back("\\fBstroma\\-scene\\fP(5)");
  page.text += fmt::format("{}\n", fmt::join(names, ",\n"));
  return page;
}

Page sceneFile() {
  Page page{"stroma-scene", 5, head("stroma-scene", 5, "the file format of scenes")};
  page.text += ".SH DESCRIPTION\n" + asMan(readMarkdown(scenePage()));
  page.text += ".SH SEE ALSO\n\\fBstroma\\fP(1),\n\\fBstroma\\-check\\fP(1),\n\\fBstroma\\-doc\\fP(1)\n";
  return page;
}

std::vector<Page> pages() {
  std::vector<Page> all{overview(), sceneFile()};
  for (const Subcommand* subcommand : subcommands())
    if (subcommand->group != Group::hidden) all.push_back(pageOf(*subcommand));
  return all;
}

const Manual man_manual{
    "stroma man [PAGE] [options]",
    "Shows a page of the manual: stroma, a subcommand, or scene for the file format. Where the output is no terminal,\n"
    "or there is no `man`, the page is printed as `man` reads it. An installed Stroma has them in share/man.",
    "  stroma man\n  stroma man run\n  stroma man scene | man -l -\n  stroma man --write share/man\n"};

CommandLine manLine() {
  OptionList options("options");
  options.add_options()("write", po::value<std::string>()->value_name("DIR"),
                        "write all pages there, in man1 and man5, and show none");
  return {man_manual, options, {"PAGE"}};
}

int writeAll(const std::string& folder) {
  const auto fileOf = [&folder](const Page& page) {
    return (std::filesystem::path(folder) / fmt::format("man{}", page.section) / page.file()).string();
  };
  const std::vector<Page> all = pages();
  for (const Page& page : all) checkWritable(fileOf(page), true);
  try {
    for (const Page& page : all) writeWholeFile(fileOf(page), page.text);
  } catch (const OutputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return exit_output_failed;
  }
  return exit_done;
}

/// False when there is no `man`.
bool showIn(const std::string& text) {
  if (!isatty(STDOUT_FILENO) || std::system("command -v man >/dev/null 2>&1") != 0) return false;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pager(popen("man -l -", "w"), pclose);
  return pager && std::fwrite(text.data(), 1, text.size(), pager.get()) == text.size();
}

int man(const Arguments& arguments) {
  const auto values = parseOptions(manLine(), arguments);
  if (!values) return exit_done;
  if (values->count("write")) {
    if (values->count("PAGE")) throw UsageError("--write writes all pages: leave the name out");
    return writeAll((*values)["write"].as<std::string>());
  }
  const std::string name = values->count("PAGE") ? (*values)["PAGE"].as<std::string>() : "stroma";
  const std::vector<Page> all = pages();
  const auto found =
      std::ranges::find_if(all, [&](const Page& page) { return page.name == name || page.name == "stroma-" + name; });
  if (found == all.end()) subcommandNamed(name);  // throws
  if (!showIn(found->text)) fmt::print("{}", found->text);
  return exit_done;
}

}  // namespace

const Subcommand man_command{"man", "show a page of the manual", Group::command, man, manLine};

}  // namespace stroma::command
