// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sofa/declared_attributes.h"

#include <algorithm>
#include <charconv>
#include <map>

#include "framework/scene/change_table.h"
#include "framework/scene/text.h"
#include "tools/platform/text_file.h"
#include "tools/sofa/rewriting.h"

STROMA_TEXT_FILE(stroma_declared_attributes, STROMA_SOURCE "/tools/sofa/declared_attributes.txt")

namespace stroma::sofa {

namespace {

struct DeclaringClass {
  std::vector<std::string_view> bases;
  std::vector<DeclaredAttribute> attributes;
};
using Classes = std::map<std::string_view, DeclaringClass>;

/// NAME|ALIAS=DEFAULT
DeclaredAttribute attributeOf(std::string_view word) {
  DeclaredAttribute attribute;
  const std::size_t equals = word.find('=');
  if (equals != word.npos) attribute.default_text = word.substr(equals + 1);
  std::string_view names = word.substr(0, equals);
  const std::size_t first = names.find('|');
  attribute.name = names.substr(0, first);
  for (std::size_t bar = first; bar != names.npos;) {
    const std::size_t next = names.find('|', bar + 1);
    attribute.aliases.push_back(names.substr(bar + 1, next == names.npos ? next : next - bar - 1));
    bar = next;
  }
  return attribute;
}

/// visit(word) for each between blanks; defaults have commas.
template <class Visit>
void forWords(std::string_view line, Visit&& visit) {
  while (!(line = trimmed(line)).empty()) {
    const std::size_t blank = std::min(line.find(' '), line.size());
    visit(line.substr(0, blank));
    line.remove_prefix(blank);
  }
}

Classes readTable(std::string_view table) {
  Classes classes;
  DeclaringClass* current = nullptr;
  for (std::size_t start = 0; start < table.size();) {
    const std::size_t end = std::min(table.find('\n', start), table.size());
    const std::string_view line = table.substr(start, end - start);
    start = end + 1;
    if (trimmed(line).empty() || line[0] == '#') continue;
    if (line[0] != ' ') current = &classes[line.substr(0, line.find(':'))];
    if (line[0] == ' ') forWords(line, [current](std::string_view word) { current->attributes.push_back(attributeOf(word)); });
    if (line[0] != ' ') forWords(line.substr(line.find(':') + 1), [current](std::string_view word) { current->bases.push_back(word); });
  }
  return classes;
}

/// With the attributes of the bases behind those of each class.
Classes completeTable(std::string_view table) {
  Classes classes = readTable(table);
  const auto collect = [&classes](const auto& self, std::string_view name, std::vector<DeclaredAttribute>& all) -> void {
    const auto found = classes.find(name);
    if (found == classes.end()) return;
    all.insert(all.end(), found->second.attributes.begin(), found->second.attributes.end());
    for (const std::string_view base : found->second.bases) self(self, base, all);
  };
  std::map<std::string_view, std::vector<DeclaredAttribute>> complete;
  for (const auto& [name, declared] : classes) collect(collect, name, complete[name]);
  for (auto& [name, attributes] : complete) classes[name].attributes = std::move(attributes);
  return classes;
}

const Classes& allClasses() {
  static const Classes classes = completeTable(stroma_declared_attributes());
  return classes;
}

bool isSame(std::string_view value, std::string_view expected) {
  if (value == expected) return true;
  const bool is_flag = expected == "0" || expected == "1";
  if (is_flag && (saysYes(value) || saysNo(value))) return saysYes(value) == (expected == "1");
  double a = 0, b = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), a);
  const bool is_number = error == std::errc() && end == value.data() + value.size();
  return is_number && std::from_chars(expected.data(), expected.data() + expected.size(), b).ec == std::errc() && a == b;
}

}  // namespace

std::vector<std::string_view> declaringTypes() {
  std::vector<std::string_view> types;
  for (const auto& [name, declared] : allClasses())
    if (presentType(name) == name) types.push_back(name);  // MeshLoader is also an old name of a component
  return types;
}

std::string_view componentFor(std::string_view type) { return typeHere(presentType(type)); }

const std::vector<DeclaredAttribute>& declaredAttributes(std::string_view type) {
  static const std::vector<DeclaredAttribute> none;
  const auto found = allClasses().find(presentType(type));
  return found == allClasses().end() ? none : found->second.attributes;
}

const DeclaredAttribute* findDeclared(std::string_view type, std::string_view name) {
  for (const DeclaredAttribute& attribute : declaredAttributes(type))
    if (attribute.name == name || std::ranges::find(attribute.aliases, name) != attribute.aliases.end()) return &attribute;
  return nullptr;
}

bool isDefault(const DeclaredAttribute& attribute, std::string_view value) {
  if (attribute.default_text.empty()) return trimmed(value).empty();
  std::vector<std::string_view> expected;
  for (std::string_view rest = attribute.default_text; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    expected.push_back(rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  std::size_t count = 0;
  Words words(value);
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count)
    if (!isSame(word, expected[std::min(count, expected.size() - 1)])) return false;
  return count > 0;
}

}  // namespace stroma::sofa
