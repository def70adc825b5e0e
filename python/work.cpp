// SPDX-License-Identifier: BSD-3-Clause
#include "work.h"

#include "xview/base/error.h"

namespace xview::python {
namespace {

std::string textOf(const py::handle& value, const std::string& key) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
    std::string text;
    for (const py::handle item : value) text += (text.empty() ? "" : ",") + textOf(item, key);
    return text;
  }
  if (PyNumber_Check(value.ptr()) == 0)
    throw UsageError(key + " is a " + std::string(py::str(py::type::of(value).attr("__name__"))) +
                     ", expected a number, a text or a list of numbers");
  return std::string(py::str(value));
}

std::string withDots(std::string key) {
  for (std::size_t at = key.find("__"); at != std::string::npos; at = key.find("__", at))
    key.replace(at, 2, ".");
  return key;
}

}  // namespace

void checkSignals() {
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw Interrupted();
}

void Work::listen() {
  tools::Audience audience;
  audience.note = [this](const std::string& note) { notes_.push_back(note); };
  audience.progress = [](std::size_t, std::size_t) { checkSignals(); };
  job_.narrate = tools::Narrative(audience);
}

std::vector<std::string> Work::takeNotes() {
  if (!notes_.empty()) {
    const py::object log = py::module_::import("logging").attr("getLogger")("xview");
    for (const std::string& note : notes_) log.attr("info")("%s", note);
  }
  return std::move(notes_);
}

void forEachOption(const py::dict& arguments,
                   const std::function<void(const std::string&, const std::string&)>& take) {
  for (const auto& [name, value] : arguments) {
    if (!py::isinstance<py::str>(name)) throw UsageError("the name of an option is no text");
    const std::string key = withDots(name.cast<std::string>());
    if (value.is_none()) continue;
    if (!py::isinstance<py::dict>(value)) {
      take(key, textOf(value, key));
      continue;
    }
    forEachOption(value.cast<py::dict>(), [&](const std::string& inner, const std::string& text) {
      take(key + "." + inner, text);
    });
  }
}

Options optionsOf(const py::dict& arguments, Options options) {
  py::dict rest = arguments.attr("copy")();
  if (rest.contains("config")) {
    const py::object config = rest.attr("pop")("config");
    if (py::isinstance<py::list>(config) || py::isinstance<py::tuple>(config)) {
      for (const py::handle path : config) applyOptionsFile(options, std::string(py::str(path)));
    } else if (!config.is_none()) {
      applyOptionsFile(options, std::string(py::str(config)));
    }
  }
  forEachOption(rest, [&](const std::string& key, const std::string& text) {
    setOption(options, key, text);
  });
  return options;
}

}  // namespace xview::python
