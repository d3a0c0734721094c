// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene as an XML Schema 1.0. The outermost element is global, all others are local to a node, so that a component is
// no document of its own. An attribute is required only where it has one name: the rest is the command's.
#include <fmt/format.h>

#include <map>

#include "tools/command/schema_text.h"
#include "tools/session/xml_text.h"

namespace stroma::command {
namespace {

using Kind = SchemaAlternative::Kind;

class XsdWriter {
 public:
  explicit XsdWriter(const Schema& schema) : schema_(schema) {}

  std::string write() {
    line(0, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    line(0, "<!-- SPDX-License-Identifier: LGPL-2.1-or-later -->");
    line(0, "<!-- Scenes of Stroma {0}, made by 'stroma schema': {1} components of {2} modules. -->", schema_.version,
         schema_.components, schema_.modules);
    line(0, "<xs:schema xmlns:xs=\"http://www.w3.org/2001/XMLSchema\" version=\"{}\">", schema_.version);
    for (const std::string& root : schema_.roots) element(1, root, "Node", schema_.node_help);
    nodeContent();
    line(1, "<xs:attributeGroup name=\"shared.attributes\">");
    for (const SchemaAttribute& each : schema_.shared) attribute(each, each.names.front());
    line(1, "</xs:attributeGroup>");
    type(schema_.node);
    for (const SchemaType& each : schema_.types) type(each);
    for (const auto& [name, value] : values_) simpleType(1, &name, value->alternatives);
    line(0, "</xs:schema>");
    return std::move(out_);
  }

 private:
  template <class... Values>
  void line(int depth, fmt::format_string<Values...> text, Values&&... values) {
    out_.append(std::size_t(2 * depth), ' ');
    fmt::format_to(std::back_inserter(out_), text, std::forward<Values>(values)...);
    out_ += '\n';
  }

  void help(int depth, const std::string& text) {
    line(depth, "<xs:annotation><xs:documentation>{}</xs:documentation></xs:annotation>", xmlText(text));
  }

  /// Names of types have a prefix: an element may be called as a value is.
  void element(int depth, const std::string& name, const std::string& type_name, const std::string& text) {
    line(depth, "<xs:element name=\"{}\" type=\"{}.attributes\">", name, type_name);
    help(depth + 1, text);
    line(depth, "</xs:element>");
  }

  void nodeContent() {
    line(1, "<xs:group name=\"node.content\">");
    line(2, "<xs:choice>");
    line(3, "<xs:element ref=\"Node\"/>");
    for (const SchemaElement& each : schema_.elements) element(3, each.name, each.type, each.help);
    line(2, "</xs:choice>");
    line(1, "</xs:group>");
  }

  void type(const SchemaType& type) {
    line(1, "<xs:complexType name=\"{}.attributes\">", type.name);
    if (type.kind == SchemaType::Kind::node)
      line(2, "<xs:group ref=\"node.content\" minOccurs=\"0\" maxOccurs=\"unbounded\"/>");
    for (const SchemaAttribute& each : type.attributes)
      for (const std::string& name : each.names) attribute(each, name);
    if (type.kind == SchemaType::Kind::component) line(2, "<xs:attributeGroup ref=\"shared.attributes\"/>");
    if (type.kind == SchemaType::Kind::anything)
      line(2, "<xs:anyAttribute namespace=\"##local\" processContents=\"skip\"/>");
    line(1, "</xs:complexType>");
  }

  void attribute(const SchemaAttribute& attribute, const std::string& name) {
    const bool alone = attribute.names.size() == 1;
    values_.emplace(attribute.value.name, &attribute.value);
    line(2, "<xs:attribute name=\"{}\" type=\"{}\"{}>", name, attribute.value.name,
         attribute.required && alone ? " use=\"required\"" : "");
    help(3, name == attribute.names.front() ? attribute.help
                                            : "The same as " + attribute.names.front() + ". " + attribute.help);
    line(2, "</xs:attribute>");
  }

  // ---- values ----

  /// With a name, or inside another one.
  void simpleType(int depth, const std::string* name, const std::vector<SchemaAlternative>& alternatives) {
    line(depth, "<xs:simpleType{}>", name ? " name=\"" + *name + "\"" : "");
    if (alternatives.size() == 1) {
      alternative(depth + 1, alternatives[0]);
    } else {
      line(depth + 1, "<xs:union>");
      for (const SchemaAlternative& each : alternatives) simpleType(depth + 2, nullptr, {each});
      line(depth + 1, "</xs:union>");
    }
    line(depth, "</xs:simpleType>");
  }

  void alternative(int depth, const SchemaAlternative& each) {
    if (each.kind == Kind::list) {
      line(depth, "<xs:list>");
      simpleType(depth + 1, nullptr, each.items);
      return line(depth, "</xs:list>");
    }
    static const std::map<Kind, const char*> bases = {{Kind::text, "string"}, {Kind::boolean, "boolean"},
                                                      {Kind::integer, "int"}, {Kind::real, "double"},
                                                      {Kind::words, "token"}, {Kind::pattern, "token"}};
    line(depth, "<xs:restriction base=\"xs:{}\">", bases.at(each.kind));
    for (const std::string& word : each.words) line(depth + 1, "<xs:enumeration value=\"{}\"/>", xmlText(word));
    if (!each.pattern.empty()) line(depth + 1, "<xs:pattern value=\"{}\"/>", xmlText(each.pattern));
    if (each.min) bound(depth + 1, "min", *each.min);
    if (each.max) bound(depth + 1, "max", *each.max);
    line(depth, "</xs:restriction>");
  }

  void bound(int depth, const char* side, const SchemaBound& bound) {
    line(depth, "<xs:{}{} value=\"{}\"/>", side, bound.inclusive ? "Inclusive" : "Exclusive", bound.value);
  }

  const Schema& schema_;
  std::string out_;
  std::map<std::string, const SchemaValue*> values_;
};

}  // namespace

std::string asXsd(const Schema& schema) { return XsdWriter(schema).write(); }

}  // namespace stroma::command
