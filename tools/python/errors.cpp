// SPDX-License-Identifier: LGPL-2.1-or-later
// Errors of the engine as exceptions of Python: the classes are in stroma/errors.py.
#include "framework/scene/output_file.h"
#include "tools/python/python.h"

namespace stroma::python {
namespace {

const char* wordFor(Severity severity) {
  return severity == Severity::note ? "note" : severity == Severity::warning ? "warning" : "error";
}

/// Messages quote files, whose bytes need not be UTF-8.
py::str decoded(const std::string& bytes) {
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "replace"));
}

void raise(const char* type, const py::object& what) {
  const py::object kind = py::module_::import("stroma.errors").attr(type);
  PyErr_SetObject(kind.ptr(), kind(what).ptr());
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const SceneError& refused) {
    raise("SceneError", problemsOf(refused.diagnostics()));
  } catch (const ComponentError& refused) {
    Diagnostics one;
    one.error({}, {}, refused.what(), refused.expected, refused.suggestion);
    raise("SceneError", problemsOf(one));
  } catch (const OutputError& failed) {
    raise("OutputError", decoded(failed.what()));
  } catch (const std::invalid_argument& wrong) {
    PyErr_SetObject(PyExc_ValueError, decoded(wrong.what()).ptr());
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::runtime_error& failed) {
    raise("StromaError", decoded(failed.what()));
  } catch (const std::logic_error& misused) {
    raise("StromaError", decoded(misused.what()));
  }
}

}  // namespace

py::list problemsOf(const Diagnostics& diagnostics) {
  py::list list;
  for (const Problem& problem : diagnostics.problems())
    list.append(py::make_tuple(wordFor(problem.severity), decoded(problem.where.file), problem.where.line, problem.where.column,
                               decoded(problem.path), decoded(problem.message), decoded(problem.expected),
                               decoded(problem.suggestion), decoded(problem.text())));
  return list;
}

void raiseLoadNeeded(const Diagnostics& diagnostics) {
  raise("LoadNeeded", problemsOf(diagnostics));
  throw py::error_already_set();
}

void bindErrors(py::module_&) { py::register_local_exception_translator(translate); }

}  // namespace stroma::python
