// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "narrative.h"
#include "tool.h"
#include "xview/options.h"

namespace xview::python {

namespace py = pybind11;

/// The user wants an end (Ctrl-C); the error of Python is set already.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// Throws Interrupted if a signal came whose handler raises. May be called with and without the
/// interpreter's lock.
void checkSignals();

/// What a piece of work is done with: options, and ears for its notes. Signals are looked at after
/// every frame.
class Work {
 public:
  explicit Work(Options options) {
    job_.options = std::move(options);
    listen();
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  const tools::Job& job() const { return job_; }
  tools::Job& job() { return job_; }
  /// Hands the notes so far to the logger "xview" as well.
  std::vector<std::string> takeNotes();

 private:
  void listen();
  tools::Job job_;
  std::vector<std::string> notes_;
};

/// Runs without the interpreter's lock.
template <class Function>
auto released(Function&& function) {
  const py::gil_scoped_release release;
  return function();
}

/// Keys and values of keyword arguments as text: walks={"num_walks": 100}, walks__num_walks=100 and
/// **{"walks.num_walks": 100} are one. Numbers, booleans, texts, and sequences of numbers ("a,b").
void forEachOption(const py::dict& arguments,
                   const std::function<void(const std::string&, const std::string&)>& take);

/// The options with keyword arguments set; `config` names YAML files or shipped sets of options,
/// which are read first. Throws UsageError, Error.
Options optionsOf(const py::dict& arguments, Options options = {});

}  // namespace xview::python
