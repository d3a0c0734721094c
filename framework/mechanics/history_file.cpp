// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/history_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace stroma {

void HistoryFile::declare(DataTable& table) {
  table.add("history", file_)
      .input()
      .help("file that `stroma run --record` wrote of this component, to go on from its last instant");
}

std::vector<double> HistoryFile::read() const {
  if (!isGiven()) return {};
  std::ifstream file(file_.found, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::vector<double> values;
  const char *at = text.data(), *end = at + text.size();
  while (at != end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || next == end || *next != '\n')
      throw ComponentError(fmt::format("{}: line {} is no number", file_.found, values.size() + 1),
                           "a file that `stroma run --record` wrote");
    values.push_back(value);
    at = next + 1;
  }
  return values;
}

void writeHistoryFile(const std::string& path, const std::vector<double>& values) {
  std::string text;
  for (double value : values) {
    char digits[32];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr) += '\n';
  }
  const std::string partial = path + ".part";
  std::ofstream file(partial, std::ios::binary);
  file.write(text.data(), std::streamsize(text.size()));
  file.close();
  if (!file) throw std::runtime_error(partial + ": cannot write");
  std::filesystem::rename(partial, path);
}

std::string historyFileName(std::string_view component_path) {
  std::string name(component_path.substr(std::min(component_path.size(), component_path.find_first_not_of('/'))));
  std::replace(name.begin(), name.end(), '/', '.');
  return name + ".history";
}

}  // namespace stroma
