// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes as trees of Python objects, and what is in them before they run.
#include <pybind11/stl.h>

#include "framework/scene/change_table.h"
#include "framework/scene/names.h"
#include "framework/scene/prefab.h"
#include "tools/python/python.h"
#include "tools/session/preview.h"

namespace stroma::python {
namespace {

AttributeDescription attributeOf(const py::tuple& attribute) {
  AttributeDescription out;
  out.name = attribute[0].cast<std::string>();
  out.where = {attribute[2].cast<std::string>(), attribute[3].cast<int>(), 0};
  out.typed = typedOf(attribute[1]);
  if (!out.typed) out.value = textOf(attribute[1]);
  return out;
}

std::vector<AttributeDescription> attributesOf(py::handle list) {
  std::vector<AttributeDescription> out;
  for (const py::handle attribute : list) out.push_back(attributeOf(py::reinterpret_borrow<py::tuple>(attribute)));
  return out;
}

ComponentDescription componentOf(const py::tuple& component) {
  ComponentDescription out;
  out.type = component[0].cast<std::string>();
  out.attributes = attributesOf(component[1]);
  out.where = {component[2].cast<std::string>(), component[3].cast<int>(), 0};
  out.folder = component[4].cast<std::string>();
  return out;
}

NodeDescription nodeOf(const py::tuple& node) {
  NodeDescription out;
  out.attributes = attributesOf(node[0]);
  for (const py::handle component : node[1])
    out.components.push_back(componentOf(py::reinterpret_borrow<py::tuple>(component)));
  for (const py::handle child : node[2]) out.children.push_back(nodeOf(py::reinterpret_borrow<py::tuple>(child)));
  out.where = {node[3].cast<std::string>(), node[4].cast<int>(), 0};
  out.folder = node[5].cast<std::string>();
  return out;
}

py::list tuplesOf(const std::vector<AttributeDescription>& attributes) {
  py::list out;
  for (const AttributeDescription& attribute : attributes)
    out.append(py::make_tuple(attribute.name, attribute.value, attribute.where.file, attribute.where.line));
  return out;
}

Component& at(const Preview& preview, const std::string& path) {
  if (Component* component = preview.find(path)) return *component;
  throw ComponentError("the scene has no component " + path);
}

py::object valueIn(Preview& preview, const std::string& path, const std::string& attribute, bool init, bool found) {
  Component& component = at(preview, path);
  if (init && !preview.ready(component)) throw SceneError(preview.problems());
  const Data* data = component.data().find(attribute);
  if (!data)
    throw ComponentError(component.type() + " has no attribute '" + attribute + "'", {},
                         nearest(attribute, component.data().names()));
  return valueOf(*data, found);
}

}  // namespace

SceneDescription descriptionOf(const py::tuple& root, const std::string& file) {
  SceneDescription description;
  description.root = nodeOf(root);
  description.file = file;
  return description;
}

py::tuple tupleOf(const NodeDescription& node) {
  py::list components, children;
  for (const ComponentDescription& component : node.components)
    components.append(py::make_tuple(component.type, tuplesOf(component.attributes), component.where.file,
                                     component.where.line, component.folder));
  for (const NodeDescription& child : node.children) children.append(tupleOf(child));
  return py::make_tuple(tuplesOf(node.attributes), components, children, node.where.file, node.where.line, node.folder);
}

void bindTree(py::module_& module) {
  module.def("read_scene", [](const std::string& file, const std::optional<std::string>& text) {
    Diagnostics diagnostics;
    const SceneDescription scene = readSceneWithPrefabs(
        file, {}, {}, knownTypes(library().factory, library().modules), diagnostics, text ? &*text : nullptr);
    if (diagnostics.hasErrors() || scene.root.where.file.empty()) throw SceneError(std::move(diagnostics));
    return tupleOf(scene.root);
  });
  module.def("text_of", [](const py::object& value) { return textOf(value); });
  py::class_<Preview>(module, "Preview")
      .def(py::init([](const py::tuple& root, const std::string& file) {
        return std::make_unique<Preview>(descriptionOf(root, file), library().factory, library().modules);
      }))
      .def("has", [](const Preview& preview, const std::string& path) { return preview.find(path) != nullptr; })
      .def("ready", [](Preview& preview, const std::string& path) { return preview.ready(at(preview, path)); })
      .def("get", &valueIn, py::arg("path"), py::arg("attribute"), py::arg("init") = true, py::arg("found") = false)
      .def("attributes",
           [](const Preview& preview, const std::string& path) {
             py::list out;
             for (const Data& data : at(preview, path).data().all()) out.append(infoOf(data));
             return out;
           })
      .def("problems", [](const Preview& preview) { return problemsOf(preview.problems()); });
}

}  // namespace stroma::python
