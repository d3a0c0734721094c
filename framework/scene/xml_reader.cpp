// SPDX-License-Identifier: LGPL-2.1-or-later
// XML text to plain data. An <include> stays a component description of type "include"; resolve.cpp splices it.
#include <tinyxml2.h>

#include <filesystem>

#include "framework/scene/load.h"
#include "framework/scene/text.h"
#include "framework/scene/xml_scan.h"

namespace stroma {

namespace {

class Reader {
 public:
  Reader(const std::string& file, const XmlPositions& positions, Diagnostics& diagnostics)
      : file_(file), folder_(std::filesystem::path(file).parent_path().string()), positions_(positions), diagnostics_(diagnostics) {
    if (folder_.empty()) folder_ = ".";
  }

  /// Depth is bounded by the scan, so the recursion is too. Must be called in the order of the file.
  void readNode(const tinyxml2::XMLElement& element, NodeDescription& node) {
    node.folder = folder_;
    node.where = attributesOf(element, node.attributes);
    for (const auto* child = element.FirstChild(); child; child = child->NextSibling()) {
      reportText(*child, "<Node>");
      const auto* inner = child->ToElement();
      if (!inner) continue;
      if (inner->Name() == std::string_view("Node")) {
        readNode(*inner, node.children.emplace_back());
      } else {
        readComponent(*inner, node.components.emplace_back());
        if (node.components.back().type.empty()) node.components.pop_back();
      }
    }
  }

 private:
  SourceLocation attributesOf(const tinyxml2::XMLElement& element, std::vector<AttributeDescription>& attributes) {
    const XmlPositions::Tag& tag = positions_.tags.at(next_tag_++);
    std::size_t position = tag.first_attribute;
    for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next(), ++position) {
      const TextPosition at = positions_.attributes.at(position);
      SourceLocation where{file_, at.line, at.column};
      attributes.push_back({attribute->Name(), attribute->Value(), std::move(where)});
    }
    return {file_, tag.where.line, tag.where.column};
  }

  void readComponent(const tinyxml2::XMLElement& element, ComponentDescription& component) {
    component.folder = folder_;
    component.type = element.Name();
    component.where = attributesOf(element, component.attributes);
    if (component.type == "Object") takeType(component);
    const std::string tag = "<" + std::string(element.Name()) + ">";
    for (const auto* child = element.FirstChild(); child; child = child->NextSibling()) {
      reportText(*child, tag);
      const auto* inner = child->ToElement();
      if (!inner) continue;
      if (inner->Name() == std::string_view("Attribute"))
        takeAttribute(*inner, component);
      else
        refuseInside(*inner, tag);
    }
  }

  /// <Attribute type="NAME">VALUE</Attribute> inside a component is NAME="VALUE".
  void takeAttribute(const tinyxml2::XMLElement& element, ComponentDescription& component) {
    std::vector<AttributeDescription> own;
    const SourceLocation where = attributesOf(element, own);
    std::string name;
    for (const AttributeDescription& attribute : own)
      if (attribute.name == "type" || attribute.name == "name") name = trimmed(attribute.value);
    if (name.empty()) return diagnostics_.error(where, {}, "<Attribute> does not say which it is", "type=\"...\"");
    component.attributes.push_back({name, element.GetText() ? element.GetText() : "", where});
    for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) skip(*child);
  }

  /// <Object type="X" .../> is <X .../>.
  void takeType(ComponentDescription& component) {
    component.type.clear();
    for (auto attribute = component.attributes.begin(); attribute != component.attributes.end(); ++attribute) {
      if (attribute->name != "type") continue;
      component.type = trimmed(attribute->value);
      component.attributes.erase(attribute);
      break;
    }
    if (component.type.empty()) diagnostics_.error(component.where, {}, "<Object> does not say which component it is", "type=\"...\"");
  }

  void refuseInside(const tinyxml2::XMLElement& element, const std::string& tag) {
    std::vector<AttributeDescription> unused;
    const SourceLocation where = attributesOf(element, unused);
    diagnostics_.error(where, {}, "<" + std::string(element.Name()) + "> stands inside " + tag + ", a component",
                       "components beside each other in a <Node>");
    for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) skip(*child);
  }

  void skip(const tinyxml2::XMLElement& element) {
    ++next_tag_;
    for (const auto* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) skip(*child);
  }

  void reportText(const tinyxml2::XMLNode& node, const std::string& tag) {
    const auto* text = node.ToText();
    if (!text || trimmed(text->Value()).empty()) return;
    diagnostics_.warning({file_, text->GetLineNum(), 0}, {},
                         "the text " + inQuotes(trimmed(text->Value())) + " inside " + tag + " has no meaning");
  }

  const std::string& file_;
  std::string folder_;
  const XmlPositions& positions_;
  Diagnostics& diagnostics_;
  std::size_t next_tag_ = 0;
};

/// Where the outermost element says which schema it follows: nothing for the scene.
bool isForEditors(std::string_view name) { return name.starts_with("xmlns:") || name.starts_with("xsi:"); }

/// Processing instructions are for editors too, and tinyxml2 takes them before comments only. Places stay what they are.
std::string withoutInstructions(std::string text, const XmlPositions& positions) {
  for (const auto& [begin, end] : positions.instructions)
    for (std::size_t i = begin; i < end; ++i)
      if (text[i] != '\n') text[i] = ' ';
  return text;
}

}  // namespace

NodeDescription readXml(const std::string& text, const std::string& file, const ReadLimits& limits, Diagnostics& diagnostics) {
  NodeDescription root;
  XmlPositions positions;
  const auto megabytes = [](std::size_t bytes) { return std::to_string(bytes >> 20) + " MB"; };
  if (text.size() > limits.file_bytes) {
    // The first bytes may say which attribute is to blame.
    Diagnostics scratch;
    XmlPositions unused;
    if (!scanXml(std::string_view(text).substr(0, limits.file_bytes), file, limits, unused, scratch) &&
        scratch.problems().front().message.find("longer than") != std::string::npos) {
      diagnostics.add(scratch.problems().front());
    } else {
      diagnostics.error({file, 1, 1}, {}, "the file is larger than " + megabytes(limits.file_bytes),
                        "meshes in separate files, read by a loader");
    }
    return root;
  }
  if (!scanXml(text, file, limits, positions, diagnostics)) return root;

  tinyxml2::XMLDocument document;
  const std::string changed = positions.instructions.empty() ? std::string() : withoutInstructions(text, positions);
  const std::string& plain = positions.instructions.empty() ? text : changed;
  if (document.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS) {
    diagnostics.error({file, document.ErrorLineNum(), 0}, {}, std::string("this is not well-formed XML: ") + document.ErrorName());
    return root;
  }
  const tinyxml2::XMLElement* top = document.RootElement();
  const std::string_view tag = top->Name();
  const SourceLocation where{file, positions.tags[0].where.line, positions.tags[0].where.column};
  const bool is_group = tag == "Group" || tag == "_Group_" || tag == "_Merge_";
  if (tag != "Node" && !is_group) {
    diagnostics.error(where, {}, "the root element is <" + std::string(tag) + ">", "<Node>", nearest(tag, {"Node"}));
    return root;
  }
  if (top->NextSiblingElement()) {
    diagnostics.error({file, top->NextSiblingElement()->GetLineNum(), 0}, {}, "a second root element",
                      "one <Node> that contains everything");
    return root;
  }
  Reader(file, positions, diagnostics).readNode(*top, root);
  std::erase_if(root.attributes, [](const AttributeDescription& attribute) { return isForEditors(attribute.name); });
  if (is_group) {  // whatever its name
    std::erase_if(root.attributes, [](const AttributeDescription& attribute) { return attribute.name == "name"; });
    root.attributes.push_back({"name", std::string(tag), where});
  }
  return root;
}

}  // namespace stroma
