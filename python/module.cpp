// SPDX-License-Identifier: BSD-3-Clause
#include "fix.h"
#include "narrative.h"
#include "places.h"
#include "process/library_chatter.h"
#include "xview/base/error.h"

namespace xview::python {
namespace {

PyObject* error_type = nullptr;
PyObject* usage_error_type = nullptr;

void raise(PyObject* type, const std::exception& e) {
  PyErr_SetString(type, tools::oneLine(e.what()).c_str());
}

void translate(std::exception_ptr pointer) {
  try {
    std::rethrow_exception(pointer);
  } catch (const Interrupted&) {
    if (PyErr_Occurred() == nullptr) PyErr_SetNone(PyExc_KeyboardInterrupt);
  } catch (const UsageError& e) {
    raise(usage_error_type, e);
  } catch (const Error& e) {
    raise(error_type, e);
  } catch (const py::cast_error&) {
    raise(usage_error_type, UsageError("an argument, or an item of one, is of a wrong type"));
  }
}

/// pybind11 gives what was made by __new__ alone memory that nobody has filled.
void* refuseUnmade(std::size_t) {
  throw UsageError("an object that was made by __new__ alone has no content; call its class");
}

void refuseUnmadeObjects(const py::module_& module) {
  for (const auto& [name, thing] : module.attr("__dict__").cast<py::dict>()) {
    if (!PyType_Check(thing.ptr())) continue;
    auto* const type = reinterpret_cast<PyTypeObject*>(thing.ptr());
    if (py::detail::type_info* bound = py::detail::get_type_info(type))
      bound->operator_new = &refuseUnmade;
  }
}

/// xview.Error is a RuntimeError, xview.UsageError an xview.Error and a ValueError.
void bindErrors(py::module_& module) {
  error_type = PyErr_NewExceptionWithDoc(
      "xview.Error",
      "Something is not as it should be: a file, a disk, a list of poses. One line with path, "
      "place, what was expected and what was found.",
      PyExc_RuntimeError, nullptr);
  const py::tuple bases = py::make_tuple(py::handle(error_type), py::handle(PyExc_ValueError));
  usage_error_type = PyErr_NewExceptionWithDoc(
      "xview.UsageError",
      "What was asked for makes no sense: an unknown option, a value out of range, an array of "
      "another shape.",
      bases.ptr(), nullptr);
  module.attr("Error") = py::handle(error_type);
  module.attr("UsageError") = py::handle(usage_error_type);
  py::register_exception_translator(&translate);
}

}  // namespace
}  // namespace xview::python

PYBIND11_MODULE(_xview, module) {
  module.doc() = "Find where a robot is in a semantic map.";
  module.attr("__version__") = XVIEW_VERSION;
  xview::allowQuietLibraries();
  xview::python::bindErrors(module);
  xview::python::bindRecording(module);
  xview::python::bindGraph(module);
  xview::python::bindMap(module);
  xview::python::bindPlaces(module);
  xview::python::bindLocalize(module);
  xview::python::bindResearch(module);
  xview::python::refuseUnmadeObjects(module);
}
