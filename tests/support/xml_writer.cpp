// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/xml_writer.h"

#include <algorithm>
#include <cctype>

namespace stroma {

namespace {

void appendEscaped(std::string& out, const std::string& value) {
  for (char c : value) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\n':
        out += "&#10;";
        break;
      case '\r':
        out += "&#13;";
        break;
      case '\t':
        out += "&#9;";
        break;
      default:
        out += c;
    }
  }
}

void appendTag(std::string& out, int depth, const std::string& name,
               const std::vector<AttributeDescription>& attributes) {
  out.append(std::size_t(2 * depth), ' ');
  out += "<" + name;
  for (const AttributeDescription& attribute : attributes) {
    out += " " + attribute.name + "=\"";
    appendEscaped(out, attribute.value);
    out += '"';
  }
}

/// Whether a component of this type may be an element of this name. Others were read from <Object type="...">.
bool isTag(const std::string& type) {
  const auto begins = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_' || (c & 0x80); };
  const auto goes_on = [&](char c) {
    return begins(c) || std::isdigit(static_cast<unsigned char>(c)) || c == '-' || c == '.' || c == ':';
  };
  return type != "Node" && type != "Object" && !type.empty() && begins(type[0]) &&
         std::all_of(type.begin(), type.end(), goes_on);
}

void appendComponent(std::string& out, int depth, const ComponentDescription& component) {
  if (isTag(component.type)) {
    appendTag(out, depth, component.type, component.attributes);
  } else {
    std::vector<AttributeDescription> attributes = component.attributes;
    attributes.insert(attributes.begin(), {"type", component.type, component.where});
    appendTag(out, depth, "Object", attributes);
  }
  out += "/>\n";
}

void appendNode(std::string& out, int depth, const NodeDescription& node) {
  appendTag(out, depth, "Node", node.attributes);
  if (node.components.empty() && node.children.empty()) {
    out += "/>\n";
    return;
  }
  out += ">\n";
  for (const ComponentDescription& component : node.components) appendComponent(out, depth + 1, component);
  for (const NodeDescription& child : node.children) appendNode(out, depth + 1, child);
  out.append(std::size_t(2 * depth), ' ');
  out += "</Node>\n";
}

}  // namespace

std::string writeXml(const NodeDescription& root) {
  std::string out;
  appendNode(out, 0, root);
  return out;
}

}  // namespace stroma
