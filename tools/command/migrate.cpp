// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma migrate: a scene in SOFA's dialect as a native one that gives the same numbers.
#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/output_file.h"
#include "framework/scene/text.h"
#include "tools/command/session.h"
#include "tools/command/sofa_runs.h"
#include "tools/command/source_layout.h"
#include "tools/session/xml_text.h"

namespace stroma::command {
namespace {

const Manual migrate_manual{
    "stroma migrate SCENE [-o FILE] [options]",
    "Writes a scene in SOFA's dialect as a native one: includes and prefabs spliced in, links absolute, SOFA's defaults and "
    "ways\nwritten out as attributes. It gives the same numbers. Comments, blank lines and the order of parts are kept; what "
    "has no\neffect is not. With --without-quirk a way of SOFA is left out, and the result differs by what it did.",
    "  stroma migrate liver.scn -o liver.xml\n  stroma migrate liver.scn --without-quirk cg-threshold\n"};

/// The native scene, with file names that start at `folder`.
class Writer {
 public:
  Writer(Session& session, const Scene& scene, fs::path folder)
      : session_(session), scene_(scene.description), folder_(std::move(folder)), layout_(scene.description) {
    for (const Problem& problem : scene.diagnostics.problems())
      if (problem.path == dialect_note) ways_ = problem.message;
  }

  std::string text() {
    std::string made = fmt::format("Made from {} by stroma migrate.", fs::path(scene_.file).filename().string());
    if (const auto list = ways_.find("): "); list != std::string::npos)
      made += " It has SOFA's ways as attributes: " + ways_.substr(list + 3);
    for (auto at = made.find("--"); at != std::string::npos; at = made.find("--")) made.replace(at, 2, "- ");
    text_ = fmt::format("<?xml version=\"1.0\"?>\n<!-- {} -->\n", made);
    write(scene_.root, 0);
    writeLines(layout_.atEnd({scene_.root.where.file, 0, 0}), "");
    return text_;
  }

 private:
  void write(const NodeDescription& node, int depth) {
    const std::string indent(std::size_t(2 * depth), ' ');
    writeLines(layout_.before(node.where), indent);
    startTag(indent + "<Node");
    for (const AttributeDescription& attribute : node.attributes) write(attribute.name, attribute.value);
    text_ += line_ + ">\n";
    // components and nodes as they stood, where they are of one file
    auto component = node.components.begin();
    for (const NodeDescription& child : node.children) {
      for (; component != node.components.end() && !SourceLayout::precedes(child.where, component->where); ++component)
        write(*component, indent + "  ");
      write(child, depth + 1);
    }
    for (; component != node.components.end(); ++component) write(*component, indent + "  ");
    writeLines(layout_.atEnd(node.where), indent + "  ");
    text_ += indent + "</Node>\n";
  }
  void write(const ComponentDescription& component, const std::string& indent) {
    writeLines(layout_.before(component.where), indent);
    startTag(indent + "<" + component.type);
    for (const AttributeDescription& attribute : component.attributes) write(attribute.name, placed(component, attribute));
    text_ += line_ + "/>\n";
  }
  void writeLines(const std::vector<std::string>& lines, const std::string& indent) {
    for (const std::string& line : lines) text_ += line.empty() ? "\n" : indent + line + "\n";
  }
  void startTag(const std::string& text) {
    line_ = text;
    continued_ = std::string(text.find('<') + 4, ' ');
  }
  /// On a new line where the tag grows too long.
  void write(const std::string& name, const std::string& value) {
    constexpr std::size_t widest = 130;
    std::string one_line = value;
    for (const char space : {'\n', '\r', '\t'}) std::ranges::replace(one_line, space, ' ');
    const std::string word = name + "=\"" + xmlText(one_line) + "\"";
    if (line_.size() + word.size() > widest && line_.find_first_not_of(' ') + 1 < line_.size() && line_.find('=') != line_.npos) {
      text_ += line_ + "\n";
      line_ = continued_ + word;
    } else {
      line_ += " " + word;
    }
  }

  /// A file that is read, by its way from the new scene.
  std::string placed(const ComponentDescription& component, const AttributeDescription& attribute) {
    if (!session_.modules().provide(component.type)) return attribute.value;
    const auto probe = session_.factory().make(component.type);
    const Data* data = probe ? probe->data().find(attribute.name) : nullptr;
    if (!data || !data->isInputFile() || trimmed(attribute.value).starts_with("@")) return attribute.value;
    const std::string found =
        findFileIn(std::string(trimmed(attribute.value)), component.folder, scene_.data_paths, nullptr);
    std::error_code none;
    return found.empty() ? attribute.value : fs::relative(found, folder_, none).string();
  }

  Session& session_;
  const SceneDescription& scene_;
  fs::path folder_;
  SourceLayout layout_;
  std::string ways_, text_;
  std::string line_, continued_;  ///< the tag that is written, and how its further lines begin
};

CommandLine migrateLine() {
  OptionList options("options");
  options.add_options()("output,o", po::value<std::string>()->value_name("FILE"), "write there instead of to the terminal");
  addSceneOptions(options);
  return {migrate_manual, options, {"SCENE"}};
}

int migrate(const Arguments& arguments) {
  const auto values = parseOptions(migrateLine(), arguments);
  if (!values) return exit_done;
  const std::string file = required(*values, "SCENE", migrate_manual);
  std::string output = textOf(*values, "output");
  if (output == "-") output.clear();  // the terminal
  if (output.ends_with(".scn"))
    throw UsageError(output + ": a file of this ending is one of SOFA's scenes: expected another one, as .xml");
  Session session;
  configure(session, *values);
  // whatever is wrong with it is said, and nothing is written
  const Simulation& simulation = session.load(file, {{"/", "dialect", "sofa"}});
  reportProblems(simulation.scene(), false);
  const fs::path folder = output.empty() ? fs::path(".") : fs::absolute(output).parent_path();
  const std::string text = Writer(session, simulation.scene(), folder).text();
  if (output.empty())
    fmt::print("{}", text);
  else
    writeWholeFile(output, text);
  return exit_done;
}

}  // namespace

const Subcommand migrate_command{"migrate", "write a scene of SOFA as a native one that gives the same numbers",
                                 Group::scenes, migrate, migrateLine};

}  // namespace stroma::command
