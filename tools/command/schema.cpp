// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma schema: what editors complete and check scenes with.
#include <fmt/format.h>

#include <fstream>

#include "tools/command/schema_text.h"
#include "tools/command/session.h"

namespace po = boost::program_options;

namespace stroma::command {
namespace {

const Manual manual{
    "stroma schema [options]",
    "Prints a schema of scenes, made from the attributes of all components: editors complete and check with it. A "
    "scene\n"
    "names it on its outermost element:\n"
    "  <Node xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation=\"stroma.xsd\">\n"
    "`stroma check` knows more than a schema can say: links, files, what goes together.",
    "  stroma schema -o stroma.xsd\n  stroma schema --format rnc -o stroma.rnc\n"
    "  stroma schema --module ./springs.so -o stroma.xsd\n"};

void save(const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text << std::flush;
  if (!out) throw UsageError(fmt::format("{} cannot be written", file));
}

CommandLine line() {
  OptionList options("options");
  options.add_options()  //
      ("format", po::value<std::string>()->value_name("xsd|rnc")->default_value("xsd"),
       "xsd: W3C XML Schema 1.0; rnc: RELAX NG, compact syntax")                        //
      ("output,o", po::value<std::string>()->value_name("FILE"), "write it to a file")  //
      ("module", po::value<std::vector<std::string>>()->value_name("FILE.so"),
       "open a module of components by its path; may be repeated");
  return {manual, options, {}};
}

int schema(const Arguments& arguments) {
  const auto values = parseOptions(line(), arguments);
  if (!values) return exit_done;
  const std::string format = (*values)["format"].as<std::string>();
  if (format != "xsd" && format != "rnc") throw UsageError(fmt::format("--format {}: expected xsd or rnc", format));
  Session session;
  configure(session, *values);
  const Schema schema = makeSchema(session);
  const std::string text = format == "xsd" ? asXsd(schema) : asRelaxNg(schema);
  if (!values->count("output")) {
    fmt::print("{}", text);
    return exit_done;
  }
  const std::string file = (*values)["output"].as<std::string>();
  save(file, text);
  fmt::print("{}: {} components of {} modules\n", file, schema.components, schema.modules);
  return exit_done;
}

}  // namespace

const Subcommand schema_command{"schema", "print a schema, by which editors complete and check scenes", Group::scenes,
                                schema, line};

}  // namespace stroma::command
