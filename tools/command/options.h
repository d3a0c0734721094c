// SPDX-License-Identifier: LGPL-2.1-or-later
// Options of a subcommand: parsing with sentences instead of codes, and --help with examples.
#pragma once
#include <fmt/format.h>

#include <boost/program_options.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/command/command.h"

namespace stroma::command {

namespace po = boost::program_options;

using Values = po::variables_map;
using OptionList = po::options_description;

/// What --help prints around the options.
struct Manual {
  std::string_view usage;     ///< "stroma run SCENE [options]"
  std::string_view purpose;   ///< a paragraph
  std::string_view examples;  ///< lines
};

/// What a subcommand takes. The name of a value says how a shell completes it: DIR or FOLDER is a folder, FILE a file,
/// FILE.html one that ends so, PATH.ATTR=VALUE an attribute of the scene on the line, and a|b one of these words.
struct CommandLine {
  Manual manual;
  OptionList options;                  ///< without --help, which all have
  std::vector<std::string> positions;  ///< names of the positional arguments, in order; NAME... takes all that is left
};

/// The values of `options` and of the positional arguments `positions` (the names of options declared hidden). Prints
/// the help and returns nothing when it was asked for. Throws UsageError with the nearest right option.
std::optional<Values> parseOptions(const Manual& manual, const OptionList& options,
                                   const std::vector<std::string>& positions, const Arguments& arguments);

std::optional<Values> parseOptions(const CommandLine& line, const Arguments& arguments);

/// The option `name`, or `otherwise` where it is not given. Throws UsageError when it is not from `low` to `high`.
template <class T>
T within(const Values& values, const char* name, T otherwise, T low, T high) {
  if (!values.count(name)) return otherwise;
  const T value = values[name].as<T>();
  if (!(value >= low && value <= high)) throw UsageError(fmt::format("--{} {}: expected {} to {}", name, value, low, high));
  return value;
}

/// The --help of a subcommand.
std::string helpText(const Manual& manual, const OptionList& options);

/// The positional argument `name`, or a UsageError that names what is missing.
std::string required(const Values& values, const std::string& name, const Manual& manual);

/// The text of an option, empty where it is not given.
std::string textOf(const Values& values, const char* option);

}  // namespace stroma::command
