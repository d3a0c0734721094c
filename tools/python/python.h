// SPDX-License-Identifier: LGPL-2.1-or-later
// What the sources of the Python module share. No Python object is kept in a C++ global: it would outlive the interpreter.
#pragma once
#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "framework/scene/load.h"

namespace stroma::python {

namespace py = pybind11;

// ---- values.cpp ----
/// The value of an attribute as Python has it: numbers, texts, and arrays of their own memory. `found`: of a file, where it
/// was found instead of what was written.
py::object valueOf(const Data& data, bool found = false);
/// The value of a link: the paths of what it leads to, else as written.
std::string linkText(const LinkBase& link);
/// A Python value as a scene writes it: numbers read back to the same bits. Throws py::type_error.
std::string textOf(py::handle value);
/// A large array of numbers as it is; null for what is better written as text: what is small, and what the reader has to
/// refuse (numbers that are not finite, negative or large integers).
std::shared_ptr<const Data> typedOf(py::handle value);

// ---- tree.cpp ----
/// A tree as Python hands it over: (attributes, components, children, file, line, folder), with attributes as (name, value,
/// file, line) and components as (type, attributes, file, line, folder).
SceneDescription descriptionOf(const py::tuple& root, const std::string& file);
py::tuple tupleOf(const NodeDescription& node);

// ---- errors.cpp ----
/// (severity, file, line, column, path, message, expected, suggestion, text) of each.
py::list problemsOf(const Diagnostics& diagnostics);
/// LoadNeeded of stroma/errors.py.
[[noreturn]] void raiseLoadNeeded(const Diagnostics& diagnostics);

// ---- catalogue.cpp ----
/// Components and modules for questions about types; of the whole process, and never destroyed.
struct Library {
  Factory factory;
  Modules modules{factory};
};
Library& library();
/// An attribute as a dictionary.
py::dict infoOf(const Data& data);

// ---- force_field.cpp ----
/// The components that Python plays: every factory of the module knows them.
void registerPlayed(Factory& factory);

// ---- constraint.cpp ----
void registerPlayedConstraint(Factory& factory);
/// PythonMapping: so are mappings.
void registerPlayedMapping(Factory& factory);

void bindErrors(py::module_& module);
void bindCatalogue(py::module_& module);
void bindTree(py::module_& module);
void bindEngine(py::module_& module);
void bindStates(py::module_& module);
void bindMatrices(py::module_& module);
void bindView(py::module_& module);
void bindPictures(py::module_& module);
void bindRecordings(py::module_& module);
void bindCommands(py::module_& module);
void bindGoOn(py::module_& module);

}  // namespace stroma::python
