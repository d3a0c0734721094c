// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/scene/diagnostics.h"

namespace stroma::command {

std::string helpText(const Manual& manual, const OptionList& options) {
  std::ostringstream text;
  text << "usage: " << manual.usage << "\n\n"
       << manual.purpose << "\n\n"
       << options << "\nexamples:\n"
       << manual.examples;
  return text.str();
}

namespace {

std::string unknownOption(const std::string& given, const OptionList& options, const Manual& manual) {
  std::vector<std::string> names{"--help"};
  for (const auto& option : options.options()) names.push_back("--" + option->long_name());
  std::string near = nearest(given, names);
  if (near.empty() && given.starts_with("--no-"))  // what else can be left out
    for (const std::string& name : names)
      if (near.empty() && name.starts_with("--no-")) near = name;
  return fmt::format("there is no option {} ({}); usage: {}", given,
                     near.empty() ? fmt::format("options: {}", fmt::join(names, " ")) : "did you mean " + near + "?",
                     manual.usage);
}

/// A position of this name takes all words that are left.
bool takesAll(const std::string& position) { return position.ends_with("..."); }
std::string keyOf(const std::string& position) {
  return takesAll(position) ? position.substr(0, position.size() - 3) : position;
}

/// Words of one position become one text: `stroma doc boundary conditions`.
void joinWords(po::parsed_options& parsed) {
  std::vector<po::option> joined;
  for (const po::option& option : parsed.options) {
    const auto first = std::ranges::find_if(joined, [&](const po::option& other) {
      return option.position_key >= 0 && other.position_key >= 0 && other.string_key == option.string_key;
    });
    if (first == joined.end())
      joined.push_back(option);
    else
      first->value[0] += " " + option.value[0];
  }
  parsed.options = std::move(joined);
}

}  // namespace

std::optional<Values> parseOptions(const Manual& manual, const OptionList& options,
                                   const std::vector<std::string>& positions, const Arguments& arguments) {
  po::options_description all;
  all.add(options);
  all.add_options()("help,h", "this text");
  po::positional_options_description order;
  for (const std::string& position : positions) {
    all.add_options()(keyOf(position).c_str(), po::value<std::string>());
    order.add(keyOf(position).c_str(), takesAll(position) ? -1 : 1);
  }
  Values values;
  try {
    // an option must be spelled out: a prefix that is right today becomes ambiguous with the next option
    const int style = po::command_line_style::default_style & ~po::command_line_style::allow_guessing;
    po::parsed_options parsed = po::command_line_parser(arguments).options(all).positional(order).style(style).run();
    joinWords(parsed);
    po::store(parsed, values);
    po::notify(values);
  } catch (const po::unknown_option& error) {
    throw UsageError(unknownOption(error.get_option_name(), options, manual));
  } catch (const po::too_many_positional_options_error&) {
    throw UsageError(fmt::format("too many arguments; usage: {}", manual.usage));
  } catch (const po::error& error) {
    throw UsageError(fmt::format("{}; usage: {}", error.what(), manual.usage));
  }
  if (!values.count("help")) return values;
  fmt::print("{}", helpText(manual, options));
  return std::nullopt;
}

std::optional<Values> parseOptions(const CommandLine& line, const Arguments& arguments) {
  return parseOptions(line.manual, line.options, line.positions, arguments);
}

std::string required(const Values& values, const std::string& name, const Manual& manual) {
  if (values.count(name)) return values[name].as<std::string>();
  throw UsageError(fmt::format("{} is missing; usage: {}", name, manual.usage));
}

std::string textOf(const Values& values, const char* option) {
  return values.count(option) ? values[option].as<std::string>() : "";
}

}  // namespace stroma::command
