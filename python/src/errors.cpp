// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>
#include <string>

#include "bindings.hpp"
#include "device_options.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/paths.hpp"

namespace stereogrid::python {
namespace {

namespace nb = nanobind;

// Types of exceptions, with the lifetime of the process.
struct Errors {
  PyObject* config{nullptr};
  PyObject* input{nullptr};
  PyObject* device{nullptr};
};

Errors& errors() {
  static Errors types;
  return types;
}

PyObject* add_error(nb::module_& module, const char* name, const char* doc, const nb::handle bases) {
  const nb::str full_name{nb::str{"stereogrid._core."} + nb::str{name}};
  PyObject* const type{PyErr_NewExceptionWithDoc(full_name.c_str(), doc, bases.ptr(), nullptr)};
  if (type == nullptr) throw nb::python_error();
  module.attr(name) = nb::handle{type};
  return type;
}

void translate(const std::exception_ptr& caught, void*) {
  try {
    io::with_path_errors([&caught] { std::rethrow_exception(caught); });
  } catch (const ConfigError& error) {
    PyErr_SetString(errors().config, error.what());
  } catch (const InputError& error) {
    PyErr_SetString(errors().input, error.what());
  } catch (const DeviceError& error) {
    PyErr_SetString(errors().device, error.what());
  } catch (const std::runtime_error& error) {
    const std::string of_thread{app::thread_failure(error)};
    if (of_thread.empty()) throw;
    PyErr_SetString(errors().device, of_thread.c_str());
  }
}

}  // namespace

void bind_errors(nb::module_& module) {
  const nb::handle base{add_error(module, "Error", "Base of the errors of stereogrid.", nb::handle{PyExc_Exception})};
  const nb::tuple value{nb::make_tuple(base, nb::handle{PyExc_ValueError})};
  const nb::tuple system{nb::make_tuple(base, nb::handle{PyExc_OSError})};
  errors().config = add_error(module, "ConfigError", "A setting that cannot work.", value);
  errors().input = add_error(module, "InputError", "Data that cannot be used.", value);
  errors().device = add_error(module, "DeviceError",
                              "A cause outside the program, such as a full disk; trying again may help.", system);
  add_error(module, "SkippedFrameWarning", "A frame of a recording cannot be used and is skipped.",
            nb::handle{PyExc_UserWarning});
  nb::register_exception_translator(translate);
}

}  // namespace stereogrid::python
