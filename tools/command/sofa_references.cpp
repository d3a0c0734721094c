// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/sofa_references.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "framework/scene/files.h"
#include "framework/scene/text.h"

namespace stroma::command {
namespace {

namespace fs = std::filesystem;

/// The text of a file, compressed or not.
std::string unpacked(const std::string& file) {
  gzFile stream = gzopen(file.c_str(), "rb");
  if (!stream) throw std::runtime_error(file + " cannot be opened");
  std::string text;
  char piece[65536];
  int count = 0;
  while ((count = gzread(stream, piece, sizeof piece)) > 0) text.append(piece, std::size_t(count));
  int code = Z_OK;
  const std::string why = gzerror(stream, &code);
  const bool whole = gzclose(stream) == Z_OK && count == 0 && (code == Z_OK || code == Z_STREAM_END);
  if (!whole) throw std::runtime_error(fmt::format("{} is damaged or cut short ({})", file, why));
  if (text.empty()) throw std::runtime_error(file + " is empty");
  return text;
}

double numberIn(std::string_view word, const std::string& file) {
  double value = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (code != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw std::runtime_error(fmt::format("{}: '{}' is no finite number", file, word.substr(0, 40)));
  return value;
}

std::vector<double> numbersIn(std::string_view text, const std::string& file) {
  std::vector<double> numbers;
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) numbers.push_back(numberIn(word, file));
  return numbers;
}

/// "T= 0.1", then "X= x y z ...".
void readText(const std::string& text, const std::string& file, SofaReference& reference) {
  std::istringstream lines(text);
  double time = std::nan("");
  for (std::string line; std::getline(lines, line);) {
    const std::string_view clean = trimmed(line);
    if (clean.starts_with("T=")) {
      time = numberIn(trimmed(clean.substr(2)), file);
    } else if (clean.starts_with("X=")) {
      if (std::isnan(time)) throw std::runtime_error(file + ": positions before a time");
      reference.positions[time] = numbersIn(clean.substr(2), file);
    }
  }
}

void flatten(const nlohmann::json& value, const std::string& file, std::vector<double>& out) {
  if (value.is_number()) {
    out.push_back(value.get<double>());
    if (!std::isfinite(out.back())) throw std::runtime_error(file + ": a number is not finite");
  } else if (value.is_array()) {
    for (const auto& item : value) flatten(item, file, out);
  } else {
    throw std::runtime_error(file + ": a position is no number");
  }
}

/// Times and positions, {"0.1": [[x, y, z], ...]}.
void readJson(const std::string& text, const std::string& file, SofaReference& reference) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) throw std::runtime_error(file + " is no JSON of times and positions");
  for (const auto& [key, value] : json.items()) {
    double time = 0;
    const auto [end, code] = std::from_chars(key.data(), key.data() + key.size(), time);
    if (code == std::errc() && end == key.data() + key.size()) flatten(value, file, reference.positions[time]);
  }
}

/// A row for each time: the time, then all numbers. Lines that begin with a letter or # are of the file itself.
void readCsv(const std::string& text, const std::string& file, SofaReference& reference) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::replace_if(line.begin(), line.end(), [](char c) { return c == ';' || c == '"' || c == '[' || c == ']'; }, ' ');
    const std::string_view clean = trimmed(line);
    if (clean.empty() || clean[0] == '#' || std::isalpha(static_cast<unsigned char>(clean[0]))) continue;
    std::vector<double> row = numbersIn(clean, file);
    if (row.size() < 2) continue;
    reference.positions[row[0]].assign(row.begin() + 1, row.end());
  }
}

/// Of "scene.scn.reference_mstate_3_dofs.json.gz" and "scene.scn.reference_3_dofs_mstate.txt.gz": 3 and dofs.
void readName(const std::string& file, SofaReference& reference) {
  std::string name = fs::path(file).filename().string();
  name = name.substr(name.find(".reference_") + 11);
  for (const char* ending : {".gz", ".json", ".csv", ".txt", "_mstate"})
    if (name.ends_with(ending)) name.resize(name.size() - std::string(ending).size());
  if (name.starts_with("mstate_")) name = name.substr(7);
  const auto bar = name.find('_');
  if (bar == std::string::npos) throw std::runtime_error(file + ": the name does not say whose state it is");
  reference.number = int(numberIn(name.substr(0, bar), file));
  reference.state = name.substr(bar + 1);
}

std::string fromEnvironment(const std::string& path) {
  if (!path.starts_with("$")) return path;
  const auto slash = std::min(path.find('/'), path.size());
  const char* value = std::getenv(path.substr(1, slash - 1).c_str());
  return value ? value + path.substr(slash) : path;
}

std::string findScene(const std::string& name, const fs::path& folder) {
  if (fs::exists(folder / name)) return (folder / name).lexically_normal().string();
  if (const char* folders = std::getenv("REGRESSION_SCENES_DIR")) {
    std::istringstream list(folders);
    for (std::string each; std::getline(list, each, '|');)
      if (fs::exists(fs::path(each) / name)) return (fs::path(each) / name).lexically_normal().string();
  }
  const std::string found = findFileIn(name, folder.string(), environmentDataPaths(), nullptr);
  return found.empty() ? (folder / name).lexically_normal().string() : found;
}

std::vector<std::string> referencesOf(const std::string& scene, const fs::path& references) {
  std::vector<std::string> files;
  const fs::path nested = references / scene;
  const std::string start = nested.filename().string() + ".reference_";
  std::error_code none;
  const auto take = [&](const fs::directory_entry& entry) {
    if (entry.path().filename().string().starts_with(start)) files.push_back(entry.path().string());
  };
  for (const auto& entry : fs::directory_iterator(nested.parent_path(), none)) take(entry);
  if (files.empty())
    for (const auto& entry : fs::recursive_directory_iterator(references, none)) take(entry);
  std::sort(files.begin(), files.end());
  return files;
}

/// A line of a list: SOFA's reader needs three words of it.
SofaCase caseOf(const std::string& line, const std::string& where) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  const auto refuse = [&](const std::string& what) -> double {
    throw std::runtime_error(fmt::format("{}: {}: expected SCENE STEPS EPSILON [0|1] [0|1] [PERIOD]", where, what));
  };
  if (words.size() < 3 || words.size() > 6) refuse(fmt::format("the line has {} words", words.size()));
  const auto number = [&](std::size_t i, const char* what, const auto& fits) {
    double value = 0;
    const std::string& word = words[i];
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool is_number = code == std::errc() && end == word.data() + word.size() && std::isfinite(value);
    return is_number && fits(value) ? value : refuse(fmt::format("'{}' is {}", word, what));
  };
  const auto is_sign = [](double value) { return value == 0 || value == 1; };
  SofaCase one;
  one.name = words[0];
  constexpr double most_steps = 1e12;
  one.steps = long(number(1, "no number of steps", [](double n) { return n >= 1 && n <= most_steps && n == std::floor(n); }));
  one.epsilon = number(2, "no tolerance", [](double epsilon) { return epsilon >= 0; });
  if (words.size() > 3) one.mapped_too = number(3, "neither 0 nor 1", is_sign) == 1;
  if (words.size() > 4) one.last_only = number(4, "neither 0 nor 1", is_sign) == 1;
  if (words.size() > 5) one.period = number(5, "no period", [](double period) { return period >= 0; });
  return one;
}

}  // namespace

bool isSofaList(const std::string& file) { return file.ends_with(".regression-tests"); }

std::vector<std::string> sofaListsIn(const std::string& folder) {
  std::vector<std::string> lists;
  int without_states = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (const std::string name = entry.path().filename().string(); entry.is_regular_file() && isSofaList(name))
      name.find("Topology") == std::string::npos ? lists.push_back(entry.path().string()) : void(++without_states);
  if (without_states > 0) fmt::print("{} of topologies left out: nothing in them is compared with states\n", without_states);
  std::sort(lists.begin(), lists.end());
  if (lists.empty())
    throw std::runtime_error(folder + " is a folder without lists of SOFA: expected a list, or a folder with *.regression-tests in it");
  return lists;
}

std::vector<SofaCase> readSofaList(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error(file + " cannot be opened");
  const fs::path folder = fs::absolute(file).parent_path();
  std::vector<SofaCase> cases;
  fs::path references;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line = std::string(trimmed(std::string_view(line).substr(0, line.find('#'))));
    if (line.empty()) continue;
    if (references.empty()) {
      references = folder / fromEnvironment(line);
      continue;
    }
    SofaCase one = caseOf(line, fmt::format("{}:{}", file, number));
    one.scene = findScene(one.name, folder);
    one.references = referencesOf(one.name, references);
    cases.push_back(std::move(one));
  }
  if (cases.empty()) throw std::runtime_error(file + ": no scene is listed");
  return cases;
}

SofaReference readSofaReference(const std::string& file) {
  SofaReference reference;
  readName(file, reference);
  const std::string text = unpacked(file);
  if (file.find(".json") != std::string::npos)
    readJson(text, file, reference);
  else if (file.find(".csv") != std::string::npos)
    readCsv(text, file, reference);
  else
    readText(text, file, reference);
  if (reference.positions.empty()) throw std::runtime_error(file + " holds no positions");
  for (const auto& [time, values] : reference.positions)
    if (values.empty() || values.size() != reference.positions.begin()->second.size())
      throw std::runtime_error(fmt::format("{}: at t = {:g} there are {} numbers instead of {}", file, time, values.size(),
                                           reference.positions.begin()->second.size()));
  return reference;
}

}  // namespace stroma::command
