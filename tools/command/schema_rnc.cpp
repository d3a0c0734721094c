// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene in RELAX NG, compact syntax: what Emacs reads.
#include <fmt/format.h>

#include <map>

#include "tools/command/schema_text.h"

namespace stroma::command {
namespace {

using Kind = SchemaAlternative::Kind;

/// In double quotes. Patterns and words hold none; help is not written.
std::string inQuotes(const std::string& text) { return "\"" + text + "\""; }

/// Text as comments that a processor keeps.
std::string documentation(const std::string& indent, const std::string& text) {
  std::string out = indent + "## ";
  for (const char c : text) {
    out += c;
    if (c == '\n') out += indent + "## ";
  }
  return out + "\n";
}

class RncWriter {
 public:
  explicit RncWriter(const Schema& schema) : schema_(schema) {}

  std::string write() {
    out_ = fmt::format(
        "# SPDX-License-Identifier: LGPL-2.1-or-later\n"
        "# Scenes of Stroma {}, made by 'stroma schema --format rnc': {} components of {} modules.\n"
        "default namespace = \"\"\n"
        "namespace xsi = \"http://www.w3.org/2001/XMLSchema-instance\"\n"
        "datatypes xsd = \"http://www.w3.org/2001/XMLSchema-datatypes\"\n\n",
        schema_.version, schema_.components, schema_.modules);
    out_ += "start = ";
    for (const std::string& root : schema_.roots)
      out_ += fmt::format("{}element {} {{ attribute xsi:* {{ text }}*, node.content }}",
                          &root == &schema_.roots[0] ? "" : "\n      | ", root);
    out_ += "\n\nnode.content = type.Node, (element.Node";
    for (const SchemaElement& each : schema_.elements) out_ += " | element." + each.name;
    out_ += ")*\n";
    out_ += documentation("", schema_.node_help) + "element.Node = element Node { node.content }\n";
    for (const SchemaElement& each : schema_.elements)
      out_ += documentation("", each.help) +
              fmt::format("element.{0} = element {0} {{ type.{1} }}\n", each.name, each.type);
    shared();
    type(schema_.node);
    for (const SchemaType& each : schema_.types) type(each);
    for (const auto& [name, value] : values_) out_ += fmt::format("value.{} = {}\n", name, choice(value->alternatives));
    return std::move(out_);
  }

 private:
  /// One of the names, or none of them.
  std::string attribute(const SchemaAttribute& attribute, bool needed) {
    values_.emplace(attribute.value.name, &attribute.value);
    std::string out;
    for (const std::string& name : attribute.names)
      out += fmt::format("{}attribute {} {{ value.{} }}", out.empty() ? "" : " | ", name, attribute.value.name);
    if (attribute.names.size() > 1) out = "(" + out + ")";
    return out + (needed ? "" : "?");
  }

  void shared() {
    std::vector<std::string> parts;
    for (const SchemaAttribute& each : schema_.shared)
      if (each.names.front() != "src") parts.push_back(part(each));
    out_ += fmt::format("\nshared.attributes =\n{}\n", fmt::join(parts, ",\n"));
  }

  std::string part(const SchemaAttribute& each) {
    return documentation("  ", each.help) + "  " + attribute(each, each.required);
  }

  /// What `src` can give must be written without it.
  void type(const SchemaType& type) {
    std::vector<std::string> parts, without{"empty"}, with{"attribute src { value.text }"};
    for (const SchemaAttribute& each : type.attributes) {
      if (each.required && each.by_src)
        without.push_back(attribute(each, true)), with.push_back(attribute(each, false));
      else
        parts.push_back(part(each));
    }
    if (type.kind == SchemaType::Kind::component)
      parts.push_back(
          fmt::format("  (({}) | ({})),\n  shared.attributes", fmt::join(without, ", "), fmt::join(with, ", ")));
    if (type.kind == SchemaType::Kind::anything) parts.push_back("  attribute * - (" + namesOf(type) + ") { text }*");
    out_ += fmt::format("\ntype.{} =\n{}\n", type.name, fmt::join(parts, ",\n"));
  }

  static std::string namesOf(const SchemaType& type) {
    std::string names = "xsi:*";
    for (const SchemaAttribute& each : type.attributes)
      for (const std::string& name : each.names) names += " | " + name;
    return names;
  }

  // ---- values ----

  static std::string choice(const std::vector<SchemaAlternative>& alternatives) {
    std::string out;
    for (const SchemaAlternative& each : alternatives) out += (out.empty() ? "" : " | ") + alternative(each);
    return out;
  }

  static std::string alternative(const SchemaAlternative& each) {
    if (each.kind == Kind::list) return "list { (" + choice(each.items) + ")* }";
    if (each.kind == Kind::text) return "text";
    if (each.kind == Kind::words) {
      std::string out;
      for (const std::string& word : each.words) out += (out.empty() ? "" : " | ") + inQuotes(word);
      return out;
    }
    static const std::map<Kind, const char*> bases = {
        {Kind::boolean, "boolean"}, {Kind::integer, "int"}, {Kind::real, "double"}, {Kind::pattern, "token"}};
    std::string facets;
    if (!each.pattern.empty()) facets += " pattern = " + inQuotes(each.pattern);
    if (each.min) facets += bound("min", *each.min);
    if (each.max) facets += bound("max", *each.max);
    return fmt::format("xsd:{}{}", bases.at(each.kind), facets.empty() ? "" : " {" + facets + " }");
  }

  static std::string bound(const char* side, const SchemaBound& bound) {
    return fmt::format(" {}{} = \"{}\"", side, bound.inclusive ? "Inclusive" : "Exclusive", bound.value);
  }

  const Schema& schema_;
  std::string out_;
  std::map<std::string, const SchemaValue*> values_;
};

}  // namespace

std::string asRelaxNg(const Schema& schema) { return RncWriter(schema).write(); }

}  // namespace stroma::command
