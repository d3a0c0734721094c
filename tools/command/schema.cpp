// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma schema: what editors complete and check scenes with.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "framework/scene/output_file.h"
#include "tools/command/schema_text.h"
#include "tools/command/session.h"

namespace stroma::command {
namespace {

const Manual schema_manual{
    "stroma schema [options]",
    "Prints a schema of scenes, made from the attributes of all components: editors complete and check with it. A "
    "scene\n"
    "names it on its outermost element:\n"
    "  <Node xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation=\"stroma.xsd\">\n"
    "`stroma check` knows more than a schema can say: links, files, what goes together.",
    "  stroma schema -o stroma.xsd\n  stroma schema --format rnc -o stroma.rnc\n"
    "  stroma schema --module ./springs.so -o stroma.xsd\n"};

/// Whether `file` begins as one of either format does.
bool isSchema(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string start(1024, '\0');
  in.read(start.data(), std::streamsize(start.size()));
  start.resize(std::size_t(in.gcount()));
  return start.find("<xs:schema ") != start.npos || start.find("\ndatatypes xsd = ") != start.npos;
}

/// -o takes the place of a schema, of an empty file or of none: a scene has the same ending.
void refuseToReplace(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) || std::filesystem::file_size(file, error) == 0) return;
  if (!isSchema(file))
    throw UsageError(
        fmt::format("{} is there and is no schema: it stays as it is. Give another name, or remove it", file));
}

CommandLine schemaLine() {
  OptionList options("options");
  options.add_options()  //
      ("format", po::value<std::string>()->value_name("xsd|rnc")->default_value("xsd"),
       "xsd: W3C XML Schema 1.0; rnc: RELAX NG, compact syntax")                        //
      ("output,o", po::value<std::string>()->value_name("FILE"), "write it to a file")  //
      ("module", po::value<std::vector<std::string>>()->value_name("FILE.so"),
       "open a module of components by its path; may be repeated");
  return {schema_manual, options, {}};
}

int schema(const Arguments& arguments) {
  const auto values = parseOptions(schemaLine(), arguments);
  if (!values) return exit_done;
  const std::string format = (*values)["format"].as<std::string>();
  if (format != "xsd" && format != "rnc") throw UsageError(fmt::format("--format {}: expected xsd or rnc", format));
  const bool is_saved = values->count("output") > 0;
  const std::string file = is_saved ? (*values)["output"].as<std::string>() : "";
  if (is_saved) refuseToReplace(file), checkWritable(file, true);
  Session session;
  configure(session, *values);
  const Schema schema = makeSchema(session);
  const std::string text = format == "xsd" ? asXsd(schema) : asRelaxNg(schema);
  if (!is_saved) {
    fmt::print("{}", text);
    return exit_done;
  }
  try {
    writeWholeFile(file, text);
  } catch (const OutputError& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return exit_output_failed;
  }
  fmt::print("{}: {} components of {} modules\n", file, schema.components, schema.modules);
  return exit_done;
}

}  // namespace

const Subcommand schema_command{"schema", "print a schema, by which editors complete and check scenes", Group::scenes,
                                schema, schemaLine};

}  // namespace stroma::command
