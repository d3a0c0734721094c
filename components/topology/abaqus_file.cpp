// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/abaqus_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "framework/scene/diagnostics.h"
#include "framework/scene/text.h"

namespace stroma {

std::string abaqusName(std::string_view text) {
  std::string name(trimmed(text));
  std::erase(name, '"');
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return char(std::toupper(c)); });
  return name;
}

namespace {

/// A type as C3D8R begins with one of these, and no further digit follows.
bool isOneOf(const std::string& type, std::initializer_list<std::string_view> stems) {
  return std::ranges::any_of(stems, [&type](std::string_view stem) {
    return type.starts_with(stem) &&
           (type.size() == stem.size() || !std::isdigit(static_cast<unsigned char>(type[stem.size()])));
  });
}

std::optional<CellType> cellOf(const std::string& type) {
  if (isOneOf(type, {"C3D4"})) return CellType::tetrahedron;
  if (isOneOf(type, {"C3D8"})) return CellType::hexahedron;
  if (isOneOf(type, {"C3D6"})) return CellType::prism;
  if (isOneOf(type, {"C3D5"})) return CellType::pyramid;
  if (isOneOf(type, {"C3D10"})) return CellType::quadratic_tetrahedron;
  if (isOneOf(type, {"S3", "STRI3", "M3D3", "SFM3D3", "R3D3", "CPS3", "CPE3"})) return CellType::triangle;
  if (isOneOf(type, {"S4", "M3D4", "SFM3D4", "R3D4", "CPS4", "CPE4"})) return CellType::quad;
  if (isOneOf(type, {"STRI65", "S6", "M3D6", "SFM3D6", "CPS6", "CPE6"})) return CellType::quadratic_triangle;
  if (isOneOf(type, {"T3D2", "T2D2", "B31", "B21", "B33"})) return CellType::edge;
  return std::nullopt;
}

class AbaqusReader {
 public:
  explicit AbaqusReader(const std::string& file) : stream_(file), name_(file.substr(file.rfind('/') + 1)) {
    if (!stream_) throw ComponentError(fmt::format("the file {} cannot be opened", file));
  }
  AbaqusFile read();

 private:
  using Words = std::vector<std::string>;
  [[noreturn]] void fail(const std::string& message, const std::string& expected = {}) const {
    throw ComponentError(fmt::format("{}:{}: {}", name_, line_, message), expected);
  }
  bool nextLine(std::string& line);
  Words split(const std::string& line) const;
  void readKeyword(std::string line);
  const std::string& given(const char* parameter, const char* keyword) const;
  void readData(const Words& words);
  void begin();
  void readNode(const Words& words);
  void readElement(const Words& words);
  void readSet(const Words& words, std::vector<long>& set, const std::map<std::string, std::vector<long>>& sets);
  void readPart();
  void refuseParameters() const;
  void hide(const std::string& name);
  long whole(const std::string& word) const;
  double real(const std::string& word) const;
  template <class Cell>
  void addCell(std::vector<Cell>& cells, CellType type);

  std::ifstream stream_;
  std::string name_, keyword_;
  std::map<std::string, std::string> parameters_;
  long line_ = 0;
  std::optional<CellType> type_;  ///< of the elements that are read; none: they are skipped
  std::size_t wanted_ = 0;        ///< numbers of each of them
  std::vector<long> element_;     ///< numbers so far
  std::string part_, part_of_nodes_, instance_;
  std::set<std::string> of_assembly_;  ///< names of its own sets
  bool in_assembly_ = false, in_instance_ = false, is_used_ = false;
  AbaqusFile out_;
};

bool AbaqusReader::nextLine(std::string& line) {
  while (std::getline(stream_, line)) {
    if (++line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // byte order
    line = std::string(trimmed(line));
    if (!line.empty() && !line.starts_with("**")) return true;
  }
  return false;
}

AbaqusReader::Words AbaqusReader::split(const std::string& line) const {
  Words words;
  std::istringstream parts(line);
  for (std::string word; std::getline(parts, word, ',');) words.emplace_back(trimmed(word));
  return words;
}

long AbaqusReader::whole(const std::string& word) const {
  long value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    fail(inQuotes(word) + " is no number", "a whole number");
  return value;
}

double AbaqusReader::real(const std::string& word) const {
  double value = 0;
  const char* const begin = word.data() + word.starts_with('+');
  const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) fail(inQuotes(word) + " is no number", "a coordinate");
  return value;
}

const std::string& AbaqusReader::given(const char* parameter, const char* keyword) const {
  const auto found = parameters_.find(parameter);
  if (found == parameters_.end() || found->second.empty())
    fail(fmt::format("*{} has no {}", keyword, parameter), fmt::format("{}=...", parameter));
  return found->second;
}

/// "*ELEMENT, TYPE=C3D4, ELSET=LIVER", on as many lines as end with a comma.
void AbaqusReader::readKeyword(std::string line) {
  for (std::string more; line.ends_with(',') && nextLine(more);) line += more;
  const Words words = split(line.substr(1));
  keyword_ = abaqusName(words.empty() ? "" : words[0]);
  std::erase(keyword_, ' ');
  parameters_.clear();
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto equals = std::min(words[i].find('='), words[i].size());
    parameters_[abaqusName(words[i].substr(0, equals))] =
        abaqusName(words[i].substr(std::min(equals + 1, words[i].size())));
  }
  begin();
}

/// Nodes and elements of the assembly itself are reference points and the like: their numbers are others.
void AbaqusReader::begin() {
  if (!element_.empty())
    fail(fmt::format("element {} has {} nodes", element_[0], element_.size() - 1), fmt::format("{}", wanted_ - 1));
  for (const char* other : {"INCLUDE", "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM"})
    if (keyword_ == other) fail(fmt::format("*{} is not read", other), "nodes and elements one by one, in this file");
  readPart();
  const auto of_instance = parameters_.find("INSTANCE");
  is_used_ = !in_assembly_ || in_instance_ || of_instance != parameters_.end();
  refuseParameters();
  if ((keyword_ == "NSET" || keyword_ == "ELSET") && in_assembly_ && !in_instance_ && is_used_)
    hide(given(keyword_.c_str(), keyword_.c_str()));
  if (keyword_ == "ELEMENT") {
    const std::string& type = given("TYPE", "ELEMENT");
    type_ = is_used_ ? cellOf(type) : std::nullopt;
    if (!type_ && isOneOf(type, {"C3D15", "C3D20", "C3D27", "S8", "S9", "M3D8"}))
      fail(fmt::format("elements {} are not supported", type), "C3D4, C3D8, C3D10, S3, S4 and the like");
    forEachCellList(
        [&](const CellKind& kind, auto&) {
          if (type_ == kind.type) wanted_ = std::size_t(kind.nodes) + 1;
        },
        out_.mesh);
    if (const auto set = parameters_.find("ELSET"); set != parameters_.end() && is_used_) {
      auto& names = out_.element_lines;
      if (std::ranges::find(names, set->second) == names.end()) names.push_back(set->second);
    }
  }
  if (keyword_.ends_with("SECTION") && parameters_.count("ELSET")) out_.sections.push_back(parameters_["ELSET"]);
}

/// What would change the mesh.
void AbaqusReader::refuseParameters() const {
  const auto refuse = [this](const char* keyword, const char* parameter, const char* expected) {
    const auto found = parameters_.find(parameter);
    if (keyword_ == keyword && found != parameters_.end() && !(std::string_view(parameter) == "SYSTEM" && found->second == "R"))
      fail(fmt::format("*{} with {} is not read", keyword, parameter), expected);
  };
  for (const char* keyword : {"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"}) refuse(keyword, "INPUT", "its lines in this file");
  refuse("NODE", "SYSTEM", "x, y and z");
  refuse("NSET", "ELSET", "numbers of nodes");
  refuse("SURFACE", "COMBINE", "faces of elements");
}

/// A set of the assembly hides those of the part that have its name. These are INSTANCE.NAME from here on.
void AbaqusReader::hide(const std::string& name) {
  if (!of_assembly_.insert(name).second) return;
  const std::string other = instance_ + "." + name;
  for (auto* sets : {&out_.node_sets, &out_.element_sets})
    if (auto part = sets->extract(name)) part.key() = other, sets->insert(std::move(part));
  for (auto* names : {&out_.sections, &out_.element_lines}) std::ranges::replace(*names, name, other);
  for (auto& [surface, faces] : out_.surfaces)
    for (AbaqusFile::Faces& each : faces)
      if (each.of == name) each.of = other;
}

void AbaqusReader::readPart() {
  if (keyword_ == "PART") part_ = given("NAME", "PART");
  if (keyword_ == "ASSEMBLY") in_assembly_ = true, part_.clear();
  if (keyword_ == "ENDASSEMBLY") in_assembly_ = false;
  if (keyword_ == "ENDINSTANCE") in_instance_ = false;
  if (keyword_ != "INSTANCE") return;
  if (!instance_.empty()) fail("there is a second instance of a part", "one part, once: others in files of their own");
  instance_ = given("NAME", "INSTANCE"), in_instance_ = true;
}

void AbaqusReader::readNode(const Words& words) {
  if (out_.nodes.empty()) part_of_nodes_ = part_;
  if (part_ != part_of_nodes_)
    fail(fmt::format("part {} has nodes, and so has part {}", part_, part_of_nodes_),
         "one part: others in files of their own");
  const long number = whole(words[0]);
  Vec3 p = Vec3::Zero();
  for (std::size_t c = 0; c < 3 && c + 1 < words.size(); ++c)
    if (!words[c + 1].empty()) p[Eigen::Index(c)] = real(words[c + 1]);
  if (!out_.nodes.emplace(number, Index(out_.mesh.position.size())).second)
    fail(fmt::format("node {} is there twice", number));
  out_.mesh.position.push_back(p);
  if (const auto set = parameters_.find("NSET"); set != parameters_.end())
    out_.node_sets[set->second].push_back(number);
}

template <class Cell>
void AbaqusReader::addCell(std::vector<Cell>& cells, CellType type) {
  Cell cell;
  for (std::size_t k = 0; k < cell.size(); ++k) {
    const auto node = out_.nodes.find(element_[k + 1]);
    if (node == out_.nodes.end())
      fail(fmt::format("element {} names node {}, which is not there", element_[0], element_[k + 1]));
    cell[k] = node->second;
  }
  if (!out_.elements.emplace(element_[0], AbaqusFile::Place{type, Index(cells.size())}).second)
    fail(fmt::format("element {} is there twice", element_[0]));
  cells.push_back(cell);
}

/// Numbers of an element go on in the next line where one does not hold them.
void AbaqusReader::readElement(const Words& words) {
  if (!type_) {
    ++out_.skipped[parameters_["TYPE"]];
    return;
  }
  for (const std::string& word : words)
    if (!word.empty()) element_.push_back(whole(word));
  if (element_.size() < wanted_) return;
  if (element_.size() > wanted_) begin();
  forEachCellList(
      [&](const CellKind& kind, auto& cells) {
        if (kind.type == *type_) addCell(cells, kind.type);
      },
      out_.mesh);
  if (const auto set = parameters_.find("ELSET"); set != parameters_.end())
    out_.element_sets[set->second].push_back(element_[0]);
  element_.clear();
}

/// Numbers and names of other sets; with GENERATE first, last and step.
void AbaqusReader::readSet(const Words& words, std::vector<long>& set,
                           const std::map<std::string, std::vector<long>>& sets) {
  if (parameters_.count("GENERATE")) {
    if (words.size() < 2) fail("a set that is generated has one number", "first, last and step");
    constexpr long most = 20'000'000, largest = 1'000'000'000'000;
    const long first = whole(words[0]), last = whole(words[1]);
    const long step = words.size() > 2 && !words[2].empty() ? whole(words[2]) : 1;
    if (first < 0 || step < 1 || step > largest || last < first || last > largest || (last - first) / step > most)
      fail("these numbers generate no set", "first, last and step, ascending, at most 20 million");
    for (long number = first; number <= last; number += step) set.push_back(number);
    return;
  }
  for (const std::string& word : words) {
    if (word.empty()) continue;
    if (std::isdigit(static_cast<unsigned char>(word[0]))) {
      set.push_back(whole(word));
    } else {
      const auto other = sets.find(abaqusName(word));
      if (other == sets.end()) fail(fmt::format("there is no set {} before this line", word));
      if (&other->second != &set) set.insert(set.end(), other->second.begin(), other->second.end());
    }
  }
}

void AbaqusReader::readData(const Words& words) {
  if (keyword_ == "INSTANCE") {
    if (std::ranges::any_of(words, [this](const std::string& word) { return !word.empty() && real(word) != 0; }))
      out_.moved = instance_;
    return;
  }
  if (!is_used_ || words.empty()) return;
  if (keyword_ == "NODE") readNode(words);
  if (keyword_ == "ELEMENT") readElement(words);
  if (keyword_ == "NSET") readSet(words, out_.node_sets[given("NSET", "NSET")], out_.node_sets);
  if (keyword_ == "ELSET") readSet(words, out_.element_sets[given("ELSET", "ELSET")], out_.element_sets);
}

AbaqusFile AbaqusReader::read() {
  for (std::string line; nextLine(line);) {
    if (line.starts_with('*')) {
      readKeyword(line);
    } else if (keyword_ == "SURFACE") {  // of the assembly too, where it names sets of the instance
      const Words words = split(line);
      out_.surfaces[given("NAME", "SURFACE")].push_back(
          {abaqusName(words[0]), words.size() > 1 ? abaqusName(words[1]) : "", abaqusName(parameters_["TYPE"]) == "NODE"});
    } else {
      readData(split(line));
    }
  }
  keyword_.clear();
  begin();
  if (out_.nodes.empty())
    throw ComponentError(fmt::format("{} has no *NODE", name_), "an input file of Abaqus or CalculiX");
  return std::move(out_);
}

}  // namespace

AbaqusFile readAbaqus(const std::string& file) { return AbaqusReader(file).read(); }

}  // namespace stroma
