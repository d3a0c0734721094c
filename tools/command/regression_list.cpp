// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/regression_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "framework/scene/text.h"
#include "tools/command/command.h"

namespace stroma::command {
namespace {

std::string caseName(const std::string& scene, const std::vector<std::string>& overrides) {
  std::string name = fs::path(scene).replace_extension().lexically_normal().string();
  for (const std::string& text : overrides) name += "+" + text.substr(text.find_first_not_of('/'));
  while (name.starts_with("../")) name.erase(0, 3);  // a folder that begins with a dot is easily overlooked
  std::ranges::replace(name, '/', '.');
  return name;
}

RegressionCase readCase(const std::string& line, const fs::path& folder) {
  std::istringstream words(line);
  RegressionCase result;
  std::string scene;
  if (!(words >> scene >> result.steps >> result.tolerance) || result.steps < 0 || !(result.tolerance >= 0) ||
      std::isinf(result.tolerance))
    throw UsageError("expected SCENE STEPS TOLERANCE [PATH.ATTR=VALUE ...]");
  if (result.tolerance >= 1)
    throw UsageError(fmt::format("the tolerance {:g} lets every state pass: expected a share of the motion below 1",
                                 result.tolerance));
  for (std::string word; words >> word;) {
    if (word == "bits=processor") {
      result.bits_of_processor = true;
      continue;
    }
    if (word == "unconverged") {
      result.accepts_unconverged = true;
      continue;
    }
    if (word.starts_with("data=")) {
      result.data.push_back(readWatchedData(word, result.tolerance));
      continue;
    }
    if (word.find('=') == std::string::npos)
      throw UsageError(fmt::format("'{}' is not PATH.ATTR=VALUE; positions and velocities are always compared", word));
    result.overrides.push_back(word);
  }
  result.scene = (folder / scene).lexically_normal().string();
  result.name = caseName(scene, result.overrides);
  return result;
}

}  // namespace

RegressionList readRegressionList(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw UsageError(fmt::format("{}: cannot open", file));
  const fs::path folder = fs::path(file).parent_path();
  RegressionList list;
  std::set<std::string> names;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line = std::string(trimmed(std::string_view(line).substr(0, line.find('#'))));
    if (line.empty()) continue;
    if (list.reference_folder.empty()) {
      list.reference_folder = (folder / line).lexically_normal().string();
      continue;
    }
    try {
      list.cases.push_back(readCase(line, folder));
      if (!names.insert(list.cases.back().name).second)
        throw UsageError("the same scene and overrides are listed twice");
    } catch (const UsageError& error) {
      throw UsageError(fmt::format("{}:{}: {}", file, number, error.what()));
    }
  }
  if (list.cases.empty()) throw UsageError(fmt::format("{}: no scene is listed", file));
  return list;
}

}  // namespace stroma::command
